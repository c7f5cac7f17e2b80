// SPDX-License-Identifier: MIT
#include "handyar/calibration/view.hpp"

#include <cmath>
#include <limits>

namespace handyar {
double difference(const Viewpoint& a, const Viewpoint& b) {
  const double place = (a.centre - b.centre).norm() / 0.33;
  const double direction = (a.normal - b.normal).norm() / 0.35;
  const double distance = std::log(a.distance_m / b.distance_m) / 0.3;
  return std::sqrt(place * place + direction * direction + distance * distance);
}

Viewpoint viewpoint(const Eigen::Isometry3d& T_camera_object, const Eigen::Vector3d& centre_m,
                    const Eigen::Vector3d& normal_object, const Camera& camera) {
  const Eigen::Vector3d c = T_camera_object * centre_m;
  const Eigen::Vector2d px = camera.project(c);
  return {{px.x() / camera.width_px, px.y() / camera.height_px},
          T_camera_object.linear() * normal_object,
          c.norm()};
}

double directions_span_rad(std::span<const Viewpoint> viewpoints) {
  double least = 1;
  for (std::size_t i = 0; i < viewpoints.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, viewpoints[i].normal.dot(viewpoints[j].normal));
  return std::acos(std::clamp(least, -1.0, 1.0));
}

std::vector<int> choose_diverse(std::span<const Viewpoint> viewpoints, int count) {
  constexpr double kSameView = 0.05;
  std::vector<int> chosen;
  const int n = static_cast<int>(viewpoints.size());
  if (n == 0) return chosen;
  std::vector<double> nearest(n, std::numeric_limits<double>::infinity());
  int next = 0;
  while (static_cast<int>(chosen.size()) < count) {
    chosen.push_back(next);
    for (int i = 0; i < n; ++i)
      nearest[i] = std::min(nearest[i], difference(viewpoints[i], viewpoints[next]));
    next = static_cast<int>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
    if (nearest[next] < kSameView) break;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace handyar
