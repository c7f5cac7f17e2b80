// SPDX-License-Identifier: MIT
// A person's list of pictures or frames with their fingertips: a CSV file with a header.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "handyar/hand_model.hpp"

namespace handyar::evaluation {

class AnnotatedList {
 public:
  struct Row {
    std::size_t line;  ///< in the file, from 1
    std::map<std::string, std::string> fields;
  };

  /// Throws io::Error.
  explicit AnnotatedList(const std::string& file);

  const std::string& file() const { return file_; }
  const std::vector<Row>& rows() const { return rows_; }

  // Each throws io::Error, which names the file, the line and what is wrong with it.
  const std::string& field(const Row& row, const std::string& column) const;
  /// A number of a frame of a video, from 0.
  int frame(const Row& row, const std::string& column) const;
  /// 0 or 1.
  bool flag(const Row& row, const std::string& column) const;
  /// thumb_x ... little_y, in pixels; thumb and little finger apart.
  std::array<Eigen::Vector2d, kFingerCount> tips_px(const Row& row) const;
  [[noreturn]] void fail(const Row& row, const std::string& fault) const;

 private:
  double pixel(const Row& row, const std::string& column) const;

  std::string file_;
  std::vector<Row> rows_;
};

}  // namespace handyar::evaluation
