// SPDX-License-Identifier: MIT
#include "handyar/io/frame_source.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "handyar/io/cameras.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/sample.hpp"
#include "libav.hpp"
#include "sources.hpp"

namespace fs = std::filesystem;

namespace handyar::io {
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The device whose name is, or else holds, `name`; empty when there is none.
std::string camera_named(const std::string& name) {
  std::vector<std::string> partial;
  for (const CameraInfo& camera : list_cameras()) {
    if (lower(camera.name) == lower(name)) return camera.path;
    if (lower(camera.name).find(lower(name)) != std::string::npos) partial.push_back(camera.path);
  }
  if (partial.size() > 1) throw Error(name, "more than one camera has that in its name");
  return partial.empty() ? std::string() : partial.front();
}

void require_readable(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw Error(path, std::string("cannot be read: ") + std::strerror(errno));
  ::close(file);
}

}  // namespace

ImageView Frame::view() const noexcept {
  ImageView view;
  view.data = bgr.data;
  view.width_px = bgr.cols;
  view.height_px = bgr.rows;
  view.stride_bytes = static_cast<std::ptrdiff_t>(bgr.step[0]);
  view.format = PixelFormat::bgr;
  return view;
}

int reduction(const cv::Mat& picture) {
  constexpr int kLonger_px = 4096, kShorter_px = 2160;
  const auto [shorter, longer] = std::minmax({picture.cols, picture.rows});
  int by = 1;
  while ((longer / by > kLonger_px || shorter / by > kShorter_px) && by < shorter) ++by;
  return by;
}

void reduce(cv::Mat& picture, int by) {
  if (by == 1) return;
  const cv::Size size(picture.cols / by, picture.rows / by);
  cv::resize(picture(cv::Rect({0, 0}, size * by)), picture, size, 0, 0, cv::INTER_AREA);
}

void require_usable(const Frame& frame, const std::string& name, int reduced_by) {
  if (check(frame.view()) == FrameStatus::ok) return;
  const std::string divided =
      reduced_by > 1 ? " with its sides divided by " + std::to_string(reduced_by) : "";
  throw Error(name, std::to_string(frame.bgr.cols) + "x" + std::to_string(frame.bgr.rows) +
                        " pixels" + divided + ": 160x120 to 4096x2160 are taken");
}

void require_same_size(const Frame& frame, const SourceInfo& info) {
  if (frame.bgr.cols == info.width_px && frame.bgr.rows == info.height_px) return;
  throw Error(info.name, "frame " + std::to_string(frame.index) + " has " +
                             std::to_string(frame.bgr.cols) + "x" + std::to_string(frame.bgr.rows) +
                             " pixels, those before it " + std::to_string(info.width_px) + "x" +
                             std::to_string(info.height_px));
}

void silence_libraries() {
  [[maybe_unused]] static const bool once = [] {
    av_log_set_level(AV_LOG_QUIET);
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    return true;
  }();
}

std::string pattern_hint(const std::string& picture) {
  if (!is_picture(picture)) return {};
  const fs::path path = picture;
  const fs::path pattern = path.parent_path() / ("%04d" + path.extension().string());
  return "for a series of pictures give a pattern, such as " + pattern.string();
}

std::unique_ptr<FrameSource> open_input(const std::string& input, const CameraSettings& settings) {
  silence_libraries();
  if (input.empty()) throw Error("input", "its name is empty");
  const auto require_none = [&] {
    if (settings.any()) throw Error(input, "is no camera: size, rate and lock are for one");
  };
  if (input == "sample") require_none();
  if (input == "sample") return open_video(data_file("sample/video.mp4"));
  if (input.size() <= 3 && std::all_of(input.begin(), input.end(),
                                       [](unsigned char c) { return std::isdigit(c) != 0; })) {
    return open_camera("/dev/video" + std::to_string(std::stoi(input)), settings);
  }
  if (input.starts_with("/dev/video")) return open_camera(input, settings);

  std::error_code ignored;
  const fs::file_status status = fs::status(input, ignored);
  if (fs::is_directory(status)) {
    throw Error(input, "is a folder; " + pattern_hint(fs::path(input) / "0.png"));
  }
  if (fs::is_fifo(status)) throw Error(input, "is a pipe: a video or picture must be a file");
  if (fs::is_character_file(status)) return open_camera(input, settings);
  if (fs::exists(status)) {
    require_none();
    require_readable(input);
    if (fs::is_regular_file(status) && fs::file_size(input, ignored) == 0) {
      throw Error(input, "is empty");
    }
    return is_picture(input) ? open_pictures(input) : open_video(input);
  }
  if (is_picture_pattern(input)) require_none();
  if (is_picture_pattern(input)) return open_pictures(input);
  if (const std::string device = camera_named(input); !device.empty())
    return open_camera(device, settings);
  if (const fs::path path = input;
      is_picture(input) && path.filename().string().find_first_of("*?%#") != std::string::npos)
    throw Error(input, "no such file; " + pattern_hint(input));
  throw Error(input, "no such file, and no camera has that name");
}

}  // namespace handyar::io
