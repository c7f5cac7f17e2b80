// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "align/palm_grid.hpp"
#include "handyar/pose.hpp"
#include "handyar/stages/align.hpp"

namespace handyar {

/// What the skin of a palm, or of the back of a hand, looks like on a grid that lies on the
/// figure's palm. Where the grid lies in later frames tells how the hand has turned since, which
/// the outline of a hand seen nearly straight on hardly does; where it lies on the hand is told by
/// the outlines of all frames together.
class PalmTexture {
 public:
  using Field = PalmField;

  void forget() noexcept { frames_ = 0; }

  /// Adds what a frame's texture says of the pose to the information of a state and to the gradient
  /// that belongs to it (Gauss-Newton); nothing while this face is not known.
  void pull(const ImageView& frame, const Camera& camera, Appearance appearance,
            const HandState& state, HandMatrix& H, HandVector& g) const noexcept;

  /// Takes what a frame shows where the figure was laid on it: `blend` is its share of the texture
  /// and `views` how many independent views of the grid's place on the hand it counts for.
  void learn(const ImageView& frame, const Camera& camera, Appearance appearance,
             const Alignment& alignment, double blend, double views) noexcept;

 private:
  struct Sight;
  /// Of the pose of the grid, about its origin in camera axes: information and gradient.
  struct Pull {
    bool valid = false;
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    Field error{}, weight{};  ///< of what is seen against the texture in the frame's contrast
    float gain = 1;
  };

  Pull compare(const Sight& sight, const Eigen::Isometry3d& T_camera_grid) const noexcept;
  std::array<Field, 6> derivative(const Sight& sight, float gain,
                                  const Eigen::Vector3d& origin_m) const noexcept;
  void place(const Pull& seen, const Eigen::Isometry3d& T_camera_hand, const Alignment& alignment,
             double views) noexcept;
  bool knows(Appearance appearance) const noexcept;
  Matrix6d place_information(const Eigen::Isometry3d& T_camera_hand) const noexcept;

  int frames_ = 0;  ///< in which it was seen, less those in which it was not; 0: nothing is known
  Appearance appearance_;
  Field texture_{};                   ///< luma over that of the surroundings
  std::array<Field, 3> surface_m_{};  ///< the grid on the figure's palm, hand frame
  Eigen::Isometry3d T_hand_grid_ = Eigen::Isometry3d::Identity();
  Matrix6d information_ = Matrix6d::Zero();  ///< of T_hand_grid_, grid's origin, hand's axes
};

}  // namespace handyar
