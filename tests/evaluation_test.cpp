// SPDX-License-Identifier: MIT
// The evaluation's own figures on tracks whose errors are known because they were made.
#include <gtest/gtest.h>

#include "evaluation_scene.hpp"
#include "handyar/evaluation/accuracy.hpp"
#include "handyar/evaluation/dynamics.hpp"
#include "handyar/evaluation/rigid.hpp"
#include "handyar/evaluation/statistics.hpp"
#include "handyar/evaluation/tables.hpp"

namespace handyar::evaluation {
namespace {

TEST(Statistics, AreThoseOfTheUsualDefinitions) {
  const std::vector<double> v = {4, 1, kUnknown, 3, 2, 10};
  const Summary s = summarize(v);
  EXPECT_EQ(s.n, 5);
  EXPECT_DOUBLE_EQ(s.median, 3);
  EXPECT_DOUBLE_EQ(s.mean, 4);
  EXPECT_DOUBLE_EQ(s.variance, 10);
  EXPECT_DOUBLE_EQ(s.p95, 8.8);  // between the fourth and the fifth, as numpy has it
  EXPECT_TRUE(std::isnan(summarize(std::vector<double>{}).mean));
}

TEST(Rigid, RobustMeanShrugsOffAFifthOfWrongMeasurements) {
  std::mt19937 random = random_numbers();
  const Eigen::Isometry3d truth = pose({0.5, -1.2, 2.0}, {0.1, -0.2, 0.3});
  std::vector<Eigen::Isometry3d> measured;
  for (int i = 0; i < 200; ++i)
    measured.push_back(i % 5 == 0 ? pose({0, 0, 2.5}, {0.3, 0.3, 0.5})
                                  : truth * pose(normal3(random, 0.01), normal3(random, 0.002)));
  const Eigen::Isometry3d mean = robust_mean(measured);
  EXPECT_LT(angle_between(mean.linear(), truth.linear()), 0.3 * kRadians);
  EXPECT_LT((mean.translation() - truth.translation()).norm(), 0.0005);
}

TEST(Rigid, FitFindsTheTransformBetweenPointSets) {
  const Eigen::Isometry3d T = pose({0.1, 0.2, -0.3}, {0.01, 0.02, 0.03});
  const Eigen::Matrix3Xd points = average_adult_hand().tips_m;
  const Eigen::Matrix3Xd moved = T * points;
  EXPECT_TRUE(rigid_fit(points, moved).isApprox(T, 1e-9));
}

TEST(Accuracy, AnExactTrackHasNoError) {
  const Truth truth = make_truth(100);
  const Accuracy a = summarize(compare(truth, truth.hand, exact_track(truth)));
  EXPECT_EQ(a.eligible, 75);  // 25 frames are given for acquisition
  EXPECT_EQ(a.tracked, 75);
  EXPECT_EQ(a.wrong, 0);
  EXPECT_EQ(a.layout_wrong, 0);
  EXPECT_LT(a.tip_px.max, 1e-9);
  EXPECT_LT(a.rotation_deg.max, 1e-4);
  EXPECT_LT(a.translation_mm.max, 1e-9);
  EXPECT_LT(a.board_px.max, 1e-6);
  EXPECT_LT(a.palm_px.max, 1e-6);
  EXPECT_EQ(a.palm_within_8px, 1);
}

TEST(Accuracy, KnownErrorsComeOutAsTheyWentIn) {
  const Truth truth = make_truth(100);
  std::vector<TrackResult> track = exact_track(truth);
  for (TrackResult& r : track) {
    for (Tip& tip : r.tips) tip.px += Eigen::Vector2d(3, -4);
    r.pose->T_camera_hand.linear() =
        pose({0, 2 * kRadians, 0}, {0, 0, 0}).linear() * r.pose->T_camera_hand.linear();
    r.pose->T_camera_hand.translation() += Eigen::Vector3d(0, 0.003, 0.004);
  }
  const Accuracy a = summarize(compare(truth, truth.hand, track));
  EXPECT_NEAR(a.tip_px.mean, 5, 1e-9);
  EXPECT_NEAR(a.rotation_deg.median, 2, 1e-6);
  EXPECT_NEAR(a.translation_mm.median, 5, 1e-9);
  EXPECT_GT(a.board_px.median, 3.0);
  EXPECT_GT(a.palm_px.median, 3.0) << "0.003 m at arm's length";
  EXPECT_LT(a.board_raw_px.max, 1e-6) << "the raw pose was left alone";
}

TEST(Accuracy, AFrameIsWrongWhenATipIsFarOffOrMissing) {
  const Truth truth = make_truth(60);
  std::vector<TrackResult> track = exact_track(truth);
  const double span_px = truth.frames[40].span_px();
  track[40].tips[2].px.x() += 0.19 * span_px;
  track[41].tips[2].px.x() += 0.22 * truth.frames[41].span_px();
  track[42].tips[4].seen = false;
  const std::vector<FrameError> errors = compare(truth, truth.hand, track);
  EXPECT_FALSE(errors[40].wrong);
  EXPECT_TRUE(errors[41].wrong);
  EXPECT_TRUE(errors[42].wrong);
  EXPECT_EQ(summarize(errors).wrong, 2);
}

TEST(Accuracy, ASecondHandIsNeitherRightNorWrong) {
  Truth truth = make_truth(60);
  for (TruthFrame& f : truth.frames) {
    f.other_tips_px.emplace(f.tips_px);
    for (Eigen::Vector2d& tip : *f.other_tips_px) tip.x() += 2 * f.span_px();
  }
  std::vector<TrackResult> track = exact_track(truth);
  for (std::size_t i = 40; i < 43; ++i) {
    track[i].pose->T_camera_hand.translation().x() += 0.2;
    for (std::size_t k = 0; k < kFingerCount; ++k)
      track[i].tips[k].px = (*truth.frames[i].other_tips_px)[k];
  }
  const std::vector<FrameError> errors = compare(truth, truth.hand, track);
  EXPECT_TRUE(errors[39].right());
  EXPECT_FALSE(errors[40].right());
  EXPECT_FALSE(errors[40].wrong);
  const Accuracy a = summarize(errors);
  EXPECT_EQ(a.on_other_hand, 3);
  EXPECT_EQ(a.wrong, 0);
  EXPECT_LT(a.translation_mm.max, 1e-3) << "the pose of the other hand is not compared";
}

TEST(Accuracy, FingersAreComparedWhereTheyLive) {
  Truth truth = make_truth(60);
  std::vector<TrackResult> track = exact_track(truth);
  EXPECT_EQ(summarize(compare(truth, truth.hand, track)).abduction_deg.n, 0);
  for (std::size_t i = 0; i < track.size(); ++i) {
    truth.frames[i].fingers.emplace();
    (*truth.frames[i].fingers)[1] = {-3, 10};
    track[i].fingers[1] = {2 * kRadians, 0, 5 * kRadians, 0};
  }
  const Accuracy a = summarize(compare(truth, truth.hand, track));
  EXPECT_NEAR(a.abduction_deg.median, 1, 1e-9);
  EXPECT_NEAR(a.flexion_deg.median, 1, 1e-9);
}

TEST(Accuracy, TimeIsGivenAfterTheTipsWereHidden) {
  Truth truth = make_truth(100);
  for (std::size_t i = 50; i < 60; ++i) truth.frames[i].all_tips_visible = false;
  for (std::size_t i = 52; i < 55; ++i) truth.frames[i].no_open_hand = true;
  const std::vector<FrameError> errors = compare(truth, truth.hand, exact_track(truth));
  EXPECT_TRUE(errors[49].eligible);
  EXPECT_FALSE(errors[55].eligible);
  EXPECT_FALSE(errors[71].eligible) << "twelve frames to find it again";
  EXPECT_TRUE(errors[72].eligible);
  EXPECT_EQ(summarize(errors).falsely_tracked, 3);
}

TEST(Accuracy, TheTimeGivenIsTheSameAtEveryRate) {
  for (const int rate : {15, 60}) {
    Truth truth = make_truth(300);
    truth.frames_per_second = rate;
    for (std::size_t i = 100; i < 110; ++i) truth.frames[i].all_tips_visible = false;
    const std::vector<FrameError> errors = compare(truth, truth.hand, exact_track(truth));
    const std::size_t found = 110 + std::size_t(0.4 * rate);
    EXPECT_FALSE(errors[found - 1].eligible) << rate;
    EXPECT_TRUE(errors[found].eligible) << rate;
  }
}

TEST(Accuracy, AMovedHandFrameIsNoError) {
  const Truth truth = make_truth(60);
  const Eigen::Isometry3d T_truth_model = pose({0.05, -0.02, 0.1}, {0.004, -0.003, 0.002});
  HandModel calibrated = truth.hand;
  calibrated.source = HandSource::checkerboard;
  calibrated.tips_m = T_truth_model.inverse() * truth.hand.tips_m;
  std::vector<TrackResult> track = exact_track(truth);
  for (TrackResult& r : track) r.pose->T_camera_hand = r.pose->T_camera_hand * T_truth_model;
  const Accuracy a = summarize(compare(truth, calibrated, track));
  EXPECT_LT(a.rotation_deg.max, 1e-4);
  EXPECT_LT(a.translation_mm.max, 1e-6);
}

TEST(Accuracy, AnHonestCovarianceIsFoundHonestAndABoastfulOneIsNot) {
  std::mt19937 random = random_numbers();
  const Truth truth = make_truth(600);
  std::vector<TrackResult> track = exact_track(truth);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 1e-4, 4e-4, 1e-4, 1e-6, 1e-6, 9e-6;
  for (TrackResult& r : track) {
    const Eigen::Vector3d w = normal3(random, 1).cwiseProduct(Eigen::Vector3d(0.01, 0.02, 0.01));
    const Eigen::Vector3d d = normal3(random, 1).cwiseProduct(Eigen::Vector3d(1e-3, 1e-3, 3e-3));
    const Eigen::Isometry3d error = pose(w, {0, 0, 0});
    r.raw_pose->T_camera_hand.linear() =
        error.linear().transpose() * r.raw_pose->T_camera_hand.linear();
    r.raw_pose->T_camera_hand.translation() -= d;
    r.raw_pose->covariance = covariance;
    *r.pose = FilteredPose{};
    r.pose->T_camera_hand = r.raw_pose->T_camera_hand;
    r.pose->covariance = covariance / 4;
  }
  const Accuracy a = summarize(compare(truth, truth.hand, track));
  EXPECT_NEAR(a.nees_raw.mean, 6, 0.6);
  EXPECT_NEAR(a.nees_raw_within_95, 0.95, 0.03);
  EXPECT_NEAR(a.nees.mean, 24, 2.4);
  EXPECT_LT(a.nees_within_95, 0.4);
}

TEST(Dynamics, ADelayIsFoundToATenthOfAFrame) {
  std::mt19937 random = random_numbers();
  const Truth truth = make_truth(300);
  for (const double lag_frames : {0.0, 1.0, 2.5}) {
    Poses late(300);
    for (int i = 0; i < 300; ++i)
      late[std::size_t(i)] =
          hand_at(i - lag_frames) * pose(normal3(random, 0.002), normal3(random, 0.0003));
    const std::optional<double> delay = delay_s(truth, late);
    ASSERT_TRUE(delay);
    EXPECT_NEAR(*delay * 30, lag_frames, 0.1);
  }
  EXPECT_FALSE(delay_s(make_truth(100, [](double) { return hand_at(0); }), Poses(100, hand_at(0))));
  EXPECT_FALSE(delay_s(make_truth(3), Poses(3, hand_at(0))));
}

TEST(Dynamics, JitterIsTheSpreadOfTheErrorNotItsMean) {
  std::mt19937 random = random_numbers();
  const Truth truth = make_truth(200, [](double) { return hand_at(0); });
  Poses trembling(200);
  for (auto& T : trembling) {
    T = pose(normal3(random, 0.1 * kRadians), {0, 0, 0}) * hand_at(0);
    T->translation() =
        hand_at(0).translation() + normal3(random, 2e-4) + Eigen::Vector3d(0.01, 0, 0);
  }
  const Jitter j = jitter(truth, trembling);
  EXPECT_EQ(j.frames, 200);
  EXPECT_NEAR(j.translation_mm, 0.2 * std::sqrt(3), 0.03);
  EXPECT_NEAR(j.rotation_deg, 0.1 * std::sqrt(3), 0.015);
}

TEST(Dynamics, AnAssumedSizeOfTheHandIsNoJitter) {
  const Truth truth = make_truth(100, [](double frame) {
    Eigen::Isometry3d T = hand_at(0);
    T.translation().z() += 5e-4 * frame;  // slowly away
    return T;
  });
  HandModel small = truth.hand;
  small.source = HandSource::average_adult;
  small.tips_m *= 0.8;
  std::vector<TrackResult> track = exact_track(truth);
  for (TrackResult& r : track) r.pose->T_camera_hand.translation() *= 0.8;
  const std::vector<FrameError> errors = compare(truth, small, track);
  EXPECT_LT(summarize(errors).translation_mm.max, 1e-6);
  const Jitter j = jitter(truth, right_poses(truth, small, track, errors, true));
  EXPECT_EQ(j.frames, 100);
  EXPECT_LT(j.translation_mm, 1e-6);
}

TEST(Dynamics, RecoveriesAreTimedFromWhenTheHandCouldBeSeen) {
  Truth truth = make_truth(200);
  std::vector<TrackResult> track = exact_track(truth);
  const auto lose = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) track[i].state = State::lost;
  };
  lose(0, 12);
  for (std::size_t i = 50; i < 60; ++i) truth.frames[i].all_tips_visible = false;
  lose(50, 66);
  lose(100, 103);
  lose(170, 200);
  const std::vector<Recovery> r = recoveries(truth, compare(truth, truth.hand, track));
  ASSERT_EQ(r.size(), 4u);
  EXPECT_EQ(r[0].kind, Recovery::Kind::first_sight);
  EXPECT_NEAR(*r[0].after_s, 12 / 30.0, 1e-9);
  EXPECT_EQ(r[1].kind, Recovery::Kind::hidden_before);
  EXPECT_NEAR(*r[1].after_s, 6 / 30.0, 1e-9);
  EXPECT_EQ(r[2].kind, Recovery::Kind::lost_in_view);
  EXPECT_NEAR(*r[2].after_s, 3 / 30.0, 1e-9);
  EXPECT_FALSE(r[3].after_s) << "never found again";
}

TEST(Dynamics, ASecondHandIsNotTheRightOne) {
  Truth truth = make_truth(100);
  const std::vector<TrackResult> track = exact_track(truth);
  std::vector<FrameError> errors = compare(truth, truth.hand, track);
  for (std::size_t i = 50; i < 65; ++i) errors[i].on_other_hand = true;
  const Poses poses = right_poses(truth, truth.hand, track, errors, true);
  EXPECT_TRUE(poses[49]);
  EXPECT_FALSE(poses[50]);
  const std::vector<Recovery> r = recoveries(truth, errors);
  ASSERT_EQ(r.size(), 2u);
  EXPECT_EQ(r[1].kind, Recovery::Kind::lost_in_view);
  EXPECT_NEAR(*r[1].after_s, 15 / 30.0, 1e-9);
}

TEST(Csv, FieldsAndNumbersKeepTheirMeaning) {
  EXPECT_EQ(csv_field("rotation, raw"), "\"rotation, raw\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
  EXPECT_EQ(csv_number(kUnknown), "");
  EXPECT_EQ(csv_number(12.3456789), "12.3457");
}

}  // namespace
}  // namespace handyar::evaluation
