// SPDX-License-Identifier: MIT
#include "region.hpp"

#include <array>
#include <optional>

#include "handyar/opencv/lens.hpp"

namespace handyar::render {

cv::Rect region_of(const Camera& camera, std::span<const Instance> instances,
                   const std::vector<GpuModel>& models) {
  constexpr std::array kShares{0.0, 0.25, 0.5, 0.75, 1.0};  // of an edge: distortion bends it
  Eigen::AlignedBox2d all;
  for (const Instance& instance : instances) {
    if (instance.opacity <= 0) continue;
    Eigen::AlignedBox3f box = models[instance.model].box;
    if (instance.ground != Ground::none) {
      box.extend(Eigen::Vector3f(-1, -1, 0));
      box.extend(Eigen::Vector3f(1, 1, 0));
    }
    const Eigen::Vector3d low = box.min().cast<double>(), sizes = box.sizes().cast<double>();
    for (const double x : kShares)
      for (const double y : kShares)
        for (const double z : kShares) {
          const Eigen::Vector3d p_object =
              instance.size_m * (low + Eigen::Vector3d(x, y, z).cwiseProduct(sizes));
          const Eigen::Vector3d p = instance.T_camera_object * p_object;
          const auto px = p.z() < 0.01 ? std::nullopt : shown_at(camera, p);
          if (!px) return {0, 0, camera.width_px, camera.height_px};
          all.extend(*px);
        }
  }
  if (all.isEmpty()) return {};
  constexpr double kFar = 1e4;  // keeps the corners within what an int holds
  const Eigen::Vector2d low = all.min().array().max(-kFar).min(kFar).floor() - 2;
  const Eigen::Vector2d high = all.max().array().max(-kFar).min(kFar).ceil() + 3;
  const cv::Rect region(cv::Point(int(low.x()), int(low.y())),
                        cv::Point(int(high.x()), int(high.y())));
  return region & cv::Rect(0, 0, camera.width_px, camera.height_px);
}

}  // namespace handyar::render
