// SPDX-License-Identifier: MIT
// Hands whose poses are known because they were made, and what a tracker gives of them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "handyar/evaluation/truth.hpp"
#include "handyar/tracker.hpp"

namespace handyar::evaluation {

inline constexpr double kRadians = std::numbers::pi / 180;

inline Eigen::Isometry3d pose(const Eigen::Vector3d& rotation_rad,
                              const Eigen::Vector3d& translation_m) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (rotation_rad.norm() > 0)
    T.linear() =
        Eigen::AngleAxisd(rotation_rad.norm(), rotation_rad.normalized()).toRotationMatrix();
  T.translation() = translation_m;
  return T;
}

/// Seeded by the test's name.
inline std::mt19937 random_numbers() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = std::string(test->test_suite_name()) + test->name();
  std::seed_seq seed(name.begin(), name.end());
  return std::mt19937(seed);
}

inline Eigen::Vector3d normal3(std::mt19937& random, double sigma) {
  std::normal_distribution<double> n(0, sigma);
  const double x = n(random), y = n(random), z = n(random);
  return {x, y, z};
}

/// The hand 0.45 m before the camera, looking at it, at a (fractional) frame.
inline Eigen::Isometry3d hand_at(double frame) {
  const double t = frame / 30;
  return pose({std::numbers::pi, 0, 0}, {0, 0, 0.45}) *
         pose({0.4 * std::sin(2.2 * t), 0.3 * std::sin(3.1 * t), 0.2 * std::sin(1.3 * t)},
              {0.05 * std::sin(2.7 * t), 0.04 * std::sin(1.9 * t), 0.05 * std::sin(1.1 * t)});
}

inline Truth make_truth(int frames,
                        const std::function<Eigen::Isometry3d(double)>& hand = hand_at) {
  Truth t;
  t.hand = average_adult_hand();
  t.hand.source = HandSource::truth;
  t.hand_still_in_world = true;
  t.board = Board{8, 6, 0.02};
  t.T_world_board = pose({0, 0, 0.3}, {0.12, -0.03, 0});
  for (int i = 0; i < frames; ++i) {
    TruthFrame f;
    f.T_camera_hand = f.T_camera_world = hand(i);
    for (int k = 0; k < kFingerCount; ++k)
      f.tips_px[std::size_t(k)] = t.camera.project(f.T_camera_hand * t.hand.tips_m.col(k));
    f.all_tips_visible = true;
    t.frames.push_back(f);
  }
  return t;
}

/// A tracker that is always right.
inline std::vector<TrackResult> exact_track(const Truth& truth) {
  std::vector<TrackResult> track;
  for (const TruthFrame& f : truth.frames) {
    TrackResult r;
    r.time_s = double(track.size()) / truth.frames_per_second;
    r.state = State::tracking;
    r.layout = f.layout;
    for (std::size_t k = 0; k < kFingerCount; ++k) r.tips[k] = {f.tips_px[k], true};
    r.raw_pose.emplace().T_camera_hand = f.T_camera_hand;
    r.raw_pose->covariance.setIdentity();
    r.pose.emplace().T_camera_hand = f.T_camera_hand;
    r.pose->covariance.setIdentity();
    track.push_back(r);
  }
  return track;
}

}  // namespace handyar::evaluation
