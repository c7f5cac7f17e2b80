// SPDX-License-Identifier: MIT
#include "handyar/evaluation/tables.hpp"

#include <cmath>
#include <cstdio>

#include "handyar/io/pending_file.hpp"

namespace handyar::evaluation {

std::string csv_number(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += c;
    quoted += c;
  }
  return quoted + "\"";
}

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && line.substr(i + 1).starts_with('"'))
      fields.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else if (c != '\r')
      fields.back() += c;
  }
  return fields;
}

void write_tables_csv(const std::string& file, const std::vector<Table>& tables) {
  std::string text = "sequence,table,row,column,value,unit\n";
  for (const Table& t : tables)
    for (const Figure& f : t.figures)
      text += csv_field(t.sequence) + "," + t.id + "," + csv_field(f.row) + "," +
              csv_field(f.column) + "," + csv_number(f.value) + "," + f.unit + "\n";
  io::write_text(file, text);
}

}  // namespace handyar::evaluation
