// SPDX-License-Identifier: MIT
#include "handyar/io/recording.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "encoder.hpp"
#include "handyar/io/error.hpp"

namespace handyar::io {
namespace {

constexpr AVRational kMillisecond{1, 1000};  // Matroska counts in these

void set_up(AVCodecContext& ffv1) {
  constexpr int kSlices = 4;  // coded at the same time
  ffv1.level = 3;             // with slices
  ffv1.slices = kSlices;
  ffv1.thread_count = kSlices;
  ffv1.thread_type = FF_THREAD_SLICE;
  ffv1.gop_size = 1;  // every picture stands alone
}

}  // namespace

struct Recording::Impl {
  Encoder encoder;
  std::int64_t last_ms = -1;
};

Recording::Recording(const std::string& path, int width_px, int height_px) {
  if (std::filesystem::path(path).extension() != ".mkv")
    throw Error(path, "its name must end in .mkv");
  const VideoCoding lossless{AV_CODEC_ID_FFV1, AV_PIX_FMT_BGR0, kMillisecond, set_up};
  impl_.reset(new Impl{Encoder(path, width_px, height_px, {lossless})});
}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

void Recording::write(const cv::Mat& bgr, double time_s) {
  AVFrame& picture = impl_->encoder.picture();
  cv::Mat to(picture.height, picture.width, CV_8UC4, picture.data[0],
             static_cast<std::size_t>(picture.linesize[0]));
  cv::cvtColor(bgr, to, cv::COLOR_BGR2BGRA);
  impl_->last_ms = std::max<std::int64_t>(std::llround(time_s * 1000), impl_->last_ms + 1);
  impl_->encoder.write(impl_->last_ms);
}

void Recording::finish() { impl_->encoder.finish(); }

}  // namespace handyar::io
