// SPDX-License-Identifier: MIT
#include "container.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace handyar::io {
namespace {

class Bytes {
 public:
  explicit Bytes(const std::string& path) : stream_(path, std::ios::binary) {
    std::error_code fault;
    const auto size = std::filesystem::file_size(path, fault);
    size_ = fault ? 0 : size;
  }
  std::uint64_t size() const { return size_; }

  /// Bytes from `at`; fewer than asked at the end.
  std::string read(std::uint64_t at, std::size_t count) {
    std::string bytes(count, '\0');
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(bytes.data(), static_cast<std::streamsize>(count));
    bytes.resize(static_cast<std::size_t>(stream_.gcount()));
    return bytes;
  }

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;
};

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<std::uint8_t>(c);
  return value;
}

std::uint64_t little_endian(std::string_view bytes) {
  return big_endian(std::string(bytes.rbegin(), bytes.rend()));
}

bool is_mp4(std::string_view head) { return head.size() == 12 && head.substr(4, 4) == "ftyp"; }

// ISO 14496-12: boxes one after the other, each with its length in front.
bool mp4_cut_short(Bytes& file, bool& fragmented) {
  bool has_index = false;
  for (std::uint64_t at = 0; at < file.size();) {
    const std::string head = file.read(at, 16);
    if (head.size() < 8) return true;
    std::uint64_t length = big_endian(std::string_view(head).substr(0, 4));
    if (length == 1 && head.size() == 16) length = big_endian(std::string_view(head).substr(8, 8));
    has_index |= head.compare(4, 4, "moov") == 0;
    fragmented |= head.compare(4, 4, "moof") == 0;
    if (length == 0) break;  // to the end of the file, whatever that is
    if (length < 8) return false;
    if (length > file.size() - at) return true;
    at += length;
  }
  return !has_index;
}

// RIFF chunks one after the other; long AVIs have several. A recording that was not closed says 0.
bool avi_cut_short(Bytes& file) {
  for (std::uint64_t at = 0; at < file.size();) {
    const std::string head = file.read(at, 8);
    if (head.size() < 8 || head.compare(0, 4, "RIFF") != 0) return false;
    const std::uint64_t length = little_endian(std::string_view(head).substr(4, 4));
    if (length == 0) return true;
    if (length + 8 > file.size() - at) return true;
    at += length + 8 + (length & 1);
  }
  return false;
}

bool is_avi(std::string_view head) {
  return head.size() == 12 && head.substr(0, 4) == "RIFF" && head.substr(8) == "AVI ";
}

// RIFF and LIST hold the other chunks; what lies behind a RIFF may be anything.
bool avi_chain_broken(Bytes& file) {
  std::uint64_t at = 0, end = 0;
  while (at < file.size()) {
    const std::string head = file.read(at, 8);
    const bool riff = head.starts_with("RIFF"), list = head.starts_with("LIST");
    if (head.size() < 8 || (at >= end && !riff)) return false;
    const auto printed = [](char c) { return c >= ' ' && c <= '~'; };
    if (!std::all_of(head.begin(), head.begin() + 4, printed)) return true;
    const std::uint64_t length = little_endian(std::string_view(head).substr(4));
    if (riff) end = at + 8 + length;
    at += riff || list ? 12 : 8 + length + (length & 1);
  }
  return at > file.size() + 1;  // the last may lack its filler
}

constexpr std::string_view kEbml = "\x1a\x45\xdf\xa3", kSegment = "\x18\x53\x80\x67",
                           kCluster = "\x1f\x43\xb6\x75";

struct Element {
  std::string id;  ///< empty: there is none
  std::uint64_t data_at = 0, length = 0;
  bool known = false;  ///< the length is stated
};

// RFC 8794: an identifier, then a length; the first byte of either says how many bytes it has.
Element ebml_element(Bytes& file, std::uint64_t at) {
  const std::string head = file.read(at, 12);
  const auto bytes_at = [&](std::size_t i) -> std::size_t {
    return i < head.size() ? std::countl_zero(static_cast<std::uint8_t>(head[i])) + 1 : 9;
  };
  const std::size_t id_bytes = bytes_at(0), count = bytes_at(id_bytes);
  if (id_bytes > 4 || count > 8 || head.size() < id_bytes + count) return {};
  const std::uint64_t mask = (std::uint64_t{1} << (7 * count)) - 1;
  const std::uint64_t length = big_endian(std::string_view(head).substr(id_bytes, count)) & mask;
  return {head.substr(0, id_bytes), at + id_bytes + count, length, length != mask};
}

bool matroska_cut_short(Bytes& file) {
  const Element header = ebml_element(file, 0);
  if (!header.known || header.length > file.size()) return header.known;
  const Element segment = ebml_element(file, header.data_at + header.length);
  return segment.id == kSegment && segment.known && segment.data_at + segment.length > file.size();
}

// Segment and clusters hold the other elements.
bool matroska_chain_broken(Bytes& file) {
  std::uint64_t at = 0, end = file.size();
  while (at < end) {
    const Element element = ebml_element(file, at);
    const bool holds_elements = element.id == kSegment || element.id == kCluster;
    if (element.id.empty() || (!holds_elements && !element.known)) return true;
    if (element.id == kSegment && element.known) end = element.data_at + element.length;
    at = element.data_at + (holds_elements ? 0 : element.length);
  }
  return at > end;
}

}  // namespace

bool is_cut_short(const std::string& path) {
  Bytes file(path);
  const std::string head = file.read(0, 12);
  if (head.size() < 12) return false;
  bool fragmented = false;
  if (is_mp4(head)) return mp4_cut_short(file, fragmented);
  if (is_avi(head)) return avi_cut_short(file);
  if (head.starts_with(kEbml)) return matroska_cut_short(file);
  return false;
}

bool is_chain_broken(const std::string& path) {
  Bytes file(path);
  const std::string head = file.read(0, 12);
  return is_avi(head) ? avi_chain_broken(file)
                      : head.starts_with(kEbml) && matroska_chain_broken(file);
}

bool indexes_every_frame(const std::string& path) {
  Bytes file(path);
  bool fragmented = false;
  return is_mp4(file.read(0, 12)) && !mp4_cut_short(file, fragmented) && !fragmented;
}

bool looks_like_text(const std::string& path) {
  const std::string head = Bytes(path).read(0, 512);
  for (const char c : head) {
    const auto byte = static_cast<std::uint8_t>(c);
    if (byte == 0x7f || (byte < 0x20 && std::strchr("\t\n\v\f\r\x1b", byte) == nullptr) ||
        byte == 0) {
      return false;
    }
  }
  return head.compare(0, 9, "YUV4MPEG2") != 0;
}

}  // namespace handyar::io
