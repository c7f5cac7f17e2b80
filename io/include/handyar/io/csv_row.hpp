// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

namespace handyar::io {

// Digits after the point: a thousandth of a pixel, a ten-millionth of a metre.
inline constexpr int kPixelDigits = 3, kRotationDigits = 9, kMetreDigits = 7, kTimeDigits = 6,
                     kMillisecondDigits = 4, kSigmaDigits = 9;

/// Fields with commas between them, the same whatever the locale; a number that is not finite is an
/// empty field.
class CsvRow {
 public:
  void text(std::string_view field) {
    if (!line_.empty()) line_ += ',';
    line_ += field;
  }
  void number(double value, int digits) {
    char buffer[64];
    const auto [end, fault] =
        std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits);
    const bool good = std::isfinite(value) && fault == std::errc();
    text(good ? std::string_view(buffer, static_cast<std::size_t>(end - buffer)) : "");
  }
  void empty(int count) {
    for (int i = 0; i < count; ++i) text("");
  }
  void pose(const Eigen::Isometry3d& T) {
    Eigen::Quaterniond q(T.rotation());
    // q and -q are one rotation. A hand that faces the camera is near (0, 1, 0, 0): with that sign
    // the numbers run on smoothly from row to row.
    if (q.x() < 0) q.coeffs() = -q.coeffs();
    for (const double x : {q.w(), q.x(), q.y(), q.z()}) number(x, kRotationDigits);
    for (int i = 0; i < 3; ++i) number(T.translation()[i], kMetreDigits);
  }
  std::string take() { return std::move(line_); }

 private:
  std::string line_;
};

}  // namespace handyar::io
