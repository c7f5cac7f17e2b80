// SPDX-License-Identifier: MIT
#include "handyar/io/video_writer.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "encoder.hpp"
#include "handyar/io/error.hpp"
#include "pixels.hpp"

extern "C" {
#include <libavutil/opt.h>
}

namespace handyar::io {
namespace {

constexpr double kLongestPause_s = 10;

std::vector<VideoCoding> codings_for(const std::string& path, cv::Size size, double fps) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool avi = extension == ".avi";
  if (!avi && extension != ".mp4" && extension != ".mov" && extension != ".mkv")
    throw Error(path, "its name must end in .mp4, .mov, .mkv or .avi");
  const AVRational rate = av_d2q(fps, 60'000);  // MPEG-4 counts up to 65 535
  const auto h264 = [rate](AVCodecContext& codec) {
    codec.framerate = rate;
    av_opt_set(codec.priv_data, "crf", "23", 0);  // of x264: what it holds for good
  };
  const auto mpeg4 = [=](AVCodecContext& codec) {
    codec.framerate = rate;
    codec.bit_rate = std::llround(fps * size.area() / 3);  // a third of a bit for a pixel
    if (avi) codec.codec_tag = MKTAG('X', 'V', 'I', 'D');  // as players of AVI know it
  };
  std::vector<VideoCoding> codings;
  if (!avi) codings.push_back({AV_CODEC_ID_H264, AV_PIX_FMT_YUV420P, av_inv_q(rate), h264});
  codings.push_back({AV_CODEC_ID_MPEG4, AV_PIX_FMT_YUV420P, av_inv_q(rate), mpeg4});
  return codings;
}

// Colours are kept for two by two pixels.
cv::Size even(int width_px, int height_px) {
  return {width_px + width_px % 2, height_px + height_px % 2};
}

}  // namespace

struct VideoWriter::Impl {
  Encoder encoder;
  PixelConverter converter{PixelConverter::Care::fast};
  double fps, start_s = 0;
  std::int64_t frames = 0;
  cv::Mat last, even;

  Impl(const std::string& path, cv::Size size, double frames_per_s)
      : encoder(path, size.width, size.height, codings_for(path, size, frames_per_s)),
        fps(frames_per_s) {}

  // The last row or column of an odd size is shown twice.
  void put(const cv::Mat& bgr) {
    const int right = bgr.cols % 2, below = bgr.rows % 2;
    if (right + below > 0) cv::copyMakeBorder(bgr, even, 0, below, 0, right, cv::BORDER_REPLICATE);
    if (!converter.to_frame(right + below > 0 ? even : bgr, AV_PIX_FMT_BGR24, encoder.picture()))
      throw Error(encoder.target(), "cannot be encoded");
    encoder.write(frames++);
  }
};

VideoWriter::VideoWriter(const std::string& path, int width_px, int height_px, double fps)
    : impl_(std::make_unique<Impl>(path, even(width_px, height_px), fps)) {}
VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;

void VideoWriter::write(const cv::Mat& bgr, double time_s) {
  Impl& w = *impl_;
  const double written_s = static_cast<double>(w.frames) / w.fps;
  w.start_s = w.frames == 0 ? time_s : std::max(w.start_s, time_s - written_s - kLongestPause_s);
  // A frame's jitter is no reason to show one twice, or not at all.
  double late = (time_s - w.start_s - written_s) * w.fps;
  for (; late > 1; --late) w.put(w.last);
  if (late < -1) return;
  w.put(bgr);
  bgr.copyTo(w.last);
}

void VideoWriter::finish() { impl_->encoder.finish(); }

}  // namespace handyar::io
