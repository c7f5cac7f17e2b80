// SPDX-License-Identifier: MIT
#include "handyar/render/marker_world.hpp"

#include <gtest/gtest.h>

#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "handyar/opencv/aruco.hpp"

namespace handyar::render {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

cv::Mat print_of(const SceneMarker& marker, int side_px) {
  cv::Mat image;
  const auto dictionary = cv::aruco::getPredefinedDictionary(*dictionary_number(marker.dictionary));
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
  cv::aruco::generateImageMarker(dictionary, marker.id, side_px, image);
#else
  cv::aruco::drawMarker(dictionary, marker.id, side_px, image);
#endif
  return image;
}

/// Draws a marker with its white margin as `camera` (without distortion) sees it.
void show(const SceneMarker& marker, const Isometry3d& T_camera_marker, const Camera& camera,
          cv::Mat& frame) {
  constexpr int kSide = 400, kMargin = 60;
  cv::Mat paper;
  cv::copyMakeBorder(print_of(marker, kSide), paper, kMargin, kMargin, kMargin, kMargin,
                     cv::BORDER_CONSTANT, 255);
  cv::cvtColor(paper, paper, cv::COLOR_GRAY2BGR);
  const double h = marker.size_m / 2;
  const Vector3d corners_m[] = {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
  // The outer edge of the black square lies half a pixel outside the centres of its outer pixels.
  const float a = kMargin - 0.5f, b = kMargin + kSide - 0.5f;
  const std::vector<cv::Point2f> from = {{a, a}, {b, a}, {b, b}, {a, b}};
  std::vector<cv::Point2f> to;
  for (const Vector3d& c : corners_m) {
    const Eigen::Vector2d px = camera.project(T_camera_marker * c);
    to.emplace_back(float(px.x()), float(px.y()));
  }
  const cv::Mat H = cv::getPerspectiveTransform(from, to);
  // Three times finer first: what a sensor's pixel sees is a mean.
  const cv::Mat finer = (cv::Mat_<double>(3, 3) << 3, 0, 1, 0, 3, 1, 0, 0, 1);
  cv::Mat large, cover(paper.size(), CV_8U, 255), large_cover;
  cv::warpPerspective(paper, large, finer * H, frame.size() * 3);
  cv::warpPerspective(cover, large_cover, finer * H, frame.size() * 3);
  cv::resize(large, large, frame.size(), 0, 0, cv::INTER_AREA);
  cv::resize(large_cover, large_cover, frame.size(), 0, 0, cv::INTER_AREA);
  large.copyTo(frame, large_cover > 127);
}

Isometry3d pose(double x_m, double y_m, double z_m, double tilt_x_rad, double tilt_y_rad) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Vector3d(x_m, y_m, z_m);
  // Upright and towards the camera, then tilted.
  T.linear() = (Eigen::AngleAxisd(tilt_x_rad, Vector3d::UnitX()) *
                Eigen::AngleAxisd(tilt_y_rad, Vector3d::UnitY()) *
                Eigen::AngleAxisd(M_PI, Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

void expect_near(const std::optional<Isometry3d>& T, const Isometry3d& truth, double mm,
                 double deg) {
  ASSERT_TRUE(T);
  EXPECT_LT((T->translation() - truth.translation()).norm() * 1000, mm);
  EXPECT_LT(Eigen::AngleAxisd(truth.linear().transpose() * T->linear()).angle() * 180 / M_PI, deg);
}

struct TwoMarkers : testing::Test {
  const Camera camera = Camera::from_field_of_view(640, 480);
  const SceneMarker aruco{"DICT_4X4_50", 7, 0.07, std::nullopt};
  const SceneMarker tag{"DICT_APRILTAG_36h11", 11, 0.06, std::nullopt};
  const Isometry3d at_left = pose(-0.09, 0.02, 0.5, 0.5, 0.3);
  const Isometry3d at_right = pose(0.08, -0.01, 0.55, 0.5, -0.4);

  cv::Mat frame(bool left, bool right) const {
    cv::Mat bgr(camera.height_px, camera.width_px, CV_8UC3, cv::Scalar(120, 130, 140));
    if (left) show(aruco, at_left, camera, bgr);
    if (right) show(tag, at_right, camera, bgr);
    return bgr;
  }
};

TEST_F(TwoMarkers, BothKindsOfPrintAreFoundInOneMarkerFrame) {
  MarkerWorld world({aruco, tag});
  world.observe(frame(true, true), camera, 0);
  expect_near(world.T_camera_marker(0), at_left, 3, 1.0);
  expect_near(world.T_camera_marker(1), at_right, 3, 1.0);
}

TEST_F(TwoMarkers, ACoveredMarkerKeepsItsPlaceByTheOther) {
  MarkerWorld world({aruco, tag});
  const cv::Mat both = frame(true, true), covered = frame(false, true);
  double t = 0;
  for (; t < 0.3; t += 1.0 / 30) world.observe(both, camera, t);
  for (; t < 5; t += 0.5) world.observe(covered, camera, t);
  expect_near(world.T_camera_marker(0), at_left, 5, 1.5);
}

TEST_F(TwoMarkers, WithoutAnyMarkerTheWorldStaysBriefly) {
  MarkerWorld world({aruco, tag});
  EXPECT_FALSE(world.T_camera_marker(0));
  world.observe(frame(true, false), camera, 0);
  EXPECT_FALSE(world.T_camera_marker(1));  // never seen
  world.observe(frame(false, false), camera, 1.0);
  expect_near(world.T_camera_marker(0), at_left, 3, 1.0);
  world.observe(frame(false, false), camera, 2.0);
  EXPECT_FALSE(world.T_camera_marker(0));
}

TEST_F(TwoMarkers, AWorldThatTheSceneGivesNeedsOnlyOneOfThem) {
  SceneMarker first = aruco, second = tag;
  first.T_world_marker = Isometry3d::Identity();
  second.T_world_marker = at_left.inverse() * at_right;
  MarkerWorld world({first, second});
  world.observe(frame(true, false), camera, 0);
  expect_near(world.T_camera_marker(-1), at_left, 3, 1.0);
  expect_near(world.T_camera_marker(1), at_right, 6, 1.0);
}

TEST_F(TwoMarkers, AMarkerThatWasMovedFindsItsNewPlace) {
  MarkerWorld world({aruco, tag});
  const Isometry3d moved = pose(0.05, 0.06, 0.5, 0.4, -0.4);
  const cv::Mat before = frame(true, true);
  cv::Mat after = frame(true, false);
  show(tag, moved, camera, after);
  for (int i = 0; i < 20; ++i) world.observe(i < 5 ? before : after, camera, i / 30.0);
  expect_near(world.T_camera_marker(0), at_left, 3, 1.0);
  expect_near(world.T_camera_marker(1), moved, 4, 1.5);
}

}  // namespace
}  // namespace handyar::render
