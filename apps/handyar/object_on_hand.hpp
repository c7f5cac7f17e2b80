// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "handyar/paper/any_tracker.hpp"
#include "handyar/render/hand_overlay.hpp"

namespace handyar::cli {

/// An object on the hand, that can be changed for the next: the model it was made with, teapot,
/// bunny, none, and round again.
class ObjectOnHand {
 public:
  /// `model`: `teapot`, `bunny`, or a file; empty: none at first. `size_m`: its longest side.
  /// `where`: the place of the hand that it stands on. Throws io::Error when it cannot be read or
  /// drawn.
  ObjectOnHand(const std::string& model, double size_m, Attachment where = Attachment::face);

  void next();
  void draw(cv::Mat& bgr, const AnyTracker& tracker, const Camera& camera,
            const TrackResult& result) {
    if (overlay_) overlay_->draw(bgr, camera, tracker, result);
  }

 private:
  void take(std::size_t which);

  std::vector<std::string> models_;
  double size_m_;
  Attachment where_;
  std::size_t current_ = 0;
  std::unique_ptr<render::HandOverlay> overlay_;
};

}  // namespace handyar::cli
