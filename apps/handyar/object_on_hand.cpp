// SPDX-License-Identifier: MIT
#include "object_on_hand.hpp"

#include "handyar/render/hand_overlay.hpp"

namespace handyar::cli {

Overlay object_on_hand(const std::string& model, double size_m) {
  const auto overlay = std::make_shared<render::HandOverlay>(render::find_model(model), size_m);
  return [overlay](cv::Mat& bgr, std::int64_t, const HandTracker& tracker, const Camera& camera,
                   const TrackResult& result) { overlay->draw(bgr, camera, tracker, result); };
}

}  // namespace handyar::cli
