// SPDX-License-Identifier: MIT
#include "align/palm_grid.hpp"

namespace handyar {
namespace {

// A palm reaches beyond the spheres at its corners by this share of their radii.
constexpr float kWider = 0.6f;

}  // namespace

std::array<PalmField, 3> palm_surface(const HandFigure& figure) noexcept {
  const auto top = [&](int sphere) -> Eigen::Vector3f {
    return (figure.centres_m.col(sphere) + Eigen::Vector3d(0, 0, figure.radii_m[sphere]))
        .cast<float>();
  };
  const auto side = [&](int sphere, int from) -> Eigen::Vector3f {
    const Eigen::Vector3f outwards = (top(sphere) - top(from)).normalized();
    return top(sphere) + kWider * static_cast<float>(figure.radii_m[sphere]) * outwards;
  };
  const int first = sphere_of(1, 0), last = sphere_of(4, 0);
  const Eigen::Vector3f wrist_thumb = side(kWristThumb, kWristLittle),
                        wrist_little = side(kWristLittle, kWristThumb), index = side(first, last),
                        little = side(last, first);
  std::array<PalmField, 3> surface;
  PalmField sheets;
  sheets.fill(-1);
  for (int i = 0; i < kPalmCells; ++i) {
    const float s = (i % kPalmSide + 0.5f) / kPalmSide, t = (i / kPalmSide + 0.5f) / kPalmSide;
    const Eigen::Vector3f p =
        (1 - t) * ((1 - s) * wrist_thumb + s * wrist_little) + t * ((1 - s) * index + s * little);
    for (int axis = 0; axis < 3; ++axis) surface[axis][i] = p[axis];
  }
  for (const auto& hull : figure_hulls()) {
    if (hull[2] < 0) continue;
    const Eigen::Vector3f a = top(hull[0]), ab = top(hull[1]) - a, ac = top(hull[2]) - a;
    const float area = ab.x() * ac.y() - ab.y() * ac.x();
    if (area == 0) continue;
    for (int i = 0; i < kPalmCells; ++i) {
      const float x = surface[0][i] - a.x(), y = surface[1][i] - a.y(),
                  u = (x * ac.y() - y * ac.x()) / area, v = (y * ab.x() - x * ab.y()) / area;
      const float z = a.z() + u * ab.z() + v * ac.z();
      const bool above = (u >= 0) & (v >= 0) & (u + v <= 1) & (z > sheets[i]);
      sheets[i] = above ? z : sheets[i];
    }
  }
  for (int i = 0; i < kPalmCells; ++i)
    if (sheets[i] > -1) surface[2][i] = sheets[i];
  surface[2] = smoothed<3>(surface[2]);
  return surface;
}

}  // namespace handyar
