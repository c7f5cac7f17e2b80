// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "handyar/io/error.hpp"

namespace handyar::io {

using Json = nlohmann::ordered_json;

/// "[json.exception.parse_error.101] parse error at ...": the code is for programmers.
inline std::string fault_of(const Json::exception& e) {
  std::string what = e.what();
  if (const auto end = what.find("] "); end != std::string::npos) what.erase(0, end + 2);
  return what;
}

/// Runs `read` on the parsed text; what the JSON library has to say against it becomes an Error
/// that begins with `name`.
template <class Read>
auto parse_json(std::string_view text, std::string_view name, Read read) {
  bool parsed = false;
  try {
    const Json root = Json::parse(text);
    parsed = true;
    return read(root);
  } catch (const Json::exception& e) {
    throw Error(name, (parsed ? "" : "is not valid JSON: ") + fault_of(e));
  }
}

}  // namespace handyar::io
