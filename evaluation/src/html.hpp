// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "handyar/evaluation/analysis.hpp"
#include "handyar/evaluation/pictures.hpp"
#include "handyar/evaluation/tables.hpp"

// The parts of report.html; the page's frame, its style and its script are in page/.
namespace handyar::evaluation::html {

std::string escape(const std::string& text);

/// A table whose first figure stands in line `csv_line` of tables.csv; each cell says its line.
std::string table(const Table& t, int csv_line);

/// Places for the charts of a sequence and their data, which page/report.js draws.
std::string charts(const Analysis& a);

std::string pictures(const std::vector<Picture>& pictures, bool with_truth);

}  // namespace handyar::evaluation::html
