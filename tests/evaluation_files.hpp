// SPDX-License-Identifier: MIT
// What tests of the evaluation read and write.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "handyar/evaluation/tables.hpp"
#include "handyar/io/sample.hpp"
#include "temporary_folder.hpp"

namespace handyar::evaluation {

namespace fs = std::filesystem;

inline std::string shipped(const std::string& name) {
  return fs::path(io::data_file(name + "/truth.json")).parent_path().string();
}

using test::TemporaryFolder;

inline std::vector<std::string> lines_of(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

inline std::string text_of(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

inline double value_of(const Table& t, const std::string& row, const std::string& column) {
  for (const Figure& f : t.figures)
    if (f.row == row && f.column == column) return f.value;
  ADD_FAILURE() << t.id << " has no " << row << ", " << column;
  return kUnknown;
}

}  // namespace handyar::evaluation
