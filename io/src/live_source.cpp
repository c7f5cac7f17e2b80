// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <opencv2/videoio.hpp>

#include "handyar/io/error.hpp"
#include "handyar/io/latest_frame.hpp"
#include "sources.hpp"

namespace handyar::io {
namespace {

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Seconds since the first frame. The driver's stamp says when the picture was taken, the clock only
// when it arrived; a driver whose stamps stand still, or stray from the clock, is not believed.
class LiveClock {
 public:
  double next(double driver_s, double arrival_s) {
    if (first_) {
      first_ = false;
      driver_start_s_ = driver_s;
      arrival_start_s_ = arrival_s;
      trusted_ = std::isfinite(driver_s) && driver_s > 0;
      return 0.0;
    }
    const double arrived_s = arrival_s - arrival_start_s_;
    const double taken_s = driver_s - driver_start_s_;
    trusted_ = trusted_ && taken_s > time_s_ && std::abs(taken_s - arrived_s) < 1.0;
    time_s_ = std::max(trusted_ ? taken_s : arrived_s, time_s_ + 1e-6);
    return time_s_;
  }

 private:
  double driver_start_s_ = 0, arrival_start_s_ = 0, time_s_ = 0;
  bool first_ = true, trusted_ = false;
};

class LiveSource final : public FrameSource {
 public:
  LiveSource(const std::string& device, const CameraSettings& settings) : settings_(settings) {
    info_.name = device;
    info_.live = true;
    if (::access(device.c_str(), R_OK | W_OK) != 0) {
      throw Error(device,
                  std::string("no such camera, or it cannot be opened: ") + std::strerror(errno));
    }
    try {
      capture_.open(device, cv::CAP_V4L2);
    } catch (const cv::Exception&) {
    }
    if (!capture_.isOpened()) throw Error(device, "is not a camera, or another program uses it");
    ask();
    const double fps = capture_.get(cv::CAP_PROP_FPS);
    if (std::isfinite(fps) && fps >= 1 && fps <= 1000) info_.fps = fps;
    Frame first;
    if (!grab(first)) throw Error(device, "the camera gives no pictures");
    require_usable(first, device);
    info_.width_px = first.bgr.cols;
    info_.height_px = first.bgr.rows;
    require_asked_size();
    latest_ = std::make_unique<LatestFrame>([this](Frame& frame) { return grab(frame); });
  }
  ~LiveSource() override { latest_.reset(); }  // its thread uses the capture

  const SourceInfo& info() const noexcept override { return info_; }

  bool read(Frame& frame) override {
    if (!latest_->read(frame)) throw Error(info_.name, "the camera gives no more pictures");
    require_same_size(frame, info_);
    return true;
  }

 private:
  void ask() {
    if (settings_.width_px > 0) {
      // Large pictures come fast enough only when the camera compresses them.
      if (settings_.width_px > 640)
        capture_.set(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'));
      capture_.set(cv::CAP_PROP_FRAME_WIDTH, settings_.width_px);
      capture_.set(cv::CAP_PROP_FRAME_HEIGHT, settings_.height_px);
    }
    if (settings_.fps > 0) capture_.set(cv::CAP_PROP_FPS, settings_.fps);
  }

  void require_asked_size() const {
    if (settings_.width_px == 0 ||
        (info_.width_px == settings_.width_px && info_.height_px == settings_.height_px))
      return;
    throw Error(info_.name, "gives no pictures of " + std::to_string(settings_.width_px) + "x" +
                                std::to_string(settings_.height_px) + ", but of " +
                                std::to_string(info_.width_px) + "x" +
                                std::to_string(info_.height_px) + " pixels");
  }

  // By the second second the camera has adapted itself to the light.
  void lock_when_settled(double time_s) {
    constexpr double kSettled_s = 1, kManual = 1;  // of V4L2's exposure modes
    if (!settings_.lock || time_s < kSettled_s) return;
    settings_.lock = false;
    capture_.set(cv::CAP_PROP_AUTO_EXPOSURE, kManual);
    capture_.set(cv::CAP_PROP_AUTO_WB, 0);
    capture_.set(cv::CAP_PROP_AUTOFOCUS, 0);
  }

  bool grab(Frame& frame) {
    try {
      if (!capture_.read(frame.bgr) || frame.bgr.empty()) return false;
    } catch (const cv::Exception&) {
      return false;
    }
    frame.time_s = clock_.next(capture_.get(cv::CAP_PROP_POS_MSEC) / 1000.0, steady_s());
    lock_when_settled(frame.time_s);
    return true;
  }

  CameraSettings settings_;
  cv::VideoCapture capture_;
  LiveClock clock_;
  SourceInfo info_;
  std::unique_ptr<LatestFrame> latest_;
};

}  // namespace

std::unique_ptr<FrameSource> open_camera(const std::string& device,
                                         const CameraSettings& settings) {
  return std::make_unique<LiveSource>(device, settings);
}

}  // namespace handyar::io
