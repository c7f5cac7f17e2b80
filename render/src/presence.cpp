// SPDX-License-Identifier: MIT
#include "handyar/render/presence.hpp"

#include <algorithm>

namespace handyar::render {

void Presence::update(double time_s, const std::optional<Eigen::Isometry3d>& T_camera_hand,
                      std::optional<Layout> layout) {
  const double step_s = started_ ? std::max(0.0, time_s - last_s_) : 0;
  last_s_ = time_s;
  started_ = true;
  const bool here = T_camera_hand && layout;
  const bool same_face = here && (shown_ <= 0 || *layout == where_.layout);
  shown_ = std::clamp(shown_ + (same_face ? step_s / appear_s_ : -step_s / vanish_s_), 0.0, 1.0);
  if (same_face || (here && shown_ <= 0)) {
    where_.T_camera_hand = *T_camera_hand;
    where_.layout = *layout;
  }
}

Presence::Sighting Presence::sighting() const {
  Sighting s = where_;
  s.opacity = static_cast<float>(shown_ * shown_ * (3 - 2 * shown_));
  return s;
}

}  // namespace handyar::render
