// SPDX-License-Identifier: MIT
#include "handyar/render/renderer.hpp"

#include "handyar/render/window.hpp"
#include "rendered_scene.hpp"

namespace handyar::render {
namespace {

TEST_F(RendererTest, InFrontOfTheHandTheObjectIsSeen) {
  hand_covers({220, 140, 200, 300});
  const Isometry3d T = hand_at(0.45);
  const cv::Mat out = drawn(red(T), T);
  EXPECT_TRUE(is_red(at(out, T * Vector3d(0, 0, 0.06))));
  EXPECT_TRUE(is_red(at(out, T * Vector3d(0.025, 0.025, 0.06))));
  EXPECT_EQ(at(out, T * Vector3d(0.05, 0, 0)), kSkin);
  EXPECT_EQ(out.at<cv::Vec3b>(10, 10), kRoom);
}

TEST_F(RendererTest, BehindTheHandItIsNot) {
  hand_covers({220, 140, 200, 300});
  const Isometry3d T = hand_at(0.45);
  const cv::Mat out = drawn(red(raised(T, {0, 0, -0.12})), T);
  cv::Mat difference;
  cv::absdiff(out, frame(), difference);
  EXPECT_EQ(cv::countNonZero(difference.reshape(1)), 0);
}

TEST_F(RendererTest, HalfBehindTheHandItIsSeenBesideIt) {
  hand_covers({120, 60, 200, 360});  // left of the picture's middle, up to column 319
  const Isometry3d T = hand_at(0.45);
  const cv::Mat out = drawn(red(raised(T, {0, 0, -0.12})), T);
  const int row = 240;
  EXPECT_EQ(out.at<cv::Vec3b>(row, 310), kSkin);
  EXPECT_TRUE(is_red(out.at<cv::Vec3b>(row, 330)));
  // A soft edge of a few pixels, without a rim of the room between hand and object.
  int between = 0;
  for (int x = 310; x < 330; ++x) {
    const cv::Vec3b c = out.at<cv::Vec3b>(row, x);
    between += c != kSkin && !is_red(c);
    EXPECT_GT(c[2], 100) << "column " << x;  // hand and object are red, the room is not
  }
  EXPECT_LE(between, 4);
}

TEST_F(RendererTest, APartBelowTheHandIsHiddenAndAPartAboveIsSeen) {
  hand_covers({0, 0, 640, 480});
  const Isometry3d T = hand_at(0.45, 1.1);  // looked at from 27 degrees above its plane
  const cv::Mat out = drawn(red(raised(T, {0, 0, -0.05}), 0.1), T);
  const double near_face = T.linear()(2, 1) > 0 ? -0.05 : 0.05;
  EXPECT_TRUE(is_red(at(out, T * Vector3d(0, near_face, 0.03))));
  EXPECT_EQ(at(out, T * Vector3d(0, near_face, -0.03)), kSkin);
}

TEST_F(RendererTest, WhatLiesFlatOnTheHandIsSeen) {
  hand_covers({0, 0, 640, 480});
  Model card = cube();
  for (Vertex& v : card.meshes[0].vertices) v.position.z() *= 0.001f;  // at 6 cm: 0.06 mm thick
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T);
  const cv::Vec3b full = at(drawn(red(raised(T, {0, 0, 0.01})), T), T * Vector3d(0, 0, 0.04));
  instance.model = renderer.add(card);
  const cv::Vec3b seen = at(drawn(instance, T), T * Vector3d::Zero());
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], full[c], 10);
}

TEST_F(RendererTest, NothingShinesThroughAHandSeenFromBehind) {
  hand_covers({220, 140, 200, 300});
  Isometry3d T = hand_at(0.45);
  T.linear() *= Eigen::AngleAxisd(M_PI, Vector3d::UnitY()).toRotationMatrix();
  const cv::Mat out = drawn(red(T, 0.05), T);  // stands on the face turned away
  EXPECT_EQ(at(out, T * Vector3d::Zero()), kSkin);
}

TEST_F(RendererTest, WithoutAPoseTheHandIsNearerThanEverything) {
  hand_covers({120, 60, 200, 360});
  const cv::Mat out = drawn(red(hand_at(0.3)), std::nullopt);
  EXPECT_EQ(out.at<cv::Vec3b>(240, 300), kSkin);
  EXPECT_TRUE(is_red(out.at<cv::Vec3b>(240, 340)));
}

TEST_F(RendererTest, AHalfSizeMaskWithAnOffsetHidesTheSame) {
  hand_covers({120, 60, 200, 360});
  const cv::Mat expected = drawn(red(hand_at(0.3)), std::nullopt);
  cv::Mat half;
  cv::resize(mask_image(cv::Rect(100, 40, 300, 400)), half, {150, 200}, 0, 0, cv::INTER_NEAREST);
  cv::Mat out = frame();
  const Instance instance = red(hand_at(0.3));
  renderer.draw(
      out, camera, {&instance, 1},
      {{half.data, half.cols, half.rows, static_cast<std::ptrdiff_t>(half.step), 100, 40, 2},
       std::nullopt,
       0.008});
  for (int x : {250, 312, 330, 350})
    EXPECT_LT(cv::norm(out.at<cv::Vec3b>(240, x), expected.at<cv::Vec3b>(240, x)), 8) << x;
}

TEST_F(RendererTest, FollowsTheDistortionOfTheCamera) {
  Camera bent = camera;
  bent.distortion = {-0.28, 0.09, 0.002, -0.001, 0.0};
  for (const Vector3d& p : {Vector3d(0.2, 0.14, 0.5), Vector3d(-0.22, 0.1, 0.5),
                            Vector3d(0.0, -0.17, 0.5), Vector3d(0.05, 0.02, 0.5)}) {
    Isometry3d T = hand_at(0.5);
    T.translation() = p;
    const Instance dot = red(raised(T, {0, 0, -0.002}), 0.004);
    cv::Mat bgr = frame(), gray;
    renderer.draw(bgr, bent, {&dot, 1});
    cv::absdiff(bgr, frame(), bgr);
    cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
    const cv::Moments m = cv::moments(gray);
    ASSERT_GT(m.m00, 0);
    const Vector2d px = bent.project(p);
    EXPECT_NEAR(m.m10 / m.m00, px.x(), 0.4);
    EXPECT_NEAR(m.m01 / m.m00, px.y(), 0.4);
    EXPECT_GT((px - camera.project(p)).norm(), p.head<2>().norm() > 0.1 ? 5 : 0);
  }
}

/// A strip across, of many pieces: its longest side is 1.
Model strip() {
  constexpr int kPieces = 32;
  Mesh mesh;
  for (int i = 0; i <= kPieces; ++i)
    for (const float z : {0.0f, 0.02f})
      mesh.vertices.push_back({{float(i) / kPieces - 0.5f, 0, z}, Eigen::Vector3f::UnitY()});
  for (std::uint32_t i = 0; i < 2 * kPieces; i += 2)
    for (const std::uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) mesh.indices.push_back(i + corner);
  return {{mesh}};
}

TEST_F(RendererTest, StrongDistortionCutsNothingOff) {
  Camera bent = camera;
  bent.distortion[0] = -0.3;
  Isometry3d T = Isometry3d::Identity();  // the strip's height is up in the picture
  T.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix();
  const auto shows = [&](const Vector3d& foot, double length_m, const Vector3d& p) {
    T.translation() = foot;
    Instance instance = red(T, length_m);
    instance.model = renderer.add(strip());
    cv::Mat bgr = frame();
    renderer.draw(bgr, bent, {&instance, 1});
    const Vector2d px = bent.project(p);
    return is_red(bgr.at<cv::Vec3b>(cvRound(px.y()), cvRound(px.x())));
  };
  // It bends outwards between its ends.
  EXPECT_TRUE(shows({0, -0.3, 1}, 1.1, {0, -0.303, 1}));
  // Its end is so far to the side that the distortion brings it back.
  EXPECT_TRUE(shows({0.85, 0, 1}, 1.3, {0.64, -0.012, 1}));
}

TEST_F(RendererTest, AModelThatMovesIsWhereItsTimeHasIt) {
  Model moving = cube();  // to its right by three of its sides and back, in two seconds
  Mesh& mesh = moving.meshes[0];
  for (const float right : {0.0f, 3.0f}) {
    Mesh::Moment& moment = mesh.moments.emplace_back();
    for (const Vertex& v : mesh.vertices) {
      moment.positions.push_back(v.position + right * Eigen::Vector3f::UnitX());
      moment.normals.push_back(v.normal);
    }
  }
  moving.period_s = 2;
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T, 0.12);
  instance.model = renderer.add(moving);
  for (const auto& [time_s, x_m] :
       {std::pair{0.0, -0.045}, {0.5, 0.0}, {1.0, 0.045}, {4.0, -0.045}}) {
    instance.time_s = time_s;
    const cv::Mat out = drawn(instance, T);
    for (const double other_m : {-0.045, 0.0, 0.045})
      EXPECT_EQ(is_red(at(out, T * Vector3d(other_m, 0, 0.03))), other_m == x_m) << time_s;
  }
}

TEST_F(RendererTest, OpacityIsACrossFade) {
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T);
  const Vector3d middle = T * Vector3d(0, 0, 0.06);
  const cv::Vec3b full = at(drawn(instance, T), middle);
  instance.opacity = 0.5f;
  const cv::Vec3b half = at(drawn(instance, T), middle);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(half[c], (full[c] + kRoom[c]) / 2.0, 2);
  instance.opacity = 0;
  EXPECT_EQ(at(drawn(instance, T), middle), kRoom);
}

TEST_F(RendererTest, TheShadowFallsOnTheHandAndNowhereElse) {
  hand_covers({220, 140, 200, 130});  // down to row 269
  const Isometry3d T = hand_at(0.45);
  Instance instance = red(T, 0.03);
  instance.ground = Ground::hand;
  const cv::Mat out = drawn(instance, T);
  // The lamp is above the camera, so it falls below the cube's foot, which ends at row 258.
  EXPECT_LT(out.at<cv::Vec3b>(264, 330)[1], kSkin[1] - 12);
  for (int y = 274; y < 300; ++y) EXPECT_EQ(out.at<cv::Vec3b>(y, 330), kRoom) << y;
}

TEST_F(RendererTest, ADarkRoomMakesADarkObject) {
  const Isometry3d T = hand_at(0.45);
  const Instance instance = red(T);
  double seen[2];
  for (int dark : {0, 1}) {
    Renderer fresh;
    fresh.add(cube());
    cv::Mat bgr(480, 640, CV_8UC3, dark ? cv::Scalar(40, 40, 40) : cv::Scalar(170, 170, 170));
    fresh.draw(bgr, camera, {&instance, 1});
    seen[dark] = at(bgr, T * Vector3d(0, 0, 0.06))[2];
  }
  EXPECT_GT(seen[0], 1.4 * seen[1]);
}

TEST_F(RendererTest, ARendererThatTakesAnothersPlaceDrawsAsThatOneDid) {
  const Instance instance = red(hand_at(0.45));
  Renderer other;
  other.add(cube());
  cv::Mat bgr = frame();
  other.draw(bgr, camera, {&instance, 1});  // in a context of its own
  const cv::Mat expected = drawn(instance, std::nullopt);
  cv::Mat large(600, 800, CV_8UC3, cv::Scalar(kRoom));
  renderer.draw(large, camera, {&instance, 1});  // what is of a frame's size is made anew after it
  other = std::move(renderer);
  bgr = frame();
  other.draw(bgr, camera, {&instance, 1});
  EXPECT_EQ(cv::norm(bgr, expected, cv::NORM_INF), 0);
}

TEST_F(RendererTest, WhatIsOutOfViewOrBehindTheCameraIsHarmless) {
  for (const Vector3d& p :
       {Vector3d(5, 0, 0.5), Vector3d(0, 0, -0.5), Vector3d(0, 0, 0.01), Vector3d(0, 0, 1e7)}) {
    Isometry3d T = hand_at(0.5);
    T.translation() = p;
    EXPECT_NO_THROW(drawn(red(T), T));
  }
}

TEST_F(RendererTest, WhatReachesPastTheCameraIsCutOffThere) {
  // A wall beside the camera, from 1 m before it to 1 m behind it, in one piece: it fills the
  // picture's right side up to where its far end is.
  Model wall;
  Mesh& mesh = wall.meshes.emplace_back();
  for (const float z : {-0.5f, 0.5f})
    for (const float y : {-0.5f, 0.5f})
      mesh.vertices.push_back({{0, y, z}, -Eigen::Vector3f::UnitX()});
  mesh.indices = {0, 1, 2, 2, 1, 3};
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Vector3d(0.2, 0, -1);
  Instance instance = red(T, 2);
  instance.model = renderer.add(wall);
  Camera bent = camera;
  bent.distortion = {-0.28, 0.09, 0, 0, 0};
  for (const Camera& seen_by : {camera, bent}) {
    cv::Mat out = frame();
    renderer.draw(out, seen_by, {&instance, 1});
    const double far_end_px = seen_by.project({0.2, 1, 1}).x();
    for (int y = 0; y < out.rows; y += 20)
      for (int x = 0; x < out.cols; ++x) {
        if (std::abs(x - far_end_px) < 1) continue;
        ASSERT_EQ(out.at<cv::Vec3b>(y, x) != kRoom, x > far_end_px) << x << ", " << y;
      }
  }
}

TEST(WindowTest, FitsTheScreenAndKeepsTheAspect) {
  EXPECT_EQ(window_size({640, 480}, {1280, 800}), cv::Size(640, 480));
  EXPECT_EQ(window_size({4096, 2160}, {1280, 800}), cv::Size(1280, 675));
  EXPECT_EQ(window_size({480, 852}, {1280, 800}), cv::Size(450, 800));
  EXPECT_EQ(window_size({640, 480}, {}), cv::Size(640, 480)) << "the screen's size is not known";
}

}  // namespace
}  // namespace handyar::render
