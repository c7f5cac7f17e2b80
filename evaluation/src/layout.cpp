// SPDX-License-Identifier: MIT
#include "layout.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "handyar/io/pending_file.hpp"

namespace handyar::evaluation {
namespace {

std::string readable(double value) {
  if (!std::isfinite(value)) return "–";
  const double size = std::abs(value);
  const bool whole = value == std::round(value) && size < 1e6;
  char text[32];
  if (whole)
    std::snprintf(text, sizeof text, "%.0f", value);
  else if (size < 0.095 || size >= 1e6)
    std::snprintf(text, sizeof text, "%.2g", value);
  else
    std::snprintf(text, sizeof text, "%.*f", size >= 100 ? 1 : 2, value);
  return text;
}

std::vector<std::string> mentions(const Table& t, std::string Figure::*of) {
  std::vector<std::string> all;
  for (const Figure& f : t.figures)
    if (std::find(all.begin(), all.end(), f.*of) == all.end()) all.push_back(f.*of);
  return all;
}

/// The unit that all figures of a column share; empty optional when they do not.
std::optional<std::string> shared_unit(const Table& t, const std::string& column) {
  std::optional<std::string> unit;
  for (const Figure& f : t.figures) {
    if (f.column != column) continue;
    if (unit && *unit != f.unit) return std::nullopt;
    unit = f.unit;
  }
  return unit;
}

std::string markdown(const Table& t) {
  const TableLayout layout = lay_out(t);
  std::string head = "| |", rule = "| --- |", body;
  for (const TableLayout::Column& c : layout.columns) {
    head += " " + c.title + (c.unit.empty() ? "" : " (" + c.unit + ")") + " |";
    rule += " ---: |";
  }
  for (const TableLayout::Row& row : layout.rows) {
    body += "| " + row.title + " |";
    for (const TableLayout::Cell& cell : row.cells)
      body += " " + cell.text + (cell.unit.empty() ? "" : " " + cell.unit) + " |";
    body += "\n";
  }
  return "#### " + t.title + (t.sequence == "all" ? "" : " (" + t.sequence + ")") + "\n\n" +
         t.caption + "\n\n" + head + "\n" + rule + "\n" + body + "\n";
}

}  // namespace

TableLayout lay_out(const Table& t) {
  TableLayout layout;
  for (const std::string& column : mentions(t, &Figure::column))
    layout.columns.push_back({column, shared_unit(t, column).value_or("")});
  for (const std::string& row : mentions(t, &Figure::row)) {
    TableLayout::Row& r = layout.rows.emplace_back();
    r.title = row;
    for (const TableLayout::Column& column : layout.columns) {
      TableLayout::Cell& cell = r.cells.emplace_back();
      const auto f = std::find_if(t.figures.begin(), t.figures.end(), [&](const Figure& figure) {
        return figure.row == row && figure.column == column.title;
      });
      if (f == t.figures.end()) continue;
      cell.text = readable(f->value);
      cell.figure = int(f - t.figures.begin());
      if (column.unit.empty() && std::isfinite(f->value)) cell.unit = f->unit;
    }
  }
  return layout;
}

void write_tables_markdown(const std::string& file, const std::vector<Table>& tables) {
  std::string text;
  for (const Table& t : tables)
    if (!t.figures.empty()) text += markdown(t);
  io::write_text(file, text);
}

}  // namespace handyar::evaluation
