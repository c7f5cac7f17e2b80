// SPDX-License-Identifier: MIT
#include "handyar/io/video_writer.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "container.hpp"
#include "decoder.hpp"
#include "handyar/io/error.hpp"
#include "sources.hpp"

namespace handyar::io {
namespace {

// Codecs in order of preference; the first that has an encoder here is taken.
std::vector<int> codecs_for(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const int h264 = cv::VideoWriter::fourcc('a', 'v', 'c', '1');
  const int h264_in_matroska = cv::VideoWriter::fourcc('H', '2', '6', '4');
  const int mpeg4 = cv::VideoWriter::fourcc('m', 'p', '4', 'v');
  const int mpeg4_in_avi = cv::VideoWriter::fourcc('X', 'V', 'I', 'D');
  if (extension == ".mp4" || extension == ".mov") return {h264, mpeg4};
  if (extension == ".mkv") return {h264_in_matroska, mpeg4_in_avi};
  if (extension == ".avi") return {mpeg4_in_avi};
  throw Error(path, "its name must end in .mp4, .mov, .mkv or .avi");
}

constexpr double kLongestPause_s = 10;

// OpenCV says of no write whether it succeeded. What hinders one now most likely hindered it
// before.
std::string reason_against_writing(const std::string& path) {
  errno = 0;
  std::ofstream stream(path, std::ios::binary | std::ios::app);
  stream << std::string(1 << 16, '\0') << std::flush;
  if (stream) return "";
  return errno != 0 ? std::string(": ") + std::strerror(errno) : ": unknown reason";
}

}  // namespace

VideoWriter::VideoWriter(const std::string& path, int width_px, int height_px, double fps)
    : file_((codecs_for(path), path)), fps_(fps) {
  silence_libraries();
  const cv::Size even(width_px + width_px % 2, height_px + height_px % 2);
  for (const int codec : codecs_for(path)) {
    try {
      if (writer_.open(file_.path(), cv::CAP_FFMPEG, codec, fps, even)) return;
    } catch (const cv::Exception&) {
    }
  }
  if (const std::string reason = reason_against_writing(file_.path()); !reason.empty()) {
    throw Error(path, "cannot be written" + reason);
  }
  throw Error(path, "no video encoder for " + std::to_string(width_px) + "x" +
                        std::to_string(height_px) + " pixels was found");
}

// Colours are kept for two by two pixels: the last row or column of an odd size is shown twice.
void VideoWriter::put(const cv::Mat& bgr) {
  const int right = bgr.cols % 2, below = bgr.rows % 2;
  if (right + below > 0) cv::copyMakeBorder(bgr, even_, 0, below, 0, right, cv::BORDER_REPLICATE);
  writer_.write(right + below > 0 ? even_ : bgr);
  ++frames_;
}

void VideoWriter::write(const cv::Mat& bgr, double time_s) {
  const double written_s = static_cast<double>(frames_) / fps_;
  start_s_ = frames_ == 0 ? time_s : std::max(start_s_, time_s - written_s - kLongestPause_s);
  // A frame's jitter is no reason to show one twice, or not at all.
  double late = (time_s - start_s_ - written_s) * fps_;
  for (; late > 1; --late) put(last_);
  if (late < -1) return;
  put(bgr);
  bgr.copyTo(last_);
}

void VideoWriter::finish() {
  writer_.release();
  std::error_code fault;
  if (std::filesystem::is_regular_file(file_.path(), fault) &&
      (std::filesystem::file_size(file_.path(), fault) == 0 || is_cut_short(file_.path()) ||
       count_packets(file_.path()) < frames_)) {
    throw Error(file_.target(), "cannot be written whole" + reason_against_writing(file_.path()));
  }
  file_.commit();
}

}  // namespace handyar::io
