// SPDX-License-Identifier: MIT
#include "ply.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace handyar::render {
namespace {

struct Property {
  std::size_t count_bytes = 0;  ///< of the number before a list; 0: one value
  std::size_t bytes = 0;
};

struct Element {
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

std::size_t bytes_of(const std::string& type) {
  if (type.ends_with("char") || type.ends_with("int8")) return 1;
  if (type.ends_with("short") || type.ends_with("int16")) return 2;
  return type == "double" || type == "float64" ? 8 : 4;
}

/// What follows the header, value by value.
class Body {
 public:
  Body(std::string bytes, const std::string& format)
      : bytes_(std::move(bytes)), ascii_(format == "ascii"), big_(format == "binary_big_endian") {}

  bool skip(std::uint64_t values, std::size_t bytes) {
    if (!ascii_) {
      if (values > (bytes_.size() - at_) / bytes) return false;
      at_ += values * bytes;
      return true;
    }
    while (values > 0 && !word().empty()) --values;
    return values == 0;
  }

  bool skip_list(const Property& list) {
    std::uint64_t count = 0;
    if (ascii_) {
      const std::string_view digits = word();
      std::from_chars(digits.data(), digits.data() + digits.size(), count);
      return !digits.empty() && skip(count, list.bytes);
    }
    const std::size_t begin = at_;
    if (!skip(1, list.count_bytes)) return false;
    for (std::size_t i = 0; i < list.count_bytes; ++i) {
      const std::size_t at = big_ ? begin + i : at_ - 1 - i;
      count = count << 8 | static_cast<std::uint8_t>(bytes_[at]);
    }
    return skip(count, list.bytes);
  }

 private:
  std::string_view word() {
    constexpr const char* kSpace = " \t\r\n";
    const std::size_t begin = std::min(bytes_.find_first_not_of(kSpace, at_), bytes_.size());
    at_ = std::min(bytes_.find_first_of(kSpace, begin), bytes_.size());
    return std::string_view(bytes_).substr(begin, at_ - begin);
  }

  std::string bytes_;
  std::size_t at_ = 0;
  bool ascii_, big_;
};

}  // namespace

bool is_ply_cut_short(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string word, format, line;
  file >> word;
  if (word != "ply" && word != "PLY") return false;
  std::vector<Element> elements;
  while (file >> word && word != "end_header") {
    if (word == "comment" || word == "obj_info") std::getline(file, line);
    if (word == "format") file >> format;
    if (word == "element") file >> word >> elements.emplace_back().count;
    if (word == "property" && !elements.empty()) {
      Property property;
      file >> word;
      if (word == "list") {
        file >> word;
        property.count_bytes = bytes_of(word);
        file >> word;
      }
      property.bytes = bytes_of(word);
      elements.back().properties.push_back(property);
      file >> word;  // its name
    }
  }
  if (!file) return true;
  if (format != "ascii") std::getline(file, line);
  Body body({std::istreambuf_iterator<char>(file), {}}, format);
  for (const Element& element : elements)
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i)
      for (const Property& p : element.properties)
        if (!(p.count_bytes > 0 ? body.skip_list(p) : body.skip(1, p.bytes))) return true;
  return false;
}

}  // namespace handyar::render
