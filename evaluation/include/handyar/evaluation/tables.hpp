// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "handyar/evaluation/analysis.hpp"

namespace handyar::evaluation {

/// One number of the report: one row of tables.csv. NaN: not known.
struct Figure {
  std::string row, column, unit;
  double value;
};

/// A table of the report is its figures, laid out by row and column in the order of first mention.
struct Table {
  std::string id;        ///< "table1", "robustness", ...
  std::string sequence;  ///< "all" for a table over several
  std::string title, caption;
  std::vector<Figure> figures;

  void add(const std::string& row, const std::string& column, double value,
           const std::string& unit = "") {
    figures.push_back({row, column, unit, value});
  }
};

// The paper's (3.1, 3.2), each with the paper's own figures in columns of their own.
Table table1(std::span<const Analysis> analyses, const std::string& sequence);
Table table2(const Analysis& analysis);
Table table3(const Analysis& analysis);

// Against truth; only for a sequence that has it.
Table accuracy_table(const Analysis& analysis);
Table tracking_table(const Analysis& analysis);
Table motion_table(const Analysis& analysis);  ///< jitter while still, delay
Table recovery_table(const Analysis& analysis);
Table view_table(const Analysis& analysis);  ///< error against tilt and distance

// One row a sequence.
Table robustness_table(const std::vector<Analysis>& analyses);

/// A number as both CSV files write it: six significant digits, empty when not finite.
std::string csv_number(double value);
std::string csv_field(const std::string& text);
/// The fields of a line of CSV, those in quotes as csv_field() wrote them.
std::vector<std::string> csv_fields(std::string_view line);

/// Writes tables.csv: the header, then the figures of all tables in order, so that figure i is in
/// line i + 2. Throws io::Error.
void write_tables_csv(const std::string& file, const std::vector<Table>& tables);

}  // namespace handyar::evaluation
