// SPDX-License-Identifier: MIT
#include "handyar/io/skin_file.hpp"

#include <charconv>
#include <vector>

#include "handyar/io/error.hpp"
#include "handyar/io/json.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::io {
namespace {

constexpr float kMaxShare = 1e9f;  // also counts will do

const Json& field(const Json& root, const char* key, std::string_view name) {
  const auto found = root.find(key);
  if (found == root.end()) throw Error(name, std::string(key) + " is missing");
  return *found;
}

// [red, green, blue, share]
SkinColors::Entry read_entry(const Json& row, const std::string& what, std::string_view name) {
  const auto fail = [&](const char* fault) { throw Error(name, what + fault); };
  if (!row.is_array() || row.size() != 4) fail(" is not [red, green, blue, share]");
  for (std::size_t k = 0; k < 3; ++k)
    if (!row[k].is_number_integer() || row[k] < 0 || row[k] > 255)
      fail(": red, green and blue are whole numbers from 0 to 255");
  if (!row[3].is_number()) fail(": share is not a number");
  const float share = row[3].get<float>();
  if (!(share > 0 && share <= kMaxShare)) fail(": share is not a positive number within reason");
  return {bin_of_rgb(row[0].get<int>(), row[1].get<int>(), row[2].get<int>()), share};
}

SkinColors read_fields(const Json& root, std::string_view name) {
  if (!root.is_object()) throw Error(name, "is not a skin file");
  if (field(root, "format", name) != "handyar-skin")
    throw Error(name, "format is not handyar-skin");
  const Json& version = field(root, "version", name);
  if (!version.is_number_integer()) throw Error(name, "version is not a whole number");
  if (version != 1) throw Error(name, "version " + version.dump() + " is not known, only 1");
  const Json& rows = field(root, "colors", name);
  if (!rows.is_array() || rows.empty()) throw Error(name, "colors is not a list of colours");
  if (rows.size() > kBinCount) throw Error(name, "colors has more colours than can be told apart");

  std::vector<double> shares(kBinCount);
  double total = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string what = "colors: number " + std::to_string(i + 1);
    const SkinColors::Entry e = read_entry(rows[i], what, name);
    shares[e.bin] += e.share;
    total += e.share;
  }
  SkinColors colors;
  for (int bin = 0; bin < kBinCount; ++bin)
    if (const float share = static_cast<float>(shares[bin] / total); share > 0)
      colors.entries.push_back({static_cast<ColorBin>(bin), share});
  return colors;
}

}  // namespace

SkinColors parse_skin(std::string_view text, std::string_view name) {
  return parse_json(text, name, [&](const Json& root) { return read_fields(root, name); });
}

SkinColors read_skin(const std::string& path) { return parse_skin(read_text(path), path); }

std::string format_skin(const SkinColors& colors) {
  std::string text = "{\"format\": \"handyar-skin\", \"version\": 1,\n \"colors\": [";
  const char* separator = "\n  [";  // a colour a line
  for (const SkinColors::Entry& e : colors.entries) {
    const Eigen::Vector3i rgb =
        rgb_of(e.bin).array().round().cwiseMax(0.0).cwiseMin(255.0).cast<int>();
    char share[32];  // to_chars: as short as can be read back, in every locale
    const char* end = std::to_chars(share, std::end(share), e.share).ptr;
    text += separator;
    for (const int level : rgb) text += std::to_string(level) + ", ";
    text.append(share, end - share).append("]");
    separator = ",\n  [";
  }
  return text + "]}\n";
}

void write_skin(const std::string& path, const SkinColors& colors) {
  write_text(path, format_skin(colors));
}

}  // namespace handyar::io
