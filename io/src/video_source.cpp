// SPDX-License-Identifier: MIT
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "container.hpp"
#include "handyar/io/error.hpp"
#include "sources.hpp"

namespace handyar::io {
namespace {

constexpr double kDefaultFps = 30.0;
constexpr double kMaxFps = 1000.0;
constexpr double kPause_s = 1.0;    // a step this long is no measure for the next
constexpr int kMaxFailures = 1000;  // in a row: the count of frames may promise any number

// The container's time stamps for as long as they increase. Some containers have none, and OpenCV
// loses those of the frames that the decoder still holds at the end: from the first bad one each
// frame follows the one before by the last step known that was no pause.
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

// How far to turn a decoded picture so that it stands upright, clockwise. OpenCV's own turning is
// off because 4.6 turns a quarter the wrong way: it gives the angle of FFmpeg's display matrix,
// which counts the other way round; the versions before and after give it clockwise.
int clockwise_deg(const cv::VideoCapture& capture) {
  const double meta = capture.get(cv::CAP_PROP_ORIENTATION_META);
  if (!std::isfinite(meta)) return 0;
  const bool counter_clockwise = cv::getVersionMajor() == 4 && cv::getVersionMinor() == 6;
  const long turn = std::lround(counter_clockwise ? -meta : meta) % 360;
  return static_cast<int>((turn + 360) % 360);
}

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
      capture_.open(path, cv::CAP_FFMPEG);
    } catch (const cv::Exception&) {
    }
    if (!capture_.isOpened()) {
      throw Error(path, cut_short_ ? "breaks off before its index: no frame could be read"
                                   : "is not a video that can be read");
    }
    capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    clockwise_deg_ = clockwise_deg(capture_);
    const double fps = capture_.get(cv::CAP_PROP_FPS);
    info_.fps = std::isfinite(fps) && fps > 0 && fps <= kMaxFps ? fps : kDefaultFps;
    clock_ = FrameClock(info_.fps);
    const double count = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (count > 0 && count < 1e9) info_.frame_count = std::llround(count);

    // The first frame is read here: only then is it certain that there is one, and its size.
    if (!decode(ahead_)) {
      throw Error(path,
                  cut_short_ ? "breaks off: " + frames_read() : "no frame in it could be read");
    }
    require_usable(ahead_, path);
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
      if (is_damaged()) throw Error(info_.name, "is damaged: " + frames_read());
      return false;
    }
    require_same_size(frame, info_);
    return true;
  }

 private:
  bool read_next(cv::Mat& bgr) {
    try {
      return capture_.read(bgr) && !bgr.empty();
    } catch (const cv::Exception&) {
      throw Error(info_.name, "frame " + std::to_string(decoded_) + " cannot be decoded");
    }
  }

  // A damaged frame fails like the end, but those after it may be sound.
  bool decode(Frame& frame) {
    int failures = 0;
    while (!read_next(frame.bgr)) {
      ++failures;
      if (decoded_ + ++failed_ >= info_.frame_count || failures == kMaxFailures) return false;
    }
    failed_between_ |= failures > 0 && decoded_ > 0;
    turn(frame.bgr, clockwise_deg_);
    frame.time_s = clock_.next(capture_.get(cv::CAP_PROP_POS_MSEC) / 1000.0);
    frame.index = decoded_++;
    return true;
  }

  // The count alone does not tell (is_cut_short), nor does a failure: OpenCV also gives up for once
  // where sound goes on through a long pause of the picture.
  bool is_damaged() const {
    if (decoded_ >= info_.frame_count) return false;
    if (is_chain_broken(info_.name)) return true;
    const std::int64_t packets = count_packets(info_.name, info_.frame_count);
    return (failed_between_ && decoded_ < packets) ||
           (indexes_every_frame(info_.name) && packets < info_.frame_count);
  }

  std::string frames_read() const {
    std::string text = std::to_string(decoded_);
    if (info_.frame_count > decoded_) text += " of " + std::to_string(info_.frame_count);
    return text + (decoded_ == 1 && info_.frame_count <= 1 ? " frame" : " frames") +
           " could be read";
  }

  cv::VideoCapture capture_;
  SourceInfo info_;
  FrameClock clock_{kDefaultFps};
  Frame ahead_;
  bool has_ahead_ = false, cut_short_ = false, failed_between_ = false;
  int clockwise_deg_ = 0;
  std::int64_t decoded_ = 0, failed_ = 0;
};

}  // namespace

std::int64_t count_packets(const std::string& path, std::int64_t most) {
  std::int64_t count = 0;
  try {
    cv::VideoCapture capture(path, cv::CAP_FFMPEG);
    capture.set(cv::CAP_PROP_FORMAT, -1);  // packets as they are
    for (int failures = 0; failures < kMaxFailures && count < most;) {
      if (capture.grab()) {
        ++count;
      } else {
        ++failures;
      }
    }
  } catch (const cv::Exception&) {
  }
  return count;
}

std::unique_ptr<FrameSource> open_video(const std::string& path) {
  return std::make_unique<VideoSource>(path);
}

}  // namespace handyar::io
