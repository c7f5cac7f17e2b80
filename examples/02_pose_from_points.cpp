// SPDX-License-Identifier: MIT
// The pose from fingertips alone, as the paper has it: fingertips from anywhere, here projected from a known pose and disturbed,
// give T_camera_hand with a covariance. Compares what it states with what it is.
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "handyar/paper/tip_pose.hpp"

int main() {
  const auto camera = handyar::Camera::from_field_of_view(640, 480);
  const handyar::HandModel hand = handyar::average_adult_hand();

  // The hand 0.45 m before the camera, fingers up, tilted by 40 degrees.
  Eigen::Isometry3d T_camera_hand = Eigen::Isometry3d::Identity();
  T_camera_hand.translation() << 0.02, 0.03, 0.45;
  T_camera_hand.rotate(
      Eigen::AngleAxisd(std::numbers::pi * (1 + 40 / 180.0), Eigen::Vector3d::UnitX()));

  const double sigma_px = 0.5;
  std::mt19937 generator(1);
  std::normal_distribution<double> noise_px(0.0, sigma_px);
  handyar::paper::SeenTips tips;
  for (int finger = 0; finger < handyar::kFingerCount; ++finger) {
    const Eigen::Vector3d tip_camera_m = T_camera_hand * hand.tips_m.col(finger);
    const Eigen::Vector2d noise(noise_px(generator), noise_px(generator));
    tips[finger] = camera.project(tip_camera_m) + noise;
  }

  const auto estimate = handyar::paper::pose_from_tips(tips, hand, camera, sigma_px);
  if (!estimate) return 1;

  const double to_deg = 180 / std::numbers::pi;
  const Eigen::Isometry3d error = estimate->T_camera_hand * T_camera_hand.inverse();
  const Eigen::Vector3d offset_m =
      estimate->T_camera_hand.translation() - T_camera_hand.translation();
  std::printf("stated: %.2f deg, %.2f mm\n",
              to_deg * handyar::sigma_rotation_rad(estimate->covariance),
              1000 * handyar::sigma_translation_m(estimate->covariance));
  std::printf("actual: %.2f deg, %.2f mm\n",
              to_deg * Eigen::AngleAxisd(error.linear()).angle() / std::sqrt(3),
              1000 * offset_m.norm() / std::sqrt(3));
}
