// SPDX-License-Identifier: MIT
// A hand before the camera as a mask, and a cube that is drawn to it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "handyar/render/renderer.hpp"

namespace handyar::render {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

inline const cv::Vec3b kSkin(140, 160, 200), kRoom(90, 80, 60);

inline bool is_red(const cv::Vec3b& c) { return c[2] > 60 && c[2] > 2 * c[0] && c[2] > 2 * c[1]; }

/// A cube of side 1, so that positions in the test are those of its faces.
inline Model cube() {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (float side : {-1.0f, 1.0f}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      const Eigen::Vector3f n = side * Eigen::Vector3f::Unit(axis);
      const Eigen::Vector3f u = Eigen::Vector3f::Unit((axis + 1) % 3), v = n.cross(u);
      for (auto [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        mesh.vertices.push_back({0.5f * (n + float(a) * u + float(b) * v), n});
      for (std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + i);
    }
  return {{mesh}};
}

/// A hand upright before the camera, its visible face towards it, then tilted about its x axis.
inline Isometry3d hand_at(double distance_m, double tilt_rad = 0) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Vector3d(0, 0, distance_m);
  T.linear() =
      (Eigen::AngleAxisd(tilt_rad, Vector3d::UnitX()) * Eigen::AngleAxisd(M_PI, Vector3d::UnitX()))
          .toRotationMatrix();
  return T;
}

inline Isometry3d raised(const Isometry3d& T_camera_hand, const Vector3d& p_hand_m) {
  return T_camera_hand * Eigen::Translation3d(p_hand_m);
}

struct RendererTest : testing::Test {
  const Camera camera = Camera::from_field_of_view(640, 480);
  Renderer renderer;
  const int box = renderer.add(cube());
  cv::Mat mask_image = cv::Mat::zeros(480, 640, CV_8U);

  void hand_covers(const cv::Rect& where_px) { mask_image(where_px) = 255; }

  HandMask mask() const {
    return {mask_image.data,
            mask_image.cols,
            mask_image.rows,
            static_cast<std::ptrdiff_t>(mask_image.step),
            0,
            0,
            1};
  }
  cv::Mat frame() const {
    cv::Mat bgr(480, 640, CV_8UC3, cv::Scalar(kRoom));
    bgr.setTo(cv::Scalar(kSkin), mask_image);
    return bgr;
  }
  /// A red cube without a shadow, its foot at `T_camera_object`.
  Instance red(const Isometry3d& T_camera_object, double size_m = 0.06) const {
    Instance i;
    i.model = box;
    i.T_camera_object = T_camera_object;
    i.size_m = size_m;
    i.colour = {1, 0.05f, 0.05f};
    i.ground = Ground::none;
    return i;
  }
  cv::Mat drawn(const Instance& instance, const std::optional<Isometry3d>& T_camera_hand) {
    cv::Mat bgr = frame();
    renderer.draw(bgr, camera, {&instance, 1}, {mask(), T_camera_hand, 0.008});
    return bgr;
  }
  cv::Vec3b at(const cv::Mat& bgr, const Vector3d& p_camera_m) const {
    const Vector2d px = camera.project(p_camera_m);
    return bgr.at<cv::Vec3b>(cvRound(px.y()), cvRound(px.x()));
  }
};

}  // namespace handyar::render
