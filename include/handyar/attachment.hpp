// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string_view>

#include "handyar/api.h"
#include "handyar/hand_model.hpp"
#include "handyar/tracker.hpp"

namespace handyar {

/// Places of the hand on which an object can stand.
enum class Attachment : std::uint8_t {
  face,  ///< the middle of the visible face, be it palm or back
  palm,  ///< the middle of the palm; behind the hand when its back is seen
  back,  ///< the middle of the back of the hand; behind the hand when its palm is seen
  wrist,
  thumb_base,  ///< where the finger leaves the palm
  index_base,
  middle_base,
  ring_base,
  little_base,
  thumb_tip,
  index_tip,
  middle_tip,
  ring_tip,
  little_tip
};
inline constexpr int kAttachmentCount = 14;

/// As in the enumeration: "face", "index_tip".
[[nodiscard]] HANDYAR_API std::string_view name(Attachment where) noexcept;

/// The place of that name; empty when there is none.
[[nodiscard]] HANDYAR_API std::optional<Attachment> find_attachment(std::string_view name) noexcept;

/// True for the bases and tips of fingers, which have room for small objects only.
[[nodiscard]] constexpr bool on_finger(Attachment where) noexcept {
  return where >= Attachment::thumb_base;
}

/// The frame of an object that stands there, in the hand frame of `result`; it moves with the
/// finger. The origin is where it touches the hand and +z is up: away from the hand, for a
/// fingertip along the finger. +x, which models look along, is towards the wrist, for a fingertip
/// out of the visible face. `hand` is the tracker's, in the layout that `result` tells.
///
///     const Eigen::Isometry3d T_camera_object =
///         result.pose->T_camera_hand *
///         T_hand_attachment(Attachment::index_tip, tracker.hand(), result);
[[nodiscard]] HANDYAR_API Eigen::Isometry3d T_hand_attachment(Attachment where,
                                                              const HandModel& hand,
                                                              const TrackResult& result) noexcept;

}  // namespace handyar
