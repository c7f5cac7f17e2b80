// SPDX-License-Identifier: MIT
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <vector>

#include "handyar/io/error.hpp"
#include "handyar/io/picture_file.hpp"
#include "sources.hpp"

namespace fs = std::filesystem;

namespace handyar::io {
namespace {

constexpr double kPictureFps = 30.0;
// A single picture is held for a second: what moves in none has to be looked at for a while, too.
constexpr std::int64_t kHeldFrames = 30;

// A file name around one %d or %0Nd.
struct Pattern {
  std::string before, after;
  std::size_t digits = 1;

  std::optional<std::int64_t> number_of(const std::string& name) const {
    if (name.size() <= before.size() + after.size() || !name.starts_with(before) ||
        !name.ends_with(after)) {
      return std::nullopt;
    }
    const std::size_t length = name.size() - before.size() - after.size();
    const char* begin = name.data() + before.size();
    if (length < digits || length > 12) return std::nullopt;
    if (length > digits && *begin == '0') return std::nullopt;
    std::int64_t number = 0;
    const auto [end, fault] = std::from_chars(begin, begin + length, number);
    if (fault != std::errc() || end != begin + length || number < 0) return std::nullopt;
    return number;
  }
};

std::optional<Pattern> pattern_of(const std::string& name) {
  const std::size_t percent = name.find('%');
  if (percent == std::string::npos) return std::nullopt;
  const std::size_t d = name.find('d', percent);
  if (d == std::string::npos || name.find('%', percent + 1) != std::string::npos) {
    return std::nullopt;
  }
  Pattern pattern{name.substr(0, percent), name.substr(d + 1)};
  const std::string width = name.substr(percent + 1, d - percent - 1);
  if (!width.empty()) {
    std::size_t digits = 0;
    const auto [end, fault] = std::from_chars(width.data(), width.data() + width.size(), digits);
    if (width[0] != '0' || fault != std::errc() || end != width.data() + width.size() ||
        digits < 1 || digits > 12) {
      return std::nullopt;
    }
    pattern.digits = digits;
  }
  return pattern;
}

struct Picture {
  std::string path;
  std::int64_t number;
};

class PictureSource final : public FrameSource {
 public:
  PictureSource(const std::string& name, std::vector<Picture> pictures)
      : pictures_(std::move(pictures)) {
    Frame first;
    info_.name = name;
    info_.fps = kPictureFps;
    info_.frame_count = static_cast<std::int64_t>(pictures_.size());
    load(pictures_.front(), first);
    info_.reduced_by = reduction(first.bgr);
    reduce(loaded_, info_.reduced_by);
    reduce(first.bgr, info_.reduced_by);
    require_usable(first, pictures_.front().path, info_.reduced_by);
    info_.width_px = first.bgr.cols;
    info_.height_px = first.bgr.rows;
  }

  const SourceInfo& info() const noexcept override { return info_; }

  bool read(Frame& frame) override {
    if (next_ == pictures_.size()) return false;
    load(pictures_[next_], frame);
    require_same_size(frame, info_);
    ++next_;
    return true;
  }

 private:
  void load(const Picture& picture, Frame& frame) {
    if (picture.path != loaded_path_) decode(picture.path);
    loaded_.copyTo(frame.bgr);
    frame.index = picture.number - pictures_.front().number;
    frame.time_s = static_cast<double>(frame.index) / kPictureFps;
  }

  void decode(const std::string& path) {
    loaded_ = read_picture(path);
    reduce(loaded_, info_.reduced_by);
    loaded_path_ = path;
  }

  std::vector<Picture> pictures_;
  std::size_t next_ = 0;
  cv::Mat loaded_;
  std::string loaded_path_;
  SourceInfo info_;
};

}  // namespace

bool is_picture(const std::string& path) {
  static constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".bmp",  ".ppm",
                                                ".pnm", ".tif", ".tiff", ".webp", ".jp2"};
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
         std::end(kExtensions);
}

bool is_picture_pattern(const std::string& path) {
  return pattern_of(fs::path(path).filename().string()).has_value();
}

bool is_in_series(const std::string& file, const std::string& input) {
  const fs::path picture = file, series = input;
  const auto pattern = pattern_of(series.filename().string());
  return pattern && pattern->number_of(picture.filename().string()) &&
         picture.parent_path() == series.parent_path();
}

std::unique_ptr<FrameSource> open_pictures(const std::string& path) {
  std::error_code fault;
  if (fs::exists(path, fault)) {
    std::vector<Picture> held;
    for (std::int64_t i = 0; i < kHeldFrames; ++i) held.push_back({path, i});
    return std::make_unique<PictureSource>(path, std::move(held));
  }
  const Pattern pattern = *pattern_of(fs::path(path).filename().string());
  const fs::path folder = fs::path(path).parent_path();
  std::vector<Picture> pictures;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, fault)) {
    if (const auto number = pattern.number_of(entry.path().filename().string())) {
      pictures.push_back({entry.path().string(), *number});
    }
  }
  if (fault) throw Error(path, "its folder cannot be read: " + fault.message());
  if (pictures.empty()) throw Error(path, "no picture has such a name");
  std::sort(pictures.begin(), pictures.end(),
            [](const Picture& a, const Picture& b) { return a.number < b.number; });
  return std::make_unique<PictureSource>(path, std::move(pictures));
}

}  // namespace handyar::io
