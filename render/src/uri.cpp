// SPDX-License-Identifier: MIT
#include "uri.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>

namespace handyar::render {
namespace {

std::string decoded(const std::string& name) {
  std::string file;
  for (std::size_t i = 0; i < name.size(); ++i) {
    unsigned byte = 0;
    const char* const digits = name.data() + i + 1;
    const bool escaped = name[i] == '%' && i + 2 < name.size() &&
                         std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
    file += escaped ? static_cast<char>(byte) : name[i];
    if (escaped) i += 2;
  }
  return file;
}

}  // namespace

std::string file_named(const std::string& name) {
  std::error_code ignored;
  std::string windows = name;
  std::replace(windows.begin(), windows.end(), '\\', '/');
  for (const std::string& file : {name, windows})
    if (std::filesystem::exists(file, ignored)) return file;
  return decoded(name);
}

}  // namespace handyar::render
