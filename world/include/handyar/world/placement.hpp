// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string_view>

namespace handyar::world {

/// By what the hand picks up and puts down.
struct PlacementConfig {
  double near_m = 0.07;    ///< the palm is at an object: along the ground
  double above_m = 0.15;   ///< and not higher over its foot
  double away_m = 0.12;    ///< the palm has left it
  double dwell_s = 0.5;    ///< how long the hand must be at it to pick it up
  double grace_s = 0.35;   ///< a hand that is not seen for so long is gone
  double rest_m = 0.012;   ///< a hand that lies on the ground moves less than this ...
  double rest_s = 0.6;     ///< ... for so long, to put down
  double ground_m = 0.06;  ///< the palm of a hand that lies on the ground is not higher
  double sink_m_s = 0.3;   ///< how fast what stands on nothing comes down
};

enum class PlacementEvent : std::uint8_t { picked_up, put_down };
[[nodiscard]] std::string_view name(PlacementEvent event) noexcept;

/// One object of the world and the hand that carries it: the hand stays at it for a while and takes
/// it along; where the hand lies down again, or is gone, the object stays.
class Placement {
 public:
  /// `T_world_object`: its foot, +z up. The hand picks it up once it has been away.
  explicit Placement(const Eigen::Isometry3d& T_world_object, const PlacementConfig& config = {})
      : config_(config), T_world_object_(T_world_object) {}

  /// The next frame in which the world is known. `T_world_stand`: where an object would stand on
  /// the hand (+z up), while its pose is sound. Times must not fall.
  std::optional<PlacementEvent> update(double time_s, const Eigen::Hyperplane<double, 3>& ground,
                                       const std::optional<Eigen::Isometry3d>& T_world_stand);

  [[nodiscard]] bool carried() const noexcept { return carried_; }
  [[nodiscard]] const Eigen::Isometry3d& T_world_object() const noexcept { return T_world_object_; }

 private:
  void carry(double time_s, const Eigen::Hyperplane<double, 3>& ground,
             const Eigen::Isometry3d& T_world_stand);
  void stand(double step_s, const Eigen::Hyperplane<double, 3>& ground,
             const std::optional<Eigen::Isometry3d>& T_world_stand);
  bool at_object(const Eigen::Hyperplane<double, 3>& ground, const Eigen::Vector3d& palm,
                 double within_m) const;

  PlacementConfig config_;
  Eigen::Isometry3d T_world_object_;
  Eigen::Isometry3d T_stand_object_ = Eigen::Isometry3d::Identity();  // while carried
  bool carried_ = false;
  bool must_leave_ = true;  // nothing is picked up twice without the hand going away
  bool started_ = false;
  double last_s_ = 0;
  double since_s_ = 0;                                 // the hand is at it, or lies still with it
  double hand_s_ = 0;                                  // last time with a hand
  Eigen::Vector3d resting_ = Eigen::Vector3d::Zero();  // where the hand has been since
};

}  // namespace handyar::world
