// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>

#include "handyar/image_view.hpp"

namespace handyar::io {

/// One picture of an input.
struct Frame {
  cv::Mat bgr;             ///< 8 bit, three channels, upright
  double time_s = 0;       ///< since the first frame; strictly increasing
  std::int64_t index = 0;  ///< from 0; a frame that a live camera or a numbered series left out
                           ///< leaves a gap

  ImageView view() const noexcept;
};

struct SourceInfo {
  std::string name;  ///< as messages call it: the path, or the camera's device
  int width_px = 0;  ///< of every frame, upright
  int height_px = 0;
  int reduced_by = 1;            ///< larger pictures are read at a half, a third, ... of their size
  double fps = 30;               ///< nominal
  std::int64_t frame_count = 0;  ///< as the container promises; 0: unknown or endless
  bool live = false;
};

/// What a live camera is asked for; zero: whatever it gives.
struct CameraSettings {
  int width_px = 0, height_px = 0;
  double fps = 0;
  /// Exposure, white balance and focus stay as they are after the first second.
  bool lock = false;

  bool any() const { return width_px > 0 || fps > 0 || lock; }
};

/// Frames one after the other, all of one size that HandTracker takes.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const SourceInfo& info() const noexcept = 0;

  /// Fills `frame`; false at the proper end. Throws Error when the input ends early (the message
  /// says how much of it could be read), changes its size, or the camera is unplugged.
  virtual bool read(Frame& frame) = 0;

  /// While a live camera gives no picture this is asked, ten times a second, whether to wait on;
  /// where it says no, read gives false.
  void ask_while_waiting(std::function<bool()> wait_on) { wait_on_ = std::move(wait_on); }

 protected:
  std::function<bool()> wait_on_;  ///< none: as long as the camera may take
};

/// Opens what the command line calls INPUT: a video file, a picture, a numbered series of pictures
/// ("frames/%04d.png"), a camera ("0", "/dev/video0", or its name or a part of it), or "sample",
/// the shipped clip. Throws Error. The rotation that phones note in their videos is applied.
/// A live camera gives its newest frame; what came in between is left out.
/// `settings` are for a live camera; with any other input they are an Error.
std::unique_ptr<FrameSource> open_input(const std::string& input,
                                        const CameraSettings& settings = {});

/// Which input to give for a numbered series of pictures like `picture`, in words; empty where that
/// is no picture's name.
std::string pattern_hint(const std::string& picture);

/// Whether `file` has a name of the numbered series of pictures `input`; both with their folder.
bool is_in_series(const std::string& file, const std::string& input);

}  // namespace handyar::io
