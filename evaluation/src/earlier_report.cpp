// SPDX-License-Identifier: MIT
#include "earlier_report.hpp"

#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "handyar/evaluation/tables.hpp"
#include "handyar/io/error.hpp"

namespace handyar::evaluation {
namespace {

namespace fs = std::filesystem;

/// What stands first in the rows of a list; nothing when it is another list.
std::optional<std::set<std::string>> rows_of(const fs::path& list, std::string_view header) {
  std::ifstream file(list);
  std::string line;
  if (!std::getline(file, line) || !line.starts_with(header)) return std::nullopt;
  std::set<std::string> first;
  while (std::getline(file, line)) first.insert(csv_fields(line).front());
  return first;
}

void remove_file(const fs::path& file) {
  std::error_code fault;
  fs::remove(file, fault);
  if (fault)
    throw io::Error(file.string(),
                    "is of an earlier report and cannot be removed: " + fault.message());
}

}  // namespace

void remove_earlier_report(const std::string& folder) {
  const fs::path in = folder;
  if (const auto sequences = rows_of(in / "errors.csv", "sequence,frame,state")) {
    for (const std::string& name : *sequences) {
      if (name.empty() || name != fs::path(name).filename()) continue;
      remove_file(in / "poses" / (name + ".csv"));
      remove_file(in / ("figure8-" + name + ".png"));
    }
    remove_file(in / "errors.csv");
  }
  if (rows_of(in / "stills.csv", "file,source,skin_tone,outcome")) remove_file(in / "stills.csv");
  if (rows_of(in / "tables.csv", "sequence,table,row,column,value,unit"))
    for (const char* name : {"tables.csv", "tables.md", "report.html"}) remove_file(in / name);
  if (rows_of(in / "sequences.csv", "group,sequence,frames")) {
    for (std::size_t i = 1; i <= kWorstShown; ++i)
      remove_file(in / ("worst-" + std::to_string(i) + ".jpg"));
    for (const char* name : {"sequences.csv", "distribution.md"}) remove_file(in / name);
  }
}

}  // namespace handyar::evaluation
