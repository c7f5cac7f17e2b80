// SPDX-License-Identifier: MIT
#include "handyar/attachment.hpp"

#include <gtest/gtest.h>

#include "handyar/stages/hand_figure.hpp"

namespace handyar {
namespace {

/// The mean figure, seen so; its fingers as given.
struct Seen {
  explicit Seen(Face face, Layout layout = Layout::thumb_right)
      : hand(hand_of_figure({}, layout)),
        figure(make_figure(FigureCoefficients::Zero(), face, layout)) {
    hand.source = HandSource::truth;
    result.face = face;
    result.layout = layout;
  }
  Eigen::Isometry3d at(Attachment where) const { return T_hand_attachment(where, hand, result); }
  Eigen::Vector3d up(Attachment where) const { return at(where).linear().col(2); }

  HandModel hand;
  HandFigure figure;
  TrackResult result;
};

Attachment tip_of(int finger) {
  return static_cast<Attachment>(static_cast<int>(Attachment::thumb_tip) + finger);
}

TEST(AttachmentTest, EveryPlaceHasANameThatFindsIt) {
  for (int i = 0; i < kAttachmentCount; ++i) {
    const auto where = static_cast<Attachment>(i);
    EXPECT_EQ(find_attachment(name(where)), where);
  }
  EXPECT_EQ(name(Attachment::little_tip), "little_tip");
  EXPECT_FALSE(find_attachment("elbow"));
  EXPECT_FALSE(find_attachment(""));
}

TEST(AttachmentTest, EveryFrameIsRightHandedAndLooksTowardsTheWristOrTheEye) {
  for (const Face face : {Face::palm, Face::back})
    for (const Layout layout : {Layout::thumb_right, Layout::thumb_left}) {
      const Seen seen(face, layout);
      for (int i = 0; i < kAttachmentCount; ++i) {
        const auto where = static_cast<Attachment>(i);
        const Eigen::Matrix3d R = seen.at(where).linear();
        EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-9) << name(where);
        EXPECT_GT(R.determinant(), 0.99) << name(where);
        if (where >= Attachment::thumb_tip)
          EXPECT_GT(R(2, 0), 0.8) << name(where);
        else
          EXPECT_LT(R(1, 0), -0.99) << name(where);
      }
    }
}

TEST(AttachmentTest, TheFaceIsTheOneThatIsSeenAndTheOtherIsBehindTheHand) {
  for (const Face face : {Face::palm, Face::back}) {
    const Seen seen(face);
    const Attachment here = face == Face::palm ? Attachment::palm : Attachment::back;
    const Attachment there = face == Face::palm ? Attachment::back : Attachment::palm;
    EXPECT_TRUE(seen.at(here).isApprox(seen.at(Attachment::face)));
    EXPECT_GT(seen.up(here).z(), 0.99);
    EXPECT_LT(seen.up(there).z(), -0.99);
    const double behind_m = seen.at(there).translation().z();
    const double far_side_m = (seen.figure.centres_m.row(2) - seen.figure.radii_m).minCoeff();
    EXPECT_LT(behind_m, face == Face::palm ? -0.015 : -0.002);
    EXPECT_GT(behind_m, far_side_m - 0.001);
  }
}

TEST(AttachmentTest, AFingertipIsTheFiguresAndMovesWithItsFingerAlone) {
  Seen seen(Face::palm);
  for (int f = 0; f < kFingerCount; ++f) {
    const Seen rest(Face::palm);
    seen = rest;
    EXPECT_LT((rest.at(tip_of(f)).translation() - rest.figure.tips_m.col(f)).norm(), 1e-4);
    seen.result.fingers[f].flexion_rad = 0.5;
    for (int other = 0; other < kFingerCount; ++other) {
      const double moved_m =
          (seen.at(tip_of(other)).translation() - rest.at(tip_of(other)).translation()).norm();
      if (other == f)
        EXPECT_GT(moved_m, 0.01);
      else
        EXPECT_EQ(moved_m, 0);
    }
    // A finger that bends towards the palm, which is seen, points more towards the camera.
    EXPECT_GT(seen.up(tip_of(f)).z(), rest.up(tip_of(f)).z() + 0.3);
  }
}

TEST(AttachmentTest, BasesLieOnTheSkinBelowTheirFingersAndTheWristBelowThemAll) {
  const Seen seen(Face::palm);
  for (int f = 0; f < kFingerCount; ++f) {
    const auto base = static_cast<Attachment>(static_cast<int>(Attachment::thumb_base) + f);
    const Eigen::Vector3d base_m = seen.at(base).translation();
    EXPECT_GT((seen.figure.tips_m.col(f) - base_m).norm(), 0.03);
    EXPECT_LT((seen.figure.tips_m.col(f) - base_m).norm(), 0.1);
    EXPECT_GT(base_m.z(), 0);
    EXPECT_TRUE(on_finger(base));
    EXPECT_LT(seen.at(Attachment::wrist).translation().y(), base_m.y() - 0.03);
  }
  EXPECT_FALSE(on_finger(Attachment::wrist));
}

}  // namespace
}  // namespace handyar
