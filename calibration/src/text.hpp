// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <string>

namespace handyar {

/// printf into a string.
template <class... Values>
std::string text(const char* format, Values... values) {
  const int length = std::snprintf(nullptr, 0, format, values...);
  std::string out(static_cast<std::size_t>(length), '\0');
  std::snprintf(out.data(), out.size() + 1, format, values...);
  return out;
}

}  // namespace handyar
