// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "handyar/api.h"

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
[[nodiscard]] HANDYAR_API std::string_view name(Layout layout) noexcept;
[[nodiscard]] constexpr Layout opposite(Layout l) noexcept {
  return l == Layout::thumb_right ? Layout::thumb_left : Layout::thumb_right;
}

/// Which face of the hand is seen.
enum class Face : std::uint8_t { palm, back };
[[nodiscard]] HANDYAR_API std::string_view name(Face face) noexcept;
[[nodiscard]] constexpr Face opposite(Face face) noexcept {
  return face == Face::palm ? Face::back : Face::palm;
}

/// Which of a person's hands.
enum class Side : std::uint8_t { left, right };
[[nodiscard]] HANDYAR_API std::string_view name(Side side) noexcept;
[[nodiscard]] constexpr Side side_of(Face face, Layout layout) noexcept {
  return (face == Face::palm) == (layout == Layout::thumb_right) ? Side::right : Side::left;
}

/// Where a hand model's figures come from.
enum class HandSource : std::uint8_t { checkerboard, average_adult, self, truth };

/// A person's figure: coefficients of the principal components of many hands (tools/hand_figure),
/// so that figure = mean + modes * coefficients. Those of a person drawn at random are independent
/// and standard normal.
inline constexpr int kFigureModes = 12;
using FigureCoefficients = Eigen::Matrix<double, kFigureModes, 1>;

/// A person's figure as far as it is known; the default: a person drawn at random.
struct FigureEstimate {
  FigureCoefficients mean = FigureCoefficients::Zero();
  Eigen::Matrix<double, kFigureModes, kFigureModes> covariance =
      Eigen::Matrix<double, kFigureModes, kFigureModes>::Identity();
};

/// Fingertip positions in the hand frame, in metres (paper 2.4 and Figure 5).
///
/// Hand frame: origin at the x of the middle fingertip, the y of the thumb tip and the mean z of
/// the five tips; +y along the middle finger towards its tip; +z out of the visible face, towards
/// the camera; +x completes a right-handed frame, so the thumb is at +x in `thumb_right`.
struct HANDYAR_API HandModel {
  Eigen::Matrix<double, 3, kFingerCount> tips_m = Eigen::Matrix<double, 3, kFingerCount>::Zero();
  Layout layout = Layout::thumb_right;  ///< in which `tips_m` was measured
  HandSource source = HandSource::average_adult;
  double rms_px = 0.0;         ///< reprojection error of the measurement
  double thickness_m = 0.005;  ///< height of the visible face of a fingertip above what it lies on

  /// Standard deviations of `tips_m`, 0 = unknown. The average hand's: how people's hands vary.
  Eigen::Matrix<double, 3, kFingerCount> tips_sigma_m =
      Eigen::Matrix<double, 3, kFingerCount>::Zero();

  bool average_scale = false;  ///< the shape was measured, the size is the average adult's

  /// The person's figure as far as it was learned (file format version 4); empty: what the tips
  /// tell of it, see estimate_figure().
  std::optional<FigureEstimate> figure;

  /// True when the metric size was not measured on this hand.
  [[nodiscard]] bool scale_assumed() const noexcept {
    return source == HandSource::average_adult || average_scale;
  }

  /// The same hand seen in `wanted`: x is mirrored where the layouts differ.
  [[nodiscard]] HandModel for_layout(Layout wanted) const;

  /// Where an object stands: the middle of the palm (or of the back of the hand). The hand frame's
  /// origin lies at the height of the thumb tip, where the fingers begin; from there the palm
  /// reaches towards the wrist about as far as the middle finger reaches up, and its middle is 0.3
  /// of the middle fingertip's y below the origin.
  [[nodiscard]] Eigen::Vector3d palm_centre_m() const noexcept {
    constexpr int kMiddle = static_cast<int>(Finger::middle);
    return {0, -0.3 * tips_m(1, kMiddle), 0};
  }

  /// Distance from thumb tip to little fingertip.
  [[nodiscard]] double span_m() const noexcept { return (tips_m.col(0) - tips_m.col(4)).norm(); }
};

/// From the crease of the wrist to the tip of the middle finger, of average_adult_hand().
inline constexpr double kAverageHandLength_m = 0.187;

/// The average adult hand, fingers comfortably spread; the source of the figures stands with them
/// in hand_model.cpp.
[[nodiscard]] HANDYAR_API HandModel average_adult_hand();

}  // namespace handyar
