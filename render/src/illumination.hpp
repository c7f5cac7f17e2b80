// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "handyar/tracker.hpp"

namespace handyar::render {

/// The light in the room, guessed from the frame: an object drawn with it has the frame's
/// brightness and a part of its colour cast, and mirrors what the camera sees. Smoothed over some
/// frames.
class Illumination {
 public:
  /// Takes the next frame (8-bit BGR). The hand, when there is one, stands where the object does:
  /// its brightness tells sun from shade.
  void observe(const cv::Mat& frame_bgr, const HandMask& hand = {});

  /// The frame at 32x24, linear light RGB floats: what a shiny surface mirrors.
  const cv::Mat& mirrored() const { return blurred_; }

  /// Light that falls on a surface turned towards `x` (-1 left .. 1 right), `y` (-1 up .. 1 down)
  /// of the picture, as a 4x3 map of linear RGB floats; 1 is the light in which white is just
  /// white.
  const cv::Mat& ambient() const { return ambient_; }

  /// Light from the lamp that is taken to stand above and beside the camera.
  const Eigen::Vector3f& key() const { return key_; }

 private:
  cv::Mat blurred_, ambient_;
  float on_hand_ = 0;  // luminance of the hand, linear; 0: not known
  Eigen::Vector3f key_ = Eigen::Vector3f::Ones();
};

}  // namespace handyar::render
