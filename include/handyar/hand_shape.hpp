// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <span>

#include "handyar/fingertips.hpp"
#include "handyar/hand_model.hpp"
#include "handyar/hand_region.hpp"

namespace handyar {

struct HandShapeConfig {
  double min_valley_depth = 0.35;  ///< between neighbouring fingers, in palm radii
  /// Largest deviation from the shape of hands, in standard deviations (rms); most hands are
  /// below 1.
  double max_deviation = 1.1;
  double sure_deviation = 0.6;  ///< below this there is no need to look a second time
  double posture_share =
      0.7;                   ///< how much of the variation among hands one and the same hand shows
  double min_aspect = 0.30;  ///< smaller over larger scale of the affine map: cosine of the tilt
  double min_palm_fill = 0.85;    ///< share of the palm disc that lies in the region
  double min_finger_fill = 0.75;  ///< share of a finger's stations that are as wide as a finger
  double max_raggedness = 1.35;  ///< length of the boundary of the fingers over its smoothed length
  double tracked_deviation = 1.6;    ///< times max_deviation, of a hand that is tracked or lost
  double tracked_aspect = 0.6;       ///< times min_aspect, the same
  double acquired_deviation = 1.25;  ///< times max_deviation, of one that is being acquired
  double turned_over_share = 0.7;    ///< of its deviation: less, the other way round, is that
  double max_leap = 0.35;    ///< how much more a hand may deviate than a frame before, until
                             ///< its own shape is known
  double misread_m = 0.014;  ///< a tip that much further than usual from where the others say
                             ///< that it is was misread, see OwnShape::OddTip
  double odd_tip_m = 0.025;  ///< a hand is none whose tip is that much further than usual from
                             ///< where the measured hand has it,
  double average_odd_tip_m = 0.035;   ///< or, where none was measured, the average one
  double own_memory_s = 0.7;          ///< over which a tracked hand's own shape is averaged
  double own_deviation_share = 0.75;  ///< of max_deviation: frames below it are likely right,
                                      ///< and its own shape is learned from them
};

/// Five fingers found on a contour, in finger order, in mask pixels.
struct HandShape {
  Layout layout = Layout::thumb_right;
  std::array<int, kFingerCount> tip_samples{};  ///< into the resampled contour
  std::array<Eigen::Vector2f, kFingerCount> tips;
  std::array<Eigen::Vector2f, kValleyCount> valleys;
  std::array<bool, kFingerCount> tip_seen{};
  std::array<bool, kValleyCount> valley_seen{};
  Eigen::Matrix<float, 2, 3> image_hand;  ///< affine map from the average hand's plane (metres)
  float deviation = 0;                    ///< from the shape of hands, standard deviations (rms)
  float finger_width = 0;                 ///< expected, mask pixels

  Eigen::Vector2f palm() const noexcept;                   ///< its centre, mask pixels
  float palm_radius() const noexcept;                      ///< mask pixels
  Eigen::Vector2f finger_base(int finger) const noexcept;  ///< where it leaves the hand

  /// Box around fingers, palm and wrist.
  Eigen::AlignedBox2f bounds() const noexcept;

  /// Where its palm and fingers are.
  ExpectedHand parts() const noexcept;

  /// Where a picture of `width` x `height` pixels shows this hand, give or take half a finger.
  void expect(int width, int height, ExpectedRegion& region) const noexcept;

  /// True when all tips lie within a fifth of the span of the other shape's, fingers the same.
  bool resembles(const HandShape& other) const noexcept;

  /// True when a hand that looked like `last` may look like this a few frames later.
  bool may_follow(const HandShape& last) const noexcept;

  /// `image_hand` for a plane in which the thumb is on the right, whatever the layout.
  Eigen::Matrix<float, 2, 3> image_thumb_right() const noexcept;
  /// Tips and valleys in that plane, in metres; thumb_right.
  HandShape in_hand_plane() const noexcept;
  /// The other way round: such a shape where an image shows it, given image_thumb_right().
  HandShape laid(const Eigen::Matrix<float, 2, 3>& image_thumb_right,
                 Layout image_layout) const noexcept;

  /// The same shape in other pixels: p -> scale * p + offset.
  HandShape transformed(float scale, const Eigen::Vector2f& offset) const noexcept;
  Eigen::Vector2f to_image(const Eigen::Vector2f& p_hand_m) const noexcept {
    return image_hand.leftCols<2>() * p_hand_m + image_hand.col(2);
  }
};

/// A straight part of the hand; `along` 0: a point.
struct HandAxis {
  Eigen::Vector2f from = Eigen::Vector2f::Zero(), along = Eigen::Vector2f::Zero();
  float per_length2 = 0;

  HandAxis() = default;
  explicit HandAxis(const Eigen::Vector2f& point) noexcept : from(point) {}
  HandAxis(const Eigen::Vector2f& start, const Eigen::Vector2f& way) noexcept
      : from(start), along(way), per_length2(1 / way.squaredNorm()) {}
  /// From its nearest point to `p`.
  Eigen::Vector2f offset(const Eigen::Vector2f& p) const noexcept {
    const Eigen::Vector2f d = p - from;
    return d - std::clamp(d.dot(along) * per_length2, 0.0f, 1.0f) * along;
  }
};

/// Where a hand, or the forearm behind it, may be: near a finger, the palm or the wrist.
class HandReach {
 public:
  explicit HandReach(const HandShape& shape) noexcept;
  bool holds(const Eigen::Vector2f& p) const noexcept;

 private:
  std::array<HandAxis, kFingerCount> fingers_;
  Eigen::Matrix<float, 2, 3> hand_image_;  ///< into the hand's plane
  Eigen::Vector2f palm_m_;
  float finger_width2_;
};

/// The average outstretched hand, thumb_right: in metres of its own plane instead of pixels.
HandShape average_hand_shape() noexcept;

/// Where the valleys of a hand are likely to be, in its own frame, after its tips and the average
/// hand's: good to some millimetres in the hand plane.
Eigen::Matrix<double, 3, kValleyCount> average_valleys_m(const HandModel& hand) noexcept;

/// What outstretched hands look like, or one measured hand: nine points in a plane and how they
/// vary once the best affine map is taken off.
class HandShapeModel {
 public:
  HandShapeModel();  ///< hands in general

  /// This hand, where its tips and valleys were measured; else hands in general.
  HandShapeModel(const HandModel& hand, const HandShapeConfig& config);

  /// Fits the shape's tips and valleys affinely and compares what is left with how hands vary; sets
  /// image_hand, deviation and finger_width. False when the shape is no hand's; where the map alone
  /// tells that, the deviation is the largest number.
  bool fit(const HandShapeConfig& config, HandShape& shape) const noexcept;

 private:
  static constexpr int kPoints = kFingerCount + kValleyCount;
  void set_mean(const Eigen::Matrix<double, 2, kPoints>& mean_m);

  Eigen::Matrix<float, 3, kPoints> mean_;  ///< metres, thumb_right; last row ones
  Eigen::Matrix<float, kPoints, 3> fit_;   ///< affine map = points * fit_
  float strictness_ = 1;
};

/// How one hand's tips and valleys lie to each other, learned while it is tracked: for a while a
/// hand keeps its posture, and a finger that suddenly is much shorter or longer was misread. Or as
/// a hand model has them, from the first frame on.
class OwnShape {
 public:
  OwnShape() = default;
  /// As a model has it; with the valleys of an average hand of its tips where it has none.
  explicit OwnShape(const HandModel& hand) noexcept;

  void reset() noexcept { weight_ = 0; }

  /// Enough was learned to tell where a point of this hand should be.
  bool is_known() const noexcept { return weight_ >= kEnoughFrames; }

  /// The layout of what was learned last.
  Layout layout() const noexcept { return layout_; }

  /// This hand as it was learned, where `shape` is.
  HandShape laid_on(const HandShape& shape) const noexcept;

  /// Takes in a verified shape with all tips and valleys; `share` is its weight in the mean.
  void learn(const HandShape& shape, float share) noexcept;

  struct OddTip {
    int finger = -1;     ///< -1: none, or too little is known
    float off_m = 0;     ///< how much further than usual it is from its place
    float px_per_m = 0;  ///< of the hand, where it is
  };
  /// The tip without which all other points agree best with each other, to `agree_m` at least, and
  /// how far it is from where they say that it is.
  OddTip odd_tip(const HandShape& shape, float agree_m) const noexcept;

  /// Puts a tip where the points that are seen say that it is. False when too little is known.
  bool infer_tip(int finger, HandShape& shape) const noexcept;

 private:
  static constexpr int kPoints = kFingerCount + kValleyCount;
  Eigen::Matrix<float, 3, kPoints> mean_;  ///< metres, in an affine frame of its own; last row ones
  static constexpr float kEnoughFrames = 10;
  float weight_ = 0;  ///< frames, until it is enough
  Layout layout_ = Layout::thumb_right;

  bool knows(const HandShape& shape) const noexcept;
};

/// Looks for five neighbouring tips with valleys between them that an affine image of the model
/// explains (paper 2.2 asks for five tips around the palm; the whole shape is asked for here, so
/// that the hand may point anywhere). Thumb and layout follow from which way round fits better.
/// Returns false when nothing hand-like is there.
bool find_hand_shape(const CurvatureFinder& curvature, const Contour& contour, const Mask& mask,
                     float palm_radius, const HandShapeModel& model, const HandShapeConfig& config,
                     HandShape& best) noexcept;

/// True when palm and fingers of the shape are filled by the region, and the fingers are as wide as
/// fingers. All valleys must be set.
bool fills_region(const HandShape& shape, const Mask& mask, const HandShapeConfig& config) noexcept;

}  // namespace handyar
