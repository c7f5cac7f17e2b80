// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "handyar/evaluation/tables.hpp"

namespace handyar::evaluation {

/// A table as a person reads it: its figures in rows and columns, each with as many digits as mean
/// something, units in the head of a column where all of it shares one.
struct TableLayout {
  struct Cell {
    std::string text;  ///< empty: no such figure
    std::string unit;  ///< where the column's figures have different ones
    int figure = -1;   ///< index into Table::figures
  };
  struct Column {
    std::string title, unit;
  };
  struct Row {
    std::string title;
    std::vector<Cell> cells;  ///< one for each column
  };
  std::vector<Column> columns;
  std::vector<Row> rows;
};

TableLayout lay_out(const Table& table);

/// Writes the tables as Markdown, those without figures left out. Throws io::Error.
void write_tables_markdown(const std::string& file, const std::vector<Table>& tables);

}  // namespace handyar::evaluation
