// SPDX-License-Identifier: MIT
#include "align/parts_inside.hpp"

#include <algorithm>

#include "align/boundary_line.hpp"
#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

using Inside = Eigen::Matrix<double, 3, kMostInside>;
Inside points_inside(const PosedFigure& posed, int part) {
  constexpr int kAcross = 4;  // points in a row of the palm
  Inside points;
  const auto mix = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double t) {
    return ((1 - t) * a + t * b).eval();
  };
  const auto centre = [&](int sphere) { return posed.centres_m.col(sphere).eval(); };
  for (int i = 0; i < kMostInside; ++i) {
    if (part < kFingerCount) {
      const double t = 2.0 * i / (kMostInside - 1);  // in bones
      const int bone = std::min(static_cast<int>(t), 1);
      points.col(i) =
          mix(centre(sphere_of(part, 1 + bone)), centre(sphere_of(part, 2 + bone)), t - bone);
      continue;
    }
    const double across = (i % kAcross + 0.5) / kAcross, up = (i / kAcross + 0.5) / kAcross;
    points.col(i) = mix(mix(centre(kWristThumb), centre(kWristLittle), across),
                        mix(centre(sphere_of(1, 0)), centre(sphere_of(4, 0)), across), up);
  }
  return points;
}

using Shares = std::array<OutlineColors::Shares, kMostInside>;

/// How many points have new colours, of how many.
struct Novelty {
  float points = 0;
  int of = 0;
};

}  // namespace

PartsInside parts_inside(const ImageView& frame, const Camera& camera, const HandView& view,
                         const Silhouette& silhouette, Appearance appearance,
                         const HandState& state) noexcept {
  PartsInside parts;
  const PixelReader reader(frame);
  const PosedFigure posed = posed_figure(appearance, state);
  for (int p = 0; p < OutlineColors::kParts; ++p) {
    PartInside& part = parts[p];
    const Inside points = points_inside(posed, p);
    for (int i = 0; i < kMostInside; ++i) {
      const Eigen::Vector2d at_px = camera.project(state.T_camera_hand * points.col(i));
      const Eigen::Vector2f px = at_px.cast<float>();
      if (!reader.covers(px.x(), px.y())) continue;
      if (p < kFingerCount && silhouette.others_cover(p, view.from_frame(at_px)))
        ++part.covered;
      else
        part.bins[part.count++] = reader.bin(reader.nearest_x(px.x()), reader.nearest_y(px.y()));
    }
  }
  return parts;
}

PartRatios ratios_of(const PartsInside& parts, const OutlineColors& colors) noexcept {
  PartRatios inside{};
  std::array<Shares, OutlineColors::kParts> shares{};
  std::array<Novelty, OutlineColors::kParts> novelty{};
  Novelty of_all{0.5f, 1};  // so that few points do not say that none or all are new
  for (int p = 0; p < OutlineColors::kParts; ++p) {
    const PartInside& part = parts[p];
    if (part.unknown()) continue;
    if (part.folded()) {
      inside[p] = -kMostInside * kLineWeight * kMostEvidence;
      continue;
    }
    for (int i = 0; i < part.count; ++i) {
      shares[p][i] = colors.shares_by_rest(p, part.bins[i]);
      novelty[p].points += shares[p][i].novelty();
    }
    novelty[p].of = part.count;
    of_all.points += novelty[p].points;
    of_all.of += novelty[p].of;
  }
  for (int p = 0; p < OutlineColors::kParts; ++p) {
    const float elsewhere = (of_all.points - novelty[p].points) / (of_all.of - novelty[p].of);
    // A point tells as much as a line across the outline, and may be wrong as well.
    for (int i = 0; i < novelty[p].of; ++i)
      inside[p] += kLineWeight *
                   std::clamp(shares[p][i].log_ratio(elsewhere), -kMostEvidence, kMostEvidence);
  }
  return inside;
}

}  // namespace handyar
