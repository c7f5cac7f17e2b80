// SPDX-License-Identifier: MIT
// A tabletop that the test draws itself: a printed table, a box that stands on it, a flat grey hand
// that lies on it at first. So the truth of every frame is known.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "handyar/opencv/types.hpp"
#include "handyar/world/world_tracker.hpp"

namespace handyar::world {

inline constexpr double kFrame_s = 1 / 30.0;
inline constexpr double kTexel_m = 0.0008;

/// Random numbers of the running test, others for each `stream`.
inline cv::RNG random_numbers(std::string_view stream) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = test->name() + std::string(stream);
  std::seed_seq seed(name.begin(), name.end());
  std::array<std::uint32_t, 2> numbers;
  seed.generate(numbers.begin(), numbers.end());
  return cv::RNG(std::uint64_t{numbers[0]} << 32 | numbers[1]);
}

/// A print of random rectangles, of many sizes and greys.
inline cv::Mat print(int size, cv::RNG random) {
  cv::Mat texture(size, size, CV_8UC3, cv::Scalar(128, 128, 128));
  for (int i = 0; i < size * size / 600; ++i) {
    const double shade = random.uniform(40, 216);
    const cv::Rect rectangle(random.uniform(-20, size), random.uniform(-20, size),
                             random.uniform(4, 40), random.uniform(4, 40));
    cv::rectangle(texture, rectangle, {shade, shade * 0.95, shade * 0.9}, cv::FILLED);
  }
  cv::GaussianBlur(texture, texture, {3, 3}, 0.8);
  return texture;
}

/// A bare table with a keyboard on its left, whose keys look almost the same, and a print behind
/// it.
inline cv::Mat keyboard_and_print(int size, cv::RNG random) {
  cv::Mat texture(size, size, CV_8UC3, cv::Scalar(128, 128, 128));
  constexpr int kKey_px = 20, kPitch_px = 24;
  for (int row = 0; row < 14; ++row)
    for (int column = 0; column < 5; ++column) {
      const cv::Rect key(size / 2 - 280 + kPitch_px * column, size / 2 - 250 + kPitch_px * row,
                         kKey_px, kKey_px);
      cv::rectangle(texture, key, {200, 190, 60}, cv::FILLED);
      const cv::Rect letter(key.x + 5, key.y + 5, random.uniform(2, 8), random.uniform(2, 8));
      cv::rectangle(texture, letter, {150, 140, 50}, cv::FILLED);
    }
  print(150, random).copyTo(texture({size / 2 - 40, size / 2 - 420, 150, 150}));
  cv::GaussianBlur(texture, texture, {3, 3}, 0.8);
  return texture;
}

/// A square in the world: `texture` from its corner along two sides.
struct Board {
  cv::Mat texture;
  Eigen::Vector3d corner_m, along_m, down_m;
};

class Tabletop {
 public:
  explicit Tabletop(const std::string& name = "table", decltype(print)& surface = print)
      : camera(Camera::from_field_of_view(640, 480)), random_(random_numbers(name + " noise")) {
    const cv::Mat table = surface(1500, random_numbers(name));
    const double side_m = kTexel_m * table.cols;
    boards_.push_back(
        {table, {-side_m / 2, side_m / 2, -kThickness_m}, {side_m, 0, 0}, {0, -side_m, 0}});
    const cv::Mat side = print(150, random_numbers(name + " box"));
    const Eigen::Vector3d foot(0.1, 0.1, -kThickness_m);
    const double box_m = 0.07;
    boards_.push_back({side, foot + Eigen::Vector3d(0, 0, box_m), {box_m, 0, 0}, {0, 0, -box_m}});
    boards_.push_back(
        {side, foot + Eigen::Vector3d(0, box_m, box_m), {box_m, 0, 0}, {0, -box_m, 0}});
  }

  /// The picture from a pose; with a hand, a grey ellipse with its mask.
  cv::Mat draw(const Eigen::Isometry3d& T_camera_world, bool hand) {
    cv::Mat bgr(camera.height_px, camera.width_px, CV_8UC3, cv::Scalar(90, 80, 70));
    for (const Board& board : boards_) lay(board, T_camera_world, bgr);
    mask_ = cv::Mat::zeros(bgr.size(), CV_8U);
    if (hand) {
      std::vector<cv::Point> outline;
      for (int i = 0; i < 40; ++i) {
        const double a = 2 * std::numbers::pi * i / 40;
        const Eigen::Vector2d px = camera.project(
            T_camera_world * Eigen::Vector3d(0.05 * std::cos(a), 0.09 * std::sin(a), 0));
        outline.emplace_back(static_cast<int>(px.x()), static_cast<int>(px.y()));
      }
      cv::fillConvexPoly(mask_, outline, 255);
      bgr.setTo(cv::Scalar(120, 150, 200), mask_);
    }
    for (int y = 0; y < bgr.rows; ++y)
      for (int x = 0; x < 3 * bgr.cols; ++x) {
        auto& value = bgr.ptr<std::uint8_t>(y)[x];
        value = cv::saturate_cast<std::uint8_t>(value + random_.gaussian(1.5));
      }
    return bgr;
  }

  HandInWorld hand(const std::optional<Eigen::Isometry3d>& T_camera_hand) const {
    HandInWorld hand;
    if (!T_camera_hand) return hand;
    hand.mask = {mask_.data, mask_.cols, mask_.rows, mask_.cols, 0, 0, 1};
    hand.T_camera_hand = T_camera_hand;
    hand.thickness_m = kThickness_m;
    return hand;
  }

  static constexpr double kThickness_m = 0.006;
  Camera camera;

 private:
  void lay(const Board& board, const Eigen::Isometry3d& T, cv::Mat& bgr) const {
    const Eigen::Vector3d corner = T * board.corner_m;
    Eigen::Matrix3d plane;
    plane << T.linear() * board.along_m / board.texture.cols,
        T.linear() * board.down_m / board.texture.rows, corner;
    // Seen from behind it is hidden.
    if (plane.col(0).cross(plane.col(1)).dot(corner) < 0) return;
    cv::Matx33d H;
    cv::Mat H_mat(3, 3, CV_64F, H.val);
    cv::eigen2cv(plane, H_mat);
    H = camera_matrix(camera) * H;
    cv::warpPerspective(board.texture, bgr, H, bgr.size(), cv::INTER_LINEAR,
                        cv::BORDER_TRANSPARENT);
  }

  std::vector<Board> boards_;
  cv::Mat mask_;
  cv::RNG random_;  // for the noise
};

/// A camera round the table: turned by `azimuth`, `tilt` from straight above.
inline Eigen::Isometry3d from(double azimuth_rad, double tilt_rad, double distance_m,
                              double look_away_rad = 0) {
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(azimuth_rad, Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX()))
                                   .toRotationMatrix();
  Eigen::Matrix3d R_world_camera = turn * Eigen::Vector3d(1, -1, -1).asDiagonal();
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.translation() = distance_m * turn.col(2);
  T_world_camera.linear() =
      R_world_camera * Eigen::AngleAxisd(look_away_rad, Eigen::Vector3d::UnitX());
  return T_world_camera.inverse();
}

struct Errors {
  double rotation_rad, distance_m;
};
inline Errors errors(const Eigen::Isometry3d& T_camera_world, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d off = T_camera_world.inverse() * truth;
  return {Eigen::AngleAxisd(off.linear()).angle(), off.translation().norm()};
}

inline constexpr double kDegree = std::numbers::pi / 180;

/// The orbit of a test: still with the hand, then round the table, away, and back.
inline Eigen::Isometry3d orbit(int frame) {
  const double s = std::max(0, frame - 30) / 150.0;
  const double away = frame >= 140 && frame < 165 ? -80 * kDegree : 0;
  return from(0.9 * std::sin(4 * s), 0.5 + 0.25 * std::sin(7 * s), 0.5 + 0.1 * std::sin(5 * s),
              away);
}
inline constexpr int kFrames = 200, kHandUntil = 30, kAway = 140, kBack = 165;

/// What is mapped of a table on the way out.
inline WorldMap made_map(Tabletop& table) {
  WorldTracker tracker(table.camera);
  for (int frame = 0; frame < 100; ++frame) {
    const Eigen::Isometry3d truth = orbit(frame);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    tracker.process(bgr, frame * kFrame_s,
                    table.hand(with_hand ? std::optional(truth) : std::nullopt));
  }
  return *tracker.map();
}

}  // namespace handyar::world
