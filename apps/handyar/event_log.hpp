// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "handyar/io/pending_file.hpp"

namespace handyar::cli {

/// One line of JSON for everything that happens; the file takes its name on finish(). Throws
/// io::Error.
class EventLog {
 public:
  explicit EventLog(const std::string& path);

  /// `more`: what else there is to say, behind event, frame and time_s.
  void write(std::string_view event, std::int64_t frame, double time_s,
             const nlohmann::ordered_json& more);
  void finish();

 private:
  void check() const;

  io::PendingFile file_;
  std::ofstream stream_;
};

}  // namespace handyar::cli
