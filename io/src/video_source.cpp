// SPDX-License-Identifier: MIT
#include <cmath>
#include <opencv2/core.hpp>

#include "container.hpp"
#include "decoder.hpp"
#include "handyar/io/error.hpp"
#include "sources.hpp"

namespace handyar::io {
namespace {

constexpr double kDefaultFps = 30.0;
constexpr double kMaxFps = 1000.0;
constexpr double kPause_s = 1.0;  // a step this long is no measure for the next

// The container's time stamps for as long as they increase. Some containers have none: from the
// first bad one each frame follows the one before by the last step known that was no pause.
class FrameClock {
 public:
  explicit FrameClock(double fps) : step_s_(1.0 / fps) {}

  double next(double container_s) {
    if (first_) {
      first_ = false;
      start_s_ = container_s;
      trusted_ = std::isfinite(container_s);
      return 0.0;
    }
    const double step_s = container_s - start_s_ - time_s_;
    trusted_ = trusted_ && step_s > 1e-6 && std::isfinite(step_s);
    if (trusted_ && step_s < kPause_s) step_s_ = step_s;
    time_s_ = trusted_ ? container_s - start_s_ : time_s_ + step_s_;
    return time_s_;
  }

 private:
  double step_s_, start_s_ = 0, time_s_ = 0;
  bool first_ = true, trusted_ = true;
};

void turn(cv::Mat& picture, int clockwise) {
  switch (clockwise) {
    case 90:
      return cv::rotate(picture, picture, cv::ROTATE_90_CLOCKWISE);
    case 180:
      return cv::rotate(picture, picture, cv::ROTATE_180);
    case 270:
      return cv::rotate(picture, picture, cv::ROTATE_90_COUNTERCLOCKWISE);
    default:
      return;
  }
}

class VideoSource final : public FrameSource {
 public:
  explicit VideoSource(const std::string& path) {
    info_.name = path;
    cut_short_ = is_cut_short(path);
    if (looks_like_text(path)) throw Error(path, "is a text file, not a video");
    try {
      decoder_ = std::make_unique<Decoder>(path);
    } catch (const Error&) {
      if (cut_short_) throw Error(path, "breaks off before its index: no frame could be read");
      throw;
    }
    if (const double fps = decoder_->fps(); fps > 0 && fps <= kMaxFps) info_.fps = fps;
    clock_ = FrameClock(info_.fps);
    info_.frame_count = decoder_->frame_count();

    // The first frame is read here: only then is it certain that there is one, and its size.
    if (!decode(ahead_)) {
      throw Error(path,
                  cut_short_ ? "breaks off: " + frames_read() : "no frame in it could be read");
    }
    info_.reduced_by = reduction(ahead_.bgr);
    reduce(ahead_.bgr, info_.reduced_by);
    require_usable(ahead_, path, info_.reduced_by);
    info_.width_px = ahead_.bgr.cols;
    info_.height_px = ahead_.bgr.rows;
    has_ahead_ = true;
  }

  const SourceInfo& info() const noexcept override { return info_; }

  bool read(Frame& frame) override {
    if (has_ahead_) {
      has_ahead_ = false;
      std::swap(frame, ahead_);
      return true;
    }
    if (!decode(frame)) {
      if (cut_short_) throw Error(info_.name, "breaks off: " + frames_read());
      if (damaged_ || is_chain_broken(info_.name) || lacks_indexed_frames())
        throw Error(info_.name, "is damaged: " + frames_read());
      return false;
    }
    require_same_size(frame, info_);
    return true;
  }

 private:
  // A damaged frame is left out: those after it may be sound.
  bool decode(Frame& frame) {
    double container_s = 0;
    for (;;) {
      const Decoder::Step step = decoder_->next(frame.bgr, container_s);
      if (step == Decoder::Step::end) return false;
      if (step == Decoder::Step::picture) break;
      damaged_ = true;
    }
    turn(frame.bgr, decoder_->clockwise_deg());
    reduce(frame.bgr, info_.reduced_by);
    frame.time_s = clock_.next(container_s);
    frame.index = decoded_++;
    return true;
  }

  // After a lossless cut an index lists frames that are not to be shown, so the count of those that
  // were does not tell.
  bool lacks_indexed_frames() const {
    return decoded_ < info_.frame_count && indexes_every_frame(info_.name) &&
           count_packets(info_.name) < info_.frame_count;
  }

  std::string frames_read() const {
    std::string text = std::to_string(decoded_);
    if (info_.frame_count > decoded_) text += " of " + std::to_string(info_.frame_count);
    return text + (decoded_ == 1 && info_.frame_count <= 1 ? " frame" : " frames") +
           " could be read";
  }

  std::unique_ptr<Decoder> decoder_;
  SourceInfo info_;
  FrameClock clock_{kDefaultFps};
  Frame ahead_;
  bool has_ahead_ = false, cut_short_ = false, damaged_ = false;
  std::int64_t decoded_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_video(const std::string& path) {
  return std::make_unique<VideoSource>(path);
}

}  // namespace handyar::io
