// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "handyar/io/error.hpp"
#include "handyar/io/hand_file.hpp"

// What was read is written and read again: it must be the same hand.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto hand = handyar::io::parse_hand({reinterpret_cast<const char*>(data), size}, "fuzz");
    const auto again = handyar::io::parse_hand(handyar::io::format_hand(hand), "again");
    if (again.tips_m != hand.tips_m || again.figure.has_value() != hand.figure.has_value())
      std::abort();
  } catch (const handyar::io::Error&) {
  }
  return 0;
}
