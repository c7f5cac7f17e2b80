// SPDX-License-Identifier: MIT
#include "handyar/io/error.hpp"

namespace handyar::io {
namespace {

// File names and library messages may hold line ends; the promise is one line.
std::string one_line(std::string_view subject, std::string_view fault) {
  std::string line;
  line.append(subject).append(": ").append(fault);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace

Error::Error(std::string_view subject, std::string_view fault)
    : std::runtime_error(one_line(subject, fault)) {}

}  // namespace handyar::io
