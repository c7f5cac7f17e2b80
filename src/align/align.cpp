// SPDX-License-Identifier: MIT
#include "handyar/stages/align.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "align/boundary_line.hpp"
#include "align/outline_colors.hpp"
#include "align/palm_texture.hpp"
#include "align/parts_inside.hpp"
#include "align/silhouette.hpp"
#include "image/pixel_reader.hpp"
#include "vectorised.hpp"

namespace handyar {
namespace {

// Lengths of a line's segments, one iteration each, in finest ones: from coarse, which reaches far,
// to fine, which is exact.
constexpr std::array kSegments{4, 3, 2, 2, 1, 1, 1};
// Between places on the outline: as long as the two segments about the coarsest boundary.
constexpr double kSpacing_m = kEitherSide * kSegments.front() * kFinestSegment_m;
// What is visible changes little from step to step: it is looked at anew after so many.
constexpr std::size_t kChosenFor = 4;
// The palm's texture takes part in so many steps, the last: it reaches no farther than its cells.
constexpr std::size_t kTextureSteps = 2;

/// The last iteration that is as coarse: of equal ones before it there is no need.
std::size_t first_iteration(int coarsest) {
  std::size_t first = 0;
  while (first + 1 < kSegments.size() && kSegments[first + 1] >= coarsest) ++first;
  return first;
}
// The hand's colours are learned this far from its outline at most.
constexpr double kLearnInside_m = 0.0075;

/// Adds weight * J^T J.
HANDYAR_VECTORISED void add_square(const double* J, double weight, double* H) noexcept {
  for (int row = 0; row < kHandFreedoms; ++row) {
    if (J[row] == 0) continue;  // of a finger that this place is not on
    const double of_row = weight * J[row];
    for (int col = 0; col < kHandFreedoms; ++col) H[row * kHandFreedoms + col] += of_row * J[col];
  }
}

/// Adds what is known of the fingers: it keeps a finger whose colours are not known yet from
/// straying to what lies beside it, and the palm from settling within itself.
void add_fingers(const RoughFingers& fingers, const HandView& view, const Silhouette& silhouette,
                 HandMatrix& H, HandVector& g) {
  const double weight = 1 / (fingers.sigma_px * fingers.sigma_px);
  const auto add = [&](const Eigen::Vector2d& px, const Eigen::Vector2f& now_px,
                       const PlaceDerivative& J) {
    for (int axis = 0; axis < 2; ++axis) add_square(J.row(axis).data(), weight, H.data());
    g += weight * J.transpose() * (view.from_frame(px) - now_px).cast<double>();
  };
  for (int f = 0; f < kFingerCount; ++f) {
    add(fingers.tips_px[f], silhouette.tip_px(f), silhouette.tip_derivative(f));
    add(fingers.roots_px[f], silhouette.root_px(f), silhouette.root_derivative(f));
  }
}

/// How far outside of the figure's outline the picture shows it: by blur and halo, and by how the
/// hand moves until its row is read.
float shown_outside_px(const Camera& camera, const HandView& view, const Silhouette& silhouette,
                       const OutlineAnchor& anchor, const OutlinePlace& place,
                       const HandState& state) {
  double outside_px = anchor.furrow ? 0 : state.boundary_px;
  if (camera.readout_s > 0) {
    const double late_s = camera.row_time_s(view.to_frame(place.px).y());
    outside_px += late_s * silhouette.derivative(anchor, place).head<6>().dot(state.velocity);
  }
  return static_cast<float>(outside_px);
}

}  // namespace

struct Aligner::Impl {
  OutlineColors colors;
  PalmTexture texture;
  Silhouette::Anchors anchors;
  int anchor_count = 0;
  std::array<OutlinePoint, Silhouette::kMaxAnchors> outline;
  int outline_count = 0;

  float spacing_px(const Silhouette& silhouette) const noexcept {
    return static_cast<float>(silhouette.to_px(kSpacing_m));
  }

  /// One step of Gauss-Newton; returns false when too little is seen.
  bool step(const ImageView& frame, const Camera& camera, Appearance appearance,
            const HandPrior& prior, std::size_t iteration, bool choose, Alignment& a) noexcept;
};

Aligner::Aligner() : impl_(std::make_unique<Impl>()) {}
Aligner::~Aligner() = default;
Aligner::Aligner(Aligner&&) noexcept = default;
Aligner& Aligner::operator=(Aligner&&) noexcept = default;

void Aligner::forget() noexcept {
  impl_->colors.forget();
  impl_->texture.forget();
}

void Aligner::learn_texture(const ImageView& frame, const Camera& camera, Appearance appearance,
                            const Alignment& alignment, double blend, double views) noexcept {
  impl_->texture.learn(frame, camera, appearance, alignment, blend, views);
}

std::span<const OutlinePoint> Aligner::outline() const noexcept {
  return {impl_->outline.data(), static_cast<std::size_t>(impl_->outline_count)};
}

bool Aligner::Impl::step(const ImageView& frame, const Camera& camera, Appearance appearance,
                         const HandPrior& prior, std::size_t iteration, bool choose,
                         Alignment& a) noexcept {
  if (!(a.state.T_camera_hand.translation().z() > kNearest_m)) return false;
  const HandView view(camera, a.state.T_camera_hand.translation());
  const Silhouette silhouette(appearance, a.state, view);
  if (!silhouette.valid()) return false;
  const PixelReader reader(frame);
  if (choose) anchor_count = silhouette.choose(spacing_px(silhouette), anchors);
  const bool fine = kSegments[iteration] == 1;
  const float segment_px =
      std::max(1.0f, kSegments[iteration] * static_cast<float>(silhouette.to_px(kFinestSegment_m)));
  HandMatrix H = HandMatrix::Zero();
  HandVector g = HandVector::Zero();
  outline_count = 0;
  PartRatios part_log_ratios{};
  double squares = 0, weights = 0;
  for (int i = 0; i < anchor_count; ++i) {
    const OutlineAnchor& anchor = anchors[i];
    if (anchor.furrow && !fine) continue;  // it is narrower than coarse segments
    OutlinePlace place = silhouette.place(anchor);
    const OutlineDerivative J = silhouette.derivative(anchor, place);
    place.px += shown_outside_px(camera, view, silhouette, anchor, place, a.state) * place.normal;
    const int finger = finger_of(anchor.a);
    const BoundaryLine line(reader, view, place, segment_px, anchor.inside_px, anchor.outside_px);
    if (!line.inside_frame()) continue;
    const Boundary found =
        anchor.furrow ? line.find_furrow(colors, finger) : line.find(colors, finger, fine);
    const double mu = found.mean_px, sigma = found.sigma_px, z = mu / sigma;
    const double weight = kLineWeight * 2 / (1 + z * z) / (sigma * sigma);
    add_square(J.data(), weight, H.data());
    g += weight * mu * J.transpose();
    part_log_ratios[finger] += kLineWeight * found.log_ratio;
    squares += weight * mu * mu;
    weights += weight;
    outline[outline_count++] = {line.frame_px(), line.frame_normal(), found.mean_px,
                                found.log_ratio};
  }
  if (outline_count == 0) return false;
  const HandVector off = a.state.difference(prior.mean), pull = prior.information * off;
  if (iteration + kTextureSteps >= kSegments.size())
    texture.pull(frame, camera, appearance, a.state, H, g);
  if (prior.fingers) add_fingers(*prior.fingers, view, silhouette, H, g);
  H += prior.information;
  g += pull;
  a.information = H;
  a.part_log_ratios = part_log_ratios;
  a.log_ratio = std::accumulate(part_log_ratios.begin(), part_log_ratios.end(), 0.0);
  a.rms_px = std::sqrt(squares / weights);
  a.log_posterior = a.log_ratio - 0.5 * off.dot(pull);
  const Eigen::LLT<HandMatrix> llt(H);
  if (llt.info() != Eigen::Success) return false;
  a.state.correct(llt.solve(g));
  return true;
}

Alignment Aligner::align(const ImageView& frame, const Camera& camera, Appearance appearance,
                         const HandState& start, const HandPrior& prior, Steps steps) noexcept {
  Alignment a;
  a.state = start;
  a.prior = prior;
  const std::size_t first = first_iteration(steps.coarsest);
  for (std::size_t i = first; i < kSegments.size() && kSegments[i] >= steps.finest; ++i) {
    const bool choose = (i - first) % kChosenFor == 0;
    if (!impl_->step(frame, camera, appearance, prior, i, choose, a)) return a;
  }
  const Eigen::Isometry3d& T = a.state.T_camera_hand;
  a.valid = T.matrix().allFinite() && T.translation().z() > kNearest_m;
  return a;
}

PartRatios Aligner::ratios_inside(const ImageView& frame, const Camera& camera,
                                  Appearance appearance, const HandState& state) const noexcept {
  const HandView view(camera, state.T_camera_hand.translation());
  const Silhouette silhouette(appearance, state, view);
  if (!silhouette.valid()) return {};
  return ratios_of(parts_inside(frame, camera, view, silhouette, appearance, state), impl_->colors);
}

bool is_whole(const Alignment& alignment, const PartRatios& inside) noexcept {
  return std::ranges::equal(inside, alignment.part_log_ratios,
                            [](double colors, double outline) { return colors + outline >= 0; });
}

void Aligner::learn(const ImageView& frame, const Camera& camera, Appearance appearance,
                    const HandState& state, float keep, int coarsest) noexcept {
  const HandView view(camera, state.T_camera_hand.translation());
  const Silhouette silhouette(appearance, state, view);
  if (!silhouette.valid()) return;
  const PixelReader reader(frame);
  const int count = silhouette.choose(impl_->spacing_px(silhouette), impl_->anchors);
  const bool colors_count = keep > 0;
  impl_->colors.fade(keep);
  const auto step_px = static_cast<float>(silhouette.to_px(kFinestSegment_m));
  const float margin = std::max(1.0f, kEitherSide * coarsest * step_px),
              step = std::max(1.0f, step_px);
  for (int i = 0; i < count; ++i) {
    const OutlineAnchor& anchor = impl_->anchors[i];
    if (anchor.furrow) continue;
    OutlinePlace place = silhouette.place(anchor);
    place.px += shown_outside_px(camera, view, silhouette, anchor, place, state) * place.normal;
    const BoundaryLine line(reader, view, place, step, anchor.inside_px, anchor.outside_px);
    const int finger = finger_of(anchor.a);
    if (colors_count && line.inside_frame() && line.find(impl_->colors, finger, true).log_ratio < 0)
      continue;
    const float in =
        std::min(anchor.inside_px, static_cast<float>(silhouette.to_px(kLearnInside_m)));
    for (float r = margin; r < in; r += step)
      if (const auto p = line.pixel(-r))
        impl_->colors.add(finger, reader.bin(p->x(), p->y()), true);
    for (float r = margin; r < anchor.outside_px; r += step)
      if (const auto p = line.pixel(r))
        impl_->colors.add(finger, reader.bin(p->x(), p->y()), false);
  }
  // A part of a rough figure may lie beside that of the hand, on what is behind.
  impl_->colors.finish(coarsest <= kNearSteps.coarsest);
}

}  // namespace handyar
