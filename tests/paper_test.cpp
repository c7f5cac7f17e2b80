// SPDX-License-Identifier: MIT
// The method of 2007, stage by stage and as a whole.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "hand_film.hpp"
#include "handyar/paper/tip_pose.hpp"
#include "handyar/paper/tracker.hpp"
#include "paper/fingertips.hpp"
#include "paper/hand_region.hpp"
#include "paper/matching.hpp"
#include "paper/skin_model.hpp"

namespace handyar::paper {
namespace {

using test::deg;
using test::Film;

TEST(SkinModel, ThePriorTellsSkinFromBlueAndGreen) {
  const SkinModel skin(5);
  for (const auto& rgb : {std::array{205, 150, 120}, {230, 180, 150}, {150, 95, 70}, {120, 80, 60}})
    EXPECT_GT(skin.log_ratio(bin_of_rgb(rgb[0], rgb[1], rgb[2])), 0) << rgb[0];
  for (const auto& rgb : {std::array{40, 60, 200}, {30, 160, 40}, {120, 140, 150}})
    EXPECT_LT(skin.log_ratio(bin_of_rgb(rgb[0], rgb[1], rgb[2])), 0) << rgb[0];
}

TEST(SkinModel, LearnsAVerifiedHandAndForgetsItOnReset) {
  SkinModel skin(5);
  const ColorBin glove = bin_of_rgb(40, 60, 200), wall = bin_of_rgb(205, 150, 120);
  const float before = skin.log_ratio(glove);
  const std::vector<ColorBin> hand(2000, glove), background(2000, wall);
  for (int i = 0; i < 8; ++i) skin.learn(hand, background);
  EXPECT_GT(skin.log_ratio(glove), 1);
  EXPECT_LT(skin.log_ratio(wall), -1);
  skin.reset();
  EXPECT_EQ(skin.log_ratio(glove), before);
}

TEST(HandRegion, IsTheLargestRegionAndItsPalmTheLargestDisc) {
  Film film;
  film.T_camera_hand = film.pose_at(0);
  film.extra = [](test::Picture& p) {
    p.paint([](const Eigen::Vector2d& px) { return (px - Eigen::Vector2d(60, 60)).norm() - 20; },
            1);
  };
  const test::Picture picture = film.picture();
  HandRegion region;
  region.resize(640, 480, 1);
  ASSERT_TRUE(region.find(picture.view(), SkinModel(5)));
  EXPECT_FALSE(region.mask().at(60, 60)) << "the smaller region";
  const Eigen::Vector2d palm =
      film.camera.project(film.T_camera_hand * Eigen::Vector3d(0, -0.035, 0));
  EXPECT_LT((region.palm().cast<double>() - palm).norm(), 30);
  EXPECT_GT(region.palm_radius(), 25);
  EXPECT_FALSE(region.find(test::Picture(640, 480).view(), SkinModel(5)));
}

class FingertipsBy : public testing::TestWithParam<FingertipMethod> {};

TEST_P(FingertipsBy, AreTheFiveOfTheHandInOrder) {
  Film film;
  Config config;
  config.fingertips = GetParam();
  HandRegion region;
  region.resize(640, 480, 1);
  FingertipFinder finder(config);
  finder.reserve(4 * (640 + 480));
  double sum_px = 0;
  constexpr int kFrames = 10;
  for (int i = 0; i < kFrames; ++i) {
    film.T_camera_hand = film.pose_at(0.3 * i);
    ++film.frame;
    const test::Picture picture = film.picture();
    ASSERT_TRUE(region.find(picture.view(), SkinModel(5)));
    const auto ordered = order_tips(finder.find(region), region.palm());
    ASSERT_TRUE(ordered) << i;
    EXPECT_EQ(ordered->layout, Layout::thumb_right);
    for (int f = 0; f < kFingerCount; ++f)
      sum_px += (ordered->at[f].cast<double>() - film.true_tip_px(f)).norm();
  }
  // A fingertip is the end of the figure's finger, which the outline passes at some pixels.
  EXPECT_LT(sum_px / (kFrames * kFingerCount), 6);
}
INSTANTIATE_TEST_SUITE_P(Methods, FingertipsBy,
                         testing::Values(FingertipMethod::curvature, FingertipMethod::ellipse),
                         [](const auto& m) {
                           return m.param == FingertipMethod::ellipse ? "Ellipse" : "Curvature";
                         });

/// Tips in a row, as a contour gives them.
std::vector<Fingertip> as_found(const OrderedTips& tips) {
  std::vector<Fingertip> found;
  for (const Eigen::Vector2f& at : tips.at) found.push_back({at, int(found.size()), 0.9f});
  return found;
}

const OrderedTips kTips{{{{60, 120}, {100, 40}, {150, 20}, {200, 40}, {260, 90}}},
                        Layout::thumb_left};  // clockwise

TEST(Matching, FollowsTheOrderAlongTheContourWhereverItBegins) {
  for (int first = 0; first < kFingerCount; ++first) {
    auto found = as_found(kTips);
    for (Fingertip& tip : found) tip.at += Eigen::Vector2f(9, -6);
    std::rotate(found.begin(), found.begin() + first, found.end());
    const TipAssignment to = match_tips(kTips, found, 60);
    for (int f = 0; f < kFingerCount; ++f)
      EXPECT_EQ(to[f], (f - first + kFingerCount) % kFingerCount) << first;
  }
}

TEST(Matching, AMissingTipIsMissingAndAnExtraOneIsLeftOut) {
  auto found = as_found(kTips);
  found.erase(found.begin() + 2);
  EXPECT_EQ(match_tips(kTips, found, 30), (TipAssignment{0, 1, -1, 2, 3}));
  found = as_found(kTips);
  found.insert(found.begin() + 2, {{175, 90}, 1, 0.9f});
  EXPECT_EQ(match_tips(kTips, found, 30), (TipAssignment{0, 1, 3, 4, 5}));
  for (Fingertip& tip : found) tip.at += Eigen::Vector2f(0, 300);
  EXPECT_EQ(match_tips(kTips, found, 30), (TipAssignment{-1, -1, -1, -1, -1}));
}

SeenTips project(const HandModel& hand, const Camera& camera, const Eigen::Isometry3d& T) {
  SeenTips tips;
  for (int f = 0; f < kFingerCount; ++f) tips[f] = camera.project(T * hand.tips_m.col(f).eval());
  return tips;
}

TEST(TipPose, IsExactWithoutNoiseFromFiveOrFour) {
  Camera camera = test::rendered_camera();
  camera.distortion = {-0.21, 0.09, 0.0012, -0.0007, -0.01};
  for (const Layout layout : {Layout::thumb_right, Layout::thumb_left})
    for (const double tilt : {10.0, 30.0, 60.0})
      for (double axis = 0; axis < 360; axis += 45)
        for (int missing = -1; missing < kFingerCount; missing += 3) {
          const HandModel hand = test::rendered_hand().for_layout(layout);
          const Eigen::Isometry3d truth = test::hand_at(0.45, deg(tilt), deg(axis));
          SeenTips tips = project(hand, camera, truth);
          if (missing >= 0) tips[missing].reset();
          const auto pose = pose_from_tips(tips, hand, camera);
          ASSERT_TRUE(pose) << tilt << ' ' << axis;
          EXPECT_LT(test::rotation_error_rad(pose->T_camera_hand, truth), 1e-5);
          EXPECT_LT(test::translation_error_m(pose->T_camera_hand, truth), 1e-5);
          EXPECT_LT(pose->rms_px, 1e-3);
        }
}

TEST(TipPose, TheCovarianceTellsTheTruth) {
  const Camera camera = test::rendered_camera();
  const HandModel hand = test::rendered_hand();
  std::mt19937 rng = test::random_for("TipPose");
  double sum = 0;
  constexpr int kTrials = 400;
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Isometry3d truth = test::hand_at(0.35, deg(35), deg(i));
    SeenTips tips = project(hand, camera, truth);
    for (auto& tip : tips) *tip += Eigen::Vector2d(test::gauss(rng, 0.5), test::gauss(rng, 0.5));
    const auto pose = pose_from_tips(tips, hand, camera, 0.5, truth);
    ASSERT_TRUE(pose);
    const auto e = test::pose_error(truth, pose->T_camera_hand);
    sum += e.dot(pose->covariance.ldlt().solve(e)) / kTrials;
  }
  // Six freedoms: the mean is 6, its standard deviation over the trials 0.17; curvature adds some.
  EXPECT_NEAR(sum, 6, 1.0);
}

TEST(TipPose, RefusesWhatDoesNotDetermineIt) {
  const Camera camera = test::rendered_camera();
  const HandModel hand = test::rendered_hand();
  const SeenTips all = project(hand, camera, test::hand_at(0.45, deg(30), 1));
  SeenTips three = all, line = all, nan = all;
  three[0].reset();
  three[4].reset();
  for (int f = 0; f < kFingerCount; ++f) line[f] = {100 + 50 * f, 200 + 20 * f};
  (*nan[2]).x() = std::nan("");
  EXPECT_TRUE(pose_from_tips(all, hand, camera));
  EXPECT_FALSE(pose_from_tips(three, hand, camera));
  EXPECT_FALSE(pose_from_tips(line, hand, camera));
  EXPECT_FALSE(pose_from_tips(nan, hand, camera));
}

/// The film, looked at by the paper's tracker.
struct PaperFilm {
  Film film;
  Tracker tracker;
  TrackResult result;

  explicit PaperFilm(const Config& config = {}) : tracker(film.camera, film.hand_model, config) {}
  const TrackResult& next() {
    film.time_s += 1 / film.fps;
    ++film.frame;
    film.T_camera_hand = film.pose_at(film.time_s);
    return result = tracker.process(film.picture().view(), film.time_s);
  }
};

TEST(PaperTracker, TracksAfterItsVoteAndGivesThePose) {
  for (const bool half : {false, true}) {
    Config config;
    config.half_resolution = half;
    PaperFilm paper(config);
    for (int i = 0; i < config.vote_frames; ++i) paper.next();
    ASSERT_EQ(paper.result.state, State::tracking) << half;
    EXPECT_EQ(paper.result.layout, Layout::thumb_right);
    for (int i = 0; i < 30; ++i) paper.next();
    ASSERT_TRUE(paper.result.pose);
    EXPECT_LT(test::rotation_error_rad(paper.film.T_camera_hand, paper.result.pose->T_camera_hand),
              deg(12));
    EXPECT_GT(paper.tracker.mask().width, 0);
    paper.film.present = false;
    for (int i = 0; i < 10; ++i) paper.next();
    EXPECT_EQ(paper.result.state, State::lost);
    EXPECT_FALSE(paper.result.pose);
  }
}

}  // namespace
}  // namespace handyar::paper
