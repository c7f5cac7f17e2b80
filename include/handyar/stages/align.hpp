// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "handyar/camera.hpp"
#include "handyar/image_view.hpp"
#include "handyar/pose.hpp"
#include "handyar/stages/hand_figure.hpp"

namespace handyar {

/// What is estimated of a hand in one frame, in this order: rotation (3, on the left, camera axes),
/// translation (3), abduction and flexion of each finger, the thumb's bend in the palm plane, by
/// how much the outline in the picture lies outside the figure's (blur and halo), and the person's
/// figure.
inline constexpr int kAbductionAt = 6, kFlexionAt = 11, kThumbBendAt = 16, kBoundaryAt = 17,
                     kFigureAt = 18, kHandFreedoms = kFigureAt + kFigureModes;
using HandVector = Eigen::Matrix<double, kHandFreedoms, 1>;
using HandMatrix = Eigen::Matrix<double, kHandFreedoms, kHandFreedoms>;

struct HandState {
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  Posture posture;
  double boundary_px = 0;
  FigureCoefficients figure = FigureCoefficients::Zero();
  /// Of the pose, a second: rotation on the left, translation. Not estimated in a frame: it tells
  /// where the hand was when other rows than the middle one were read, and will be.
  Eigen::Matrix<double, 6, 1> velocity = Eigen::Matrix<double, 6, 1>::Zero();

  /// The pose so much later; it goes on as it went for kLongest_s at most.
  Eigen::Isometry3d pose_after(double dt_s) const noexcept;

  void correct(const HandVector& step) noexcept;
  HandVector difference(const HandState& other) const noexcept;  ///< other minus this
};

/// Fingertips and the fingers' roots as a finder gives them: rough.
struct RoughFingers {
  std::array<Eigen::Vector2d, kFingerCount> tips_px, roots_px;
  double sigma_px;
};

/// What is known of the state before the figure is laid on the frame.
struct HandPrior {
  HandState mean;
  HandMatrix information = HandMatrix::Identity();  ///< inverse covariance
  std::optional<RoughFingers> fingers;              ///< in the frame itself
};

/// Which of its four appearances a hand has: two faces, two layouts.
struct Appearance {
  Face face = Face::palm;
  Layout layout = Layout::thumb_right;

  bool operator==(const Appearance&) const = default;
};

/// Which hand of a person shows it.
constexpr Side side_of(Appearance a) noexcept { return side_of(a.face, a.layout); }

/// The figure that a state has in one of its appearances, its fingers as they are held.
PosedFigure posed_figure(Appearance appearance, const HandState& state) noexcept;

/// A place on the outline of the figure, in pixels of the frame, and what the picture says of it.
struct OutlinePoint {
  Eigen::Vector2f px, normal;  ///< outwards
  float found_px = 0;          ///< how far outside of it the picture's boundary lies
  float log_ratio = 0;         ///< for a boundary here against one anywhere near, nats
};

/// The first and the last steps of an alignment, by how coarse the lines across the outline are:
/// they reach 5 mm to each side at 1, 21 mm at 4.
struct Steps {
  int coarsest = 4, finest = 1;
};
inline constexpr Steps kFarSteps{4, 1}, kNearSteps{2, 1};

/// What a picture says of the hand's parts, the fingers and last the palm: log likelihood ratios of
/// each there against not, nats.
using PartRatios = std::array<double, kFingerCount + 1>;

/// A figure laid on a picture.
struct Alignment {
  bool valid = false;  ///< false: no such hand can be seen, the rest is meaningless
  HandState state;
  HandPrior prior;                              ///< with which it was laid
  HandMatrix information = HandMatrix::Zero();  ///< inverse covariance of the state, prior included
  /// Log likelihood ratio of a hand there against none, of this frame alone, nats.
  double log_ratio = 0;
  PartRatios part_log_ratios{};  ///< what it is the sum of, by whose outline it is
  /// Less the prior's cost: what tells appearances and planar solutions apart.
  double log_posterior = 0;
  double rms_px = 0;  ///< between the figure's outline and the picture's, outliers weighing less
};

/// Whether every part of a hand is there, by its outline and by what the colours inside say.
bool is_whole(const Alignment& alignment, const PartRatios& inside) noexcept;

/// The pose's part of a state's information, the rest marginalised out (Schur complement).
Matrix6d pose_information(const HandMatrix& information) noexcept;

/// Lays a hand figure on pictures, by the colours on both sides of its outline and by edges, and
/// learns the colours. Region-based tracking with sparse lines after Stoiber et al., "SRT3D"
/// (IJCV 2022), with fingers that move and an outline that may lie outside the figure's.
class Aligner {
 public:
  Aligner();
  ~Aligner();
  Aligner(Aligner&&) noexcept;
  Aligner& operator=(Aligner&&) noexcept;

  /// Forgets the colours and the palm's texture.
  void forget() noexcept;

  /// Steps from coarse to fine from `start` on, whose outline is off by no more than the coarsest
  /// lines reach.
  Alignment align(const ImageView& frame, const Camera& camera, Appearance appearance,
                  const HandState& start, const HandPrior& prior, Steps steps) noexcept;

  /// Takes colours from both sides of the outline of a state; older ones fade to `keep`. Two
  /// segments of lines as coarse as `coarsest` are left out on both sides: the picture blurs the
  /// outline, and a figure that such lines are still to move lies off by as much. Where the colours
  /// so far tell of a boundary elsewhere, none are taken: the figure lies wrong there, and would be
  /// confirmed in it.
  void learn(const ImageView& frame, const Camera& camera, Appearance appearance,
             const HandState& state, float keep, int coarsest) noexcept;

  /// Takes what the skin of the palm looks like, for frames to come: `blend` is this frame's share
  /// of it, and it counts for so many independent `views` of where the palm lies.
  void learn_texture(const ImageView& frame, const Camera& camera, Appearance appearance,
                     const Alignment& alignment, double blend, double views) noexcept;

  /// What the colours inside a state's figure say of its parts: of points along each finger from
  /// its middle joint on, and over the palm, whether they are those of the rest of the hand or
  /// those behind it; one that is neither's lies rather behind, where there are more colours, the
  /// more so the fewer such points the other parts have. A part's own would not tell, for they were
  /// learned from what it was laid on; nor do points where another part lies, too, and a finger
  /// most of whose points are such is folded. Nothing where most of a part is out of the frame.
  PartRatios ratios_inside(const ImageView& frame, const Camera& camera, Appearance appearance,
                           const HandState& state) const noexcept;

  /// The outline of the last alignment. Valid until the next call.
  std::span<const OutlinePoint> outline() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handyar
