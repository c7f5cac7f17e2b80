// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace handyar {

/// The fingers, always in this order.
enum class Finger : std::uint8_t { thumb, index, middle, ring, little };
inline constexpr int kFingerCount = 5;
inline constexpr int kValleyCount = 4;  ///< valley i lies between finger i and finger i + 1
inline constexpr std::array<std::string_view, kFingerCount> kFingerNames = {
    "thumb", "index", "middle", "ring", "little"};

/// On which side the thumb is when the visible face is looked at with the fingers up. The back of a
/// left hand and the palm of a right hand share `thumb_right`.
enum class Layout : std::uint8_t { thumb_right, thumb_left };
std::string_view name(Layout layout) noexcept;
constexpr Layout opposite(Layout l) noexcept {
  return l == Layout::thumb_right ? Layout::thumb_left : Layout::thumb_right;
}

/// Where a hand model's figures come from.
enum class HandSource : std::uint8_t { checkerboard, average_adult, self, truth };

/// Fingertip positions in the hand frame, in metres (paper 2.4 and Figure 5).
///
/// Hand frame: origin at the x of the middle fingertip, the y of the thumb tip and the mean z of
/// the five tips; +y along the middle finger towards its tip; +z out of the visible face, towards
/// the camera; +x completes a right-handed frame, so the thumb is at +x in `thumb_right`.
struct HandModel {
  Eigen::Matrix<double, 3, kFingerCount> tips_m = Eigen::Matrix<double, 3, kFingerCount>::Zero();
  Layout layout = Layout::thumb_right;  ///< in which `tips_m` was measured
  HandSource source = HandSource::average_adult;
  double rms_px = 0.0;         ///< reprojection error of the measurement
  double thickness_m = 0.005;  ///< height of the visible face of a fingertip above what it lies on

  /// Standard deviations of `tips_m`, 0 = unknown. The average hand's: how people's hands vary.
  Eigen::Matrix<double, 3, kFingerCount> tips_sigma_m =
      Eigen::Matrix<double, 3, kFingerCount>::Zero();

  // Measured by calibration since file format version 2, axes since 3; empty where unknown.
  bool has_valleys = false;
  Eigen::Matrix<double, 3, kValleyCount> valleys_m = Eigen::Matrix<double, 3, kValleyCount>::Zero();
  /// Of each finger's axis, the line in the middle between its sides: a point near the fingertip
  /// and one near the valleys.
  bool has_axes = false;
  Eigen::Matrix<double, 3, kFingerCount> axis_ends_m =
      Eigen::Matrix<double, 3, kFingerCount>::Zero();
  Eigen::Matrix<double, 3, kFingerCount> axis_roots_m =
      Eigen::Matrix<double, 3, kFingerCount>::Zero();
  std::vector<Eigen::Vector2d> outline_m;  ///< closed contour in the hand plane, wrist to wrist

  bool average_scale = false;  ///< the shape was measured, the size is the average adult's

  /// True when the metric size was not measured on this hand.
  bool scale_assumed() const noexcept {
    return source == HandSource::average_adult || average_scale;
  }

  /// The same hand seen in `wanted`: x is mirrored where the layouts differ.
  HandModel for_layout(Layout wanted) const;

  /// Where each finger turns when the fingers spread, in the hand plane: three tenths of its free
  /// length behind its root between the valleys, or by an average hand's proportions where the
  /// valleys are not known.
  Eigen::Matrix<double, 2, kFingerCount> knuckles_m() const noexcept;

  /// Unit directions of the fingers in the hand plane, knuckle to tip; z is 0.
  Eigen::Matrix<double, 3, kFingerCount> directions() const noexcept;

  /// Unit directions in the hand plane in which the valleys open: halfway between their fingers.
  Eigen::Matrix<double, 3, kValleyCount> valley_directions() const noexcept;

  /// Where an object stands: the middle of the palm (or of the back of the hand). The hand frame's
  /// origin lies at the height of the thumb tip, where the fingers begin; from there the palm
  /// reaches towards the wrist about as far as the middle finger reaches up, and its middle is 0.3
  /// of the middle fingertip's y below the origin.
  Eigen::Vector3d palm_centre_m() const noexcept {
    constexpr int kMiddle = static_cast<int>(Finger::middle);
    return {0, -0.3 * tips_m(1, kMiddle), 0};
  }

  /// Distance from thumb tip to little fingertip.
  double span_m() const noexcept { return (tips_m.col(0) - tips_m.col(4)).norm(); }
};

/// A fingertip is round, so its outline does not end at a point of the finger: seen from any side
/// it ends this far from a point within (the radius in which a finger ends, not its half width).
inline constexpr double kTipRadius_m = 0.0035;
/// So is the web between two fingers, from back to palm.
inline constexpr double kWebRadius_m = 0.006;

/// The sine below which a finger points at the eye and its outline has no end.
inline constexpr double kEndOn = 0.2;

/// Where the outline of a round end is as seen from `eye_m`, given where it is seen from straight
/// above (`end_m`) and the unit direction in which the finger ends or the valley opens; all in one
/// frame.
Eigen::Vector3d outline_end_m(const Eigen::Vector3d& end_m, const Eigen::Vector3d& direction,
                              double radius_m, const Eigen::Vector3d& eye_m) noexcept;

/// From the crease of the wrist to the tip of the middle finger, of average_adult_hand().
inline constexpr double kAverageHandLength_m = 0.187;

/// The average adult hand, fingers comfortably spread; the source of the figures stands with them
/// in hand_model.cpp.
HandModel average_adult_hand();

}  // namespace handyar
