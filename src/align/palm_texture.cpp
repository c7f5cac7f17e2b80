// SPDX-License-Identifier: MIT
#include "align/palm_texture.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "image/pixel_reader.hpp"
#include "pose/so3.hpp"
#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr int kSide = kPalmSide, kCells = kPalmCells;
using Field = PalmField;

// Neighbouring cells see the same skin and lie on the same wrong surface: so much of one's say is
// its own. Five to ten times more lets the surface's errors turn the hand (docs/tried.md).
constexpr double kCellWeight = 0.05;
// Shading changes while a hand turns; texture is what differs from so many cells around.
constexpr int kAround = 2;
// No texture is compared better than this, in levels of luma.
constexpr float kLeastSigma = 1.0f;
// With contrast changed by more than this factor it is not what was seen.
constexpr float kMostGain = 3.0f;
// A cell seen from its edge covers less (square of twice two neighbours' distance, px^4).
constexpr float kLeastArea = 1e-3f;
// Information that says nothing, in rad^-2 and m^-2.
constexpr double kVague = 1e-3;

/// The pose at the time at which the palm's rows are read.
Eigen::Isometry3d pose_at_palm(const Camera& camera, const HandState& state) {
  return state.pose_after(camera.row_time_s(camera.project(state.T_camera_hand.translation()).y()));
}

/// Sum of products, in one order in every build.
HANDYAR_VECTORISED float dot(const Field& a, const Field& b) noexcept {
  constexpr int kLanes = 8;
  std::array<float, kLanes> sums{};
  for (int i = 0; i < kCells; i += kLanes)
    for (int lane = 0; lane < kLanes; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  float sum = 0;
  for (const float lane : sums) sum += lane;
  return sum;
}

/// Turns both halves of a pose's step.
Matrix6d turn_of(const Eigen::Matrix3d& R) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = R;
  return turn;
}

/// Information H about the pose of a grid, as information about what the grid lies on: the
/// covariance of its place there is added. `with_other` factorises the sum of both informations.
Matrix6d through(const Matrix6d& H, const Eigen::LLT<Matrix6d>& with_other) {
  return H - H * with_other.solve(H);
}

}  // namespace

/// The grid in a frame.
struct PalmTexture::Sight {
  std::array<Field, 3> camera_m;  ///< camera axes, from the grid's origin
  std::array<Field, 2> px;
  Field texture, seen;  ///< seen: 1 or 0
  bool whole = true;
  float fx_px, fy_px;

  Sight(const ImageView& frame, const Camera& camera, const std::array<Field, 3>& surface_m,
        const Eigen::Isometry3d& T_camera_grid)
      : fx_px(static_cast<float>(camera.fx_px)), fy_px(static_cast<float>(camera.fy_px)) {
    const PixelReader reader(frame);
    const float right = static_cast<float>(frame.width_px - 1),
                bottom = static_cast<float>(frame.height_px - 1);
    Field luma{};
    for (int i = 0; i < kCells; ++i) {
      const Eigen::Vector3d at = T_camera_grid.linear() *
                                 Eigen::Vector3d(surface_m[0][i], surface_m[1][i], surface_m[2][i]);
      const Eigen::Vector3d p = at + T_camera_grid.translation();
      const Eigen::Vector2f to = camera.project(p).cast<float>();
      for (int axis = 0; axis < 3; ++axis) camera_m[axis][i] = static_cast<float>(at[axis]);
      px[0][i] = to.x(), px[1][i] = to.y();
      const bool inside =
          p.z() > 0 && to.x() >= 0 && to.y() >= 0 && to.x() < right && to.y() < bottom;
      seen[i] = inside ? 1.0f : 0.0f;
      whole = whole && inside;
      if (inside) luma[i] = reader.luma(to.x(), to.y());
    }
    constexpr int kFine = 1;
    const Field fine = smoothed<kFine>(luma), around = smoothed<kAround>(fine);
    for (int i = 0; i < kCells; ++i) texture[i] = fine[i] - around[i];
    if (whole) return;
    const Field all = smoothed<kFine + kAround>(seen);
    for (int i = 0; i < kCells; ++i) seen[i] = all[i] == 1 ? 1.0f : 0.0f;
  }
};

/// Of what is seen, by how the grid turns and moves: by the gradient of its texture, which has less
/// noise than the frame. Zero along the grid's edge.
std::array<Field, 6> PalmTexture::derivative(const Sight& sight, float gain,
                                             const Eigen::Vector3d& origin_m) const noexcept {
  const Field &px = sight.px[0], &py = sight.px[1];
  const auto& [atx, aty, atz] = sight.camera_m;
  const Eigen::Vector3f origin = origin_m.cast<float>();
  std::array<Field, 6> J{};
  for (int v = 1; v + 1 < kSide; ++v)
    for (int i = v * kSide + 1; i + 1 < (v + 1) * kSide; ++i) {
      const auto across = [i](const Field& f) { return f[i + 1] - f[i - 1]; };
      const auto up = [i](const Field& f) { return f[i + kSide] - f[i - kSide]; };
      const float xu = across(px), yu = across(py), xv = up(px), yv = up(py);
      const float area = xu * yv - yu * xv;
      const float per_area = area * area > kLeastArea ? gain / area : 0;
      const float gu = across(texture_), gv = up(texture_);
      const float x = atx[i] + origin.x(), y = aty[i] + origin.y(), z = atz[i] + origin.z();
      const float bx = (gu * yv - gv * yu) * per_area * sight.fx_px / z,
                  by = (gv * xu - gu * xv) * per_area * sight.fy_px / z,
                  bz = -(bx * x + by * y) / z;
      J[0][i] = aty[i] * bz - atz[i] * by;
      J[1][i] = atz[i] * bx - atx[i] * bz;
      J[2][i] = atx[i] * by - aty[i] * bx;
      J[3][i] = bx, J[4][i] = by, J[5][i] = bz;
    }
  return J;
}

bool PalmTexture::knows(Appearance appearance) const noexcept {
  return frames_ > 0 && appearance == appearance_;
}

Matrix6d PalmTexture::place_information(const Eigen::Isometry3d& T_camera_hand) const noexcept {
  const Matrix6d turn = turn_of(T_camera_hand.linear());
  return turn * information_ * turn.transpose() + kVague * Matrix6d::Identity();
}

PalmTexture::Pull PalmTexture::compare(const Sight& sight,
                                       const Eigen::Isometry3d& T) const noexcept {
  Pull pull;
  Field &error = pull.error, &weight = pull.weight;
  weight = sight.seen;
  float sigma = 0;
  for (int round = 0; round < 2; ++round) {
    Field weighted;
    for (int i = 0; i < kCells; ++i) weighted[i] = weight[i] * texture_[i];
    pull.gain = dot(weighted, sight.texture) / (dot(weighted, texture_) + 1e-6f);
    for (int i = 0; i < kCells; ++i) error[i] = sight.texture[i] - pull.gain * texture_[i];
    float sum = 0, count = 1e-6f;
    for (int i = 0; i < kCells; ++i) {
      sum += sight.seen[i] * std::abs(error[i]);
      count += sight.seen[i];
    }
    constexpr float kNormal = 1.25f;  // standard deviation of a mean size
    sigma = std::max(kNormal * sum / count, kLeastSigma);
    for (int i = 0; i < kCells; ++i) {
      const float z = error[i] / (2 * sigma);
      weight[i] = sight.seen[i] / (1 + z * z);
    }
  }
  if (!(pull.gain > 1 / kMostGain && pull.gain < kMostGain)) return pull;

  const std::array<Field, 6> J = derivative(sight, pull.gain, T.translation());
  const double scale = kCellWeight / (sigma * sigma);
  for (int k = 0; k < 6; ++k) {
    Field weighted;
    for (int i = 0; i < kCells; ++i) weighted[i] = weight[i] * J[k][i];
    pull.g[k] = -scale * dot(weighted, error);
    for (int l = k; l < 6; ++l) pull.H(k, l) = pull.H(l, k) = scale * dot(weighted, J[l]);
  }
  // How far away the grid is depends on how large it is, which the outline knows better.
  Vector6d away = Vector6d::Zero();
  away.tail<3>() = T.translation().normalized();
  const Vector6d by_distance = pull.H * away;
  const double distance_information = away.dot(by_distance) + 1e-9;
  pull.g -= by_distance * (away.dot(pull.g) / distance_information);
  pull.H -= by_distance * by_distance.transpose() / distance_information;
  pull.valid = pull.H.allFinite() && pull.g.allFinite();
  return pull;
}

void PalmTexture::pull(const ImageView& frame, const Camera& camera, Appearance appearance,
                       const HandState& state, HandMatrix& H, HandVector& g) const noexcept {
  if (!knows(appearance)) return;
  const Eigen::Isometry3d T_camera_hand = pose_at_palm(camera, state);
  const Eigen::Isometry3d T_camera_grid = T_camera_hand * T_hand_grid_;
  const Pull seen = compare(Sight(frame, camera, surface_m_, T_camera_grid), T_camera_grid);
  if (!seen.valid) return;
  const Eigen::LLT<Matrix6d> llt(seen.H + place_information(T_camera_hand));
  H.topLeftCorner<6, 6>() += through(seen.H, llt);
  g.head<6>() += seen.g - seen.H * llt.solve(seen.g);
}

void PalmTexture::learn(const ImageView& frame, const Camera& camera, Appearance appearance,
                        const Alignment& alignment, double blend, double views) noexcept {
  const Eigen::Isometry3d T_camera_hand = pose_at_palm(camera, alignment.state);
  surface_m_ =
      palm_surface(make_figure(alignment.state.figure, appearance.face, appearance.layout));
  const bool known = knows(appearance);
  if (!known) T_hand_grid_.setIdentity();
  const Eigen::Isometry3d T_camera_grid = T_camera_hand * T_hand_grid_;
  const Sight sight(frame, camera, surface_m_, T_camera_grid);
  if (!known) {
    frames_ = sight.whole ? 1 : 0;
    appearance_ = appearance;
    texture_ = sight.texture;
    information_.setZero();
    return;
  }
  const Pull seen = compare(sight, T_camera_grid);
  if (!seen.valid) {
    --frames_;  // blurred or hidden in one frame, it is still known in the next
    return;
  }
  place(seen, T_camera_hand, alignment, views);
  frames_ = static_cast<int>(std::min(frames_ + 1.0, 1 / blend));
  const float share = 1.0f / static_cast<float>(frames_);
  for (int i = 0; i < kCells; ++i)
    texture_[i] += share * seen.weight[i] * seen.error[i] / seen.gain;
}

/// Where the grid lies on the hand, by one more outline.
void PalmTexture::place(const Pull& seen, const Eigen::Isometry3d& T_camera_hand,
                        const Alignment& alignment, double views) noexcept {
  const Eigen::LLT<Matrix6d> llt(seen.H + place_information(T_camera_hand));
  // The outline's information of the pose: that of all, less the texture's part of it.
  const Matrix6d outline = pose_information(alignment.information) - through(seen.H, llt);
  const Eigen::LLT<Matrix6d> with_outline(seen.H + outline);
  if (with_outline.info() != Eigen::Success) return;
  const Matrix6d to_hand = turn_of(T_camera_hand.linear().transpose());
  const Matrix6d frame = to_hand * through(seen.H, with_outline) * to_hand.transpose(),
                 learned = information_ + views * frame;
  const Eigen::LLT<Matrix6d> of_learned(learned + kVague * Matrix6d::Identity());
  // The likeliest place by this frame is the mean of what was known and what the frame says: so
  // much of the way is the frame's, as for the person.
  const Vector6d step =
      of_learned.solve(views * ((information_ + frame) * (to_hand * llt.solve(seen.g))));
  if (!step.allFinite() || !learned.allFinite()) return;
  information_ = 0.5 * (learned + learned.transpose());
  T_hand_grid_.linear() = so3::turned(step.head<3>(), T_hand_grid_.linear());
  T_hand_grid_.translation() += step.tail<3>();
}

}  // namespace handyar
