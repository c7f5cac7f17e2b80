// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "handyar/calibration/view.hpp"

namespace handyar::testing {

/// Random numbers of the running test: its own, the same in every run.
inline std::mt19937 test_random() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = std::string(info->test_suite_name()) + info->name();
  std::seed_seq seed(name.begin(), name.end());
  return std::mt19937(seed);
}

/// Exact views of a checkerboard with a hand at rest beside it: the camera circles over them.
struct Scene {
  Camera camera = {.fx_px = 618, .fy_px = 618, .cx_px = 322.4, .cy_px = 236.9};
  Board board{8, 6, 0.022};
  HandModel hand = average_adult_hand();
  double height_m = 0.011;  ///< of the hand frame's origin above the board
  double noise_px = 0;      ///< of fingertips and valleys
  double corner_noise_px = 0;
  double tilt_rad = 0.55;  ///< largest angle between view and board normal
  int views = 90;

  Eigen::Matrix<double, 3, kValleyCount> webs_m;  ///< in the hand frame
  bool webs_seen = true;

  Scene() {
    // Relief over the plane nearest to the tips, which is the hand plane.
    hand.tips_m.row(2) << 0.00045, -0.00137, 0.00093, 0.00059, -0.00061;
    webs_m << 0.042, 0.013, -0.013, -0.032,  //
        -0.010, 0.008, 0.006, -0.006,        //
        -0.004, -0.004, -0.004, -0.004;
  }

  /// The hand lies at the board's left, its fingers up (away from the person), back up.
  Eigen::Isometry3d T_board_hand() const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear().diagonal() << 1, -1, -1;
    T.linear() = Eigen::AngleAxisd(0.07, Eigen::Vector3d::UnitZ()) * T.linear();
    T.translation() << -0.15, 0.06, -height_m;
    return T;
  }

  Eigen::Isometry3d T_camera_board(int i) const {
    const double s = 2 * M_PI * i / views;
    const double tilt = tilt_rad * std::abs(std::sin(1.5 * s));
    const Eigen::Vector3d axis(std::cos(3 * s + 0.3), std::sin(3 * s + 0.3), 0);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = (Eigen::AngleAxisd(tilt, axis) *
                  Eigen::AngleAxisd(0.2 * std::sin(s), Eigen::Vector3d::UnitZ()))
                     .toRotationMatrix();
    const Eigen::Vector3d middle(0, 0.05, 0);  // between hand and board
    const Eigen::Vector3d at(0.03 * std::sin(2 * s), 0.03 * std::cos(s), 0.55 + 0.1 * std::sin(s));
    T.translation() = at - T.linear() * middle;
    return T;
  }

  CalibrationView view(int i, std::mt19937& random) const {
    std::normal_distribution<double> normal;
    const auto noisy = [&](const Eigen::Vector3d& p, double sigma) -> Eigen::Vector2d {
      return camera.project(p) + sigma * Eigen::Vector2d(normal(random), normal(random));
    };
    CalibrationView v;
    v.blur_px = 2.2;
    const Eigen::Isometry3d T = T_camera_board(i), T_camera_hand = T * T_board_hand();
    for (const cv::Point3f& c : board.corners_m()) {
      const Eigen::Vector2d px = noisy(T * Eigen::Vector3d(c.x, c.y, c.z), corner_noise_px);
      v.corners_px.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
    }
    for (int k = 0; k < kFingerCount; ++k)
      v.tips[k] = {noisy(T_camera_hand * hand.tips_m.col(k), noise_px), true};
    for (int k = 0; k < kValleyCount && webs_seen; ++k)
      v.webs[k] = {noisy(T_camera_hand * webs_m.col(k), noise_px), true};
    return v;
  }

  std::vector<CalibrationView> all() const {
    std::mt19937 random = test_random();
    std::vector<CalibrationView> out;
    for (int i = 0; i < views; ++i) out.push_back(view(i, random));
    return out;
  }
};

/// Root mean square distance of tips after the best rigid fit in the hand plane, in millimetres.
inline double tips_rms_mm(const HandModel& measured, const HandModel& truth) {
  const Eigen::Matrix<double, 2, kFingerCount> a =
      measured.tips_m.topRows<2>().colwise() - measured.tips_m.topRows<2>().rowwise().mean();
  const Eigen::Matrix<double, 2, kFingerCount> b =
      truth.tips_m.topRows<2>().colwise() - truth.tips_m.topRows<2>().rowwise().mean();
  double dot = 0, cross = 0;
  for (int k = 0; k < kFingerCount; ++k) {
    dot += a.col(k).dot(b.col(k));
    cross += a(0, k) * b(1, k) - a(1, k) * b(0, k);
  }
  const Eigen::Rotation2Dd turn(std::atan2(cross, dot));
  return 1000 * std::sqrt((turn.toRotationMatrix() * a - b).colwise().squaredNorm().mean());
}

/// What a function refuses with; empty when it does not.
template <class Error>
std::string refusal(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

}  // namespace handyar::testing
