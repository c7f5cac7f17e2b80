// SPDX-License-Identifier: MIT
#include "annotated_list.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "handyar/evaluation/tables.hpp"
#include "handyar/io/error.hpp"

namespace handyar::evaluation {
namespace {

constexpr double kFarthest = 1e6;  ///< no annotation lies beyond
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// The number that all of the text is.
template <typename Number>
std::optional<Number> number_of(const std::string& text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, value);
  if (fault != std::errc() || stop != end) return std::nullopt;
  return value;
}

}  // namespace

AnnotatedList::AnnotatedList(const std::string& file) : file_(file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  if (!in.is_open() || in.bad()) throw io::Error(file, "cannot be read");
  if (line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
  const std::vector<std::string> header = csv_fields(line);
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (line.empty() || line == "\r") continue;
    const std::vector<std::string> fields = csv_fields(line);
    if (fields.size() != header.size())
      throw io::Error(file, "line " + std::to_string(number) + " has " +
                                std::to_string(fields.size()) + " fields, the header " +
                                std::to_string(header.size()));
    Row& row = rows_.emplace_back();
    row.line = number;
    for (std::size_t i = 0; i < header.size(); ++i) row.fields[header[i]] = fields[i];
  }
  if (rows_.empty()) throw io::Error(file, "names no picture");
}

void AnnotatedList::fail(const Row& row, const std::string& fault) const {
  throw io::Error(file_, "line " + std::to_string(row.line) + ": " + fault);
}

const std::string& AnnotatedList::field(const Row& row, const std::string& column) const {
  const auto at = row.fields.find(column);
  if (at == row.fields.end()) throw io::Error(file_, "has no column " + column);
  return at->second;
}

int AnnotatedList::frame(const Row& row, const std::string& column) const {
  const std::string& text = field(row, column);
  const std::optional<int> value = number_of<int>(text);
  if (!value || *value < 0) fail(row, column + " is not a frame's number: \"" + text + "\"");
  return *value;
}

bool AnnotatedList::flag(const Row& row, const std::string& column) const {
  const std::string& text = field(row, column);
  if (text != "0" && text != "1") fail(row, column + " is neither 0 nor 1: \"" + text + "\"");
  return text == "1";
}

double AnnotatedList::pixel(const Row& row, const std::string& column) const {
  const std::string& text = field(row, column);
  const std::optional<double> value = number_of<double>(text);
  if (!value || !(std::abs(*value) <= kFarthest))
    fail(row, column + " is not a pixel: \"" + text + "\"");
  return *value;
}

std::array<Eigen::Vector2d, kFingerCount> AnnotatedList::tips_px(const Row& row) const {
  std::array<Eigen::Vector2d, kFingerCount> tips;
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const std::string finger(kFingerNames[i]);
    tips[i] = {pixel(row, finger + "_x"), pixel(row, finger + "_y")};
  }
  if ((tips.front() - tips.back()).norm() < 1)
    fail(row, "thumb and little finger are at the same place");
  return tips;
}

}  // namespace handyar::evaluation
