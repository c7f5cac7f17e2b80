// SPDX-License-Identifier: MIT
#include <chrono>
#include <cmath>

#include "handyar/io/error.hpp"
#include "handyar/io/latest_frame.hpp"
#include "sources.hpp"
#include "v4l2_camera.hpp"

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
  LiveSource(const std::string& device, const CameraSettings& settings, DriverCalls& calls)
      : settings_(settings), camera_(device, settings, calls) {
    info_.name = device;
    info_.live = true;
    const double fps = camera_.fps();
    if (std::isfinite(fps) && fps >= 1 && fps <= 1000) info_.fps = fps;
    Frame first;
    if (!grab(first, {})) throw Error(device, "the camera gives no pictures");
    require_usable(first, device);
    info_.width_px = first.bgr.cols;
    info_.height_px = first.bgr.rows;
    require_asked_size();
    latest_ = std::make_unique<LatestFrame>(
        [this](Frame& frame, const std::stop_token& stop) { return grab(frame, stop); });
  }

  const SourceInfo& info() const noexcept override { return info_; }

  bool read(Frame& frame) override {
    bool wanted = true;
    const auto wait_on = [&] { return wanted = !wait_on_ || wait_on_(); };
    if (!latest_->read(frame, wait_on)) {
      if (!wanted) return false;
      throw Error(info_.name, "the camera gives no more pictures");
    }
    require_same_size(frame, info_);
    return true;
  }

 private:
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
    constexpr double kSettled_s = 1;
    if (!settings_.lock || time_s < kSettled_s) return;
    settings_.lock = false;
    camera_.lock();
  }

  bool grab(Frame& frame, const std::stop_token& stop) {
    double taken_s = 0;
    if (!camera_.read(frame.bgr, taken_s, stop)) return false;
    frame.time_s = clock_.next(taken_s, steady_s());
    lock_when_settled(frame.time_s);
    return true;
  }

  CameraSettings settings_;
  V4l2Camera camera_;
  LiveClock clock_;
  SourceInfo info_;
  std::unique_ptr<LatestFrame> latest_;  // last: its thread uses the rest
};

}  // namespace

std::unique_ptr<FrameSource> open_camera(const std::string& device, const CameraSettings& settings,
                                         DriverCalls& calls) {
  return std::make_unique<LiveSource>(device, settings, calls);
}

std::unique_ptr<FrameSource> open_camera(const std::string& device,
                                         const CameraSettings& settings) {
  return open_camera(device, settings, system_calls());
}

}  // namespace handyar::io
