// SPDX-License-Identifier: MIT
#include "event_log.hpp"

#include "handyar/io/error.hpp"

namespace handyar::cli {

EventLog::EventLog(const std::string& path) : file_(path), stream_(file_.stream()) {}

void EventLog::write(std::string_view event, std::int64_t frame, double time_s,
                     const nlohmann::ordered_json& more) {
  nlohmann::ordered_json line = {{"event", event}, {"frame", frame}, {"time_s", time_s}};
  line.update(more);
  // A name that is not UTF-8 is no reason to stop.
  stream_ << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  stream_.flush();
  check();
}

void EventLog::finish() {
  stream_.close();
  check();
  file_.commit();
}

void EventLog::check() const {
  if (!stream_) throw io::Error(file_.target(), "cannot be written");
}

}  // namespace handyar::cli
