// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "handyar/io/error.hpp"
#include "handyar/io/skin_file.hpp"

// What was read is written and read again: it must name the same colours.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto skin = handyar::io::parse_skin({reinterpret_cast<const char*>(data), size}, "fuzz");
    const auto again = handyar::io::parse_skin(handyar::io::format_skin(skin), "again");
    if (again.entries.size() != skin.entries.size()) std::abort();
  } catch (const handyar::io::Error&) {
  }
  return 0;
}
