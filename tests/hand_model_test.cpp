// SPDX-License-Identifier: MIT
#include "handyar/hand_model.hpp"

#include <gtest/gtest.h>

namespace handyar {
namespace {

TEST(HandModel, AverageAdultIsInItsOwnHandFrame) {
  const HandModel m = average_adult_hand();
  EXPECT_EQ(m.tips_m(0, int(Finger::middle)), 0.0);
  EXPECT_EQ(m.tips_m(1, int(Finger::thumb)), 0.0);
  EXPECT_NEAR(m.tips_m.row(2).mean(), 0.0, 1e-12);
  EXPECT_GT(m.tips_m(0, int(Finger::thumb)), 0.0) << "thumb at +x in thumb_right";
  EXPECT_TRUE(m.scale_assumed());
  EXPECT_NEAR(m.span_m(), 0.17, 0.03);
}

TEST(HandModel, TheOtherLayoutIsTheMirrorImage) {
  const HandModel m = average_adult_hand(), mirrored = m.for_layout(Layout::thumb_left);
  EXPECT_EQ(mirrored.layout, Layout::thumb_left);
  EXPECT_LT(mirrored.tips_m(0, int(Finger::thumb)), 0.0);
  EXPECT_TRUE(mirrored.tips_m.row(1).isApprox(m.tips_m.row(1)));
  EXPECT_TRUE(mirrored.for_layout(Layout::thumb_right).tips_m.isApprox(m.tips_m));
  EXPECT_TRUE(m.for_layout(Layout::thumb_right).tips_m.isApprox(m.tips_m));
}

}  // namespace
}  // namespace handyar
