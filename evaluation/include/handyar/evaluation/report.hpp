// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "handyar/evaluation/analysis.hpp"
#include "handyar/evaluation/stills.hpp"

namespace handyar::evaluation {

/// What was run, for the head of the report.
struct RunDescription {
  std::string command;
  std::string version;  ///< of handyar
};

/// Tables, figures and pictures of a run as files in `folder`:
///
///     report.html              everything, in one file that opens offline
///     tables.csv, errors.csv   every number of it; per-frame errors
///     tables.md                the tables for a document
///     stills.csv               a row a photograph, when there were any
///     poses/NAME.csv           what the tracker gave (default setting)
///     figure8-NAME.png         where a board was seen and gnuplot is installed
///
/// What an earlier run wrote there as its report goes. Returns notes for the person (that gnuplot
/// is missing, that truth is short). Throws io::Error.
std::vector<std::string> write_report(const std::string& folder, const RunDescription& run,
                                      const std::vector<Analysis>& analyses,
                                      const std::vector<StillResult>& stills);

}  // namespace handyar::evaluation
