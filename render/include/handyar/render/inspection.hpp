// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string_view>

namespace handyar::render {

/// What select-and-inspect (paper 3.3) goes by; distances in pixels of a 640 pixels wide picture.
struct InspectionConfig {
  double near_px = 60;    ///< the hand is at an object: from its outline to the object's
  double away_px = 100;   ///< the hand has left it
  double dwell_s = 0.2;   ///< how long it must be there to choose
  double notice_s = 0.3;  ///< how long the object at least shows that it is chosen
  double blend_s = 0.6;   ///< from the world to the hand, or back
  double grace_s = 0.35;  ///< a loss of the hand shorter than this changes nothing
};

/// One frame as the state machine sees it.
struct InspectionInput {
  double time_s = 0;
  /// From the hand to each object in the picture; infinite for one out of view and without a hand.
  std::span<const double> distance_px;
  bool fingertips_tracked = false;
};

enum class InspectionPhase : std::uint8_t {
  idle,      ///< every object is in its place
  selected,  ///< one is chosen, still in its place
  attached,  ///< on its way to the hand, or on it
  returning  ///< on its way back
};

enum class InspectionEvent : std::uint8_t { selected, attached, released };
std::string_view name(InspectionEvent event) noexcept;

/// Select and inspect as a state machine: the hand comes near an object, the object is chosen; once
/// the fingertips are tracked it goes over to the hand; when they are lost it goes back.
class Inspection {
 public:
  explicit Inspection(const InspectionConfig& config = {}) : config_(config) {}

  /// Takes the next frame; times must not fall. At most one thing happens a frame.
  std::optional<InspectionEvent> update(const InspectionInput& input);

  InspectionPhase phase() const noexcept { return phase_; }

  /// The object chosen, attached or returning; -1 while idle.
  int object() const noexcept { return object_; }

  /// Where it is between its place in the world (0) and the hand (1), eased in and out.
  double weight() const noexcept { return way_ * way_ * (3 - 2 * way_); }

 private:
  std::optional<InspectionEvent> look_for_choice(const InspectionInput& input);

  InspectionConfig config_;
  InspectionPhase phase_ = InspectionPhase::idle;
  int object_ = -1;
  int candidate_ = -1;    // the object that the hand is at
  double since_s_ = 0;    // of the candidate, or of the choice
  double near_s_ = 0;     // last time that the hand was not away from the object
  double tracked_s_ = 0;  // last time with fingertips
  double last_s_ = 0;
  double way_ = 0;           // 0 world .. 1 hand, linear in time
  bool must_leave_ = false;  // after a release nothing is chosen until the hand has gone away
};

/// Between two poses: positions along the line, rotations along the shortest arc.
Eigen::Isometry3d blend(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double weight);

}  // namespace handyar::render
