// SPDX-License-Identifier: MIT
#include "exif.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace handyar::io {
namespace {

using namespace std::string_view_literals;

// The EXIF's own bytes, which are a TIFF; empty: the file has none.
std::string_view exif_in(std::string_view file) {
  const auto behind = [&](std::string_view mark, std::size_t gap) {
    const std::size_t at = file.find(mark);
    return at == file.npos ? ""sv : file.substr(std::min(file.size(), at + mark.size() + gap));
  };
  if (file.starts_with("\xff\xd8\xff")) return behind("Exif\0\0"sv, 0);
  if (file.starts_with("\x89PNG")) return behind("eXIf", 0);
  if (file.starts_with("RIFF")) return behind("EXIF", 4);  // its length
  return file;
}

// Numbers in the byte order that its head states, tags in a directory.
class Tiff {
 public:
  explicit Tiff(std::string_view bytes) : bytes_(bytes), little_(bytes.starts_with("II")) {}

  bool is_one() const { return bytes_.starts_with("II*\0"sv) || bytes_.starts_with("MM\0*"sv); }

  /// Zero behind the end.
  std::size_t number(std::size_t at, std::size_t count) const {
    if (at > bytes_.size() || count > bytes_.size() - at) return 0;
    std::size_t value = 0;
    for (std::size_t i = 0; i < count; ++i)
      value = value << 8 | static_cast<std::uint8_t>(bytes_[at + (little_ ? count - 1 - i : i)]);
    return value;
  }

 private:
  std::string_view bytes_;
  bool little_;
};

}  // namespace

int exif_number(std::span<const std::uint8_t> file, std::size_t tag) {
  constexpr std::size_t kEntryBytes = 12;
  const Tiff tiff(exif_in({reinterpret_cast<const char*>(file.data()), file.size()}));
  if (!tiff.is_one()) return 0;
  const std::size_t directory = tiff.number(4, 4);
  for (std::size_t i = 0; i < tiff.number(directory, 2); ++i) {
    const std::size_t entry = directory + 2 + i * kEntryBytes;
    if (tiff.number(entry, 2) == tag) return static_cast<int>(tiff.number(entry + 8, 2));
  }
  return 0;
}

}  // namespace handyar::io
