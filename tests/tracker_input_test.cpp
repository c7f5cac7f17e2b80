// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "hand_film.hpp"
#include "handyar/tracker.hpp"

namespace handyar {
namespace {

using test::deg;
using test::Film;
using test::Picture;

/// A picture's bytes in another format (BT.601, video range for the YCbCr ones).
struct Converted {
  std::vector<std::uint8_t> bytes, chroma;
  ImageView view;
};

Converted convert(const Picture& p, PixelFormat format, int padding = 0) {
  const int w = p.width(), h = p.height();
  const bool nv12 = format == PixelFormat::nv12, yuyv = format == PixelFormat::yuyv;
  const bool four = format == PixelFormat::bgra || format == PixelFormat::rgba;
  const bool rgb = format == PixelFormat::rgb || format == PixelFormat::rgba;
  const int bytes = nv12 ? 1 : yuyv ? 2 : four ? 4 : 3, stride = w * bytes + padding;
  Converted c;
  c.bytes.assign(static_cast<std::size_t>(stride) * h, 77);
  if (nv12) c.chroma.assign(static_cast<std::size_t>(stride) * h / 2, 77);
  const auto luma = [&](int x, int y) {
    const std::uint8_t* q = p.at(x, y);
    return std::uint8_t(16.5 + (65.74 * q[2] + 129.06 * q[1] + 25.06 * q[0]) / 256);
  };
  const auto chroma = [&](int x, int y, int rows, std::uint8_t* cb, std::uint8_t* cr) {
    double b = 0, g = 0, r = 0;
    for (int k = 0; k < 2 * rows; ++k) {
      const std::uint8_t* q = p.at(x + k % 2, y + k / 2);
      b += q[0], g += q[1], r += q[2];
    }
    b /= 2 * rows, g /= 2 * rows, r /= 2 * rows;
    *cb = std::uint8_t(128.5 + (-37.95 * r - 74.49 * g + 112.44 * b) / 256);
    *cr = std::uint8_t(128.5 + (112.44 * r - 94.15 * g - 18.29 * b) / 256);
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      std::uint8_t* to = &c.bytes[static_cast<std::size_t>(y) * stride + x * bytes];
      const std::uint8_t* from = p.at(x, y);
      if (nv12 || yuyv) to[0] = luma(x, y);
      if (yuyv && x % 2 == 0) chroma(x, y, 1, to + 1, to + 3);
      if (nv12 && x % 2 == 0 && y % 2 == 0) {
        std::uint8_t* pair = &c.chroma[static_cast<std::size_t>(y / 2) * stride + x];
        chroma(x, y, 2, pair, pair + 1);
      }
      if (nv12 || yuyv) continue;
      for (int k = 0; k < 3; ++k) to[k] = from[rgb ? 2 - k : k];
    }
  c.view = {c.bytes.data(),   w, h, stride, format, nv12 ? c.chroma.data() : nullptr,
            nv12 ? stride : 0};
  return c;
}

TEST(TrackerInput, EveryFormatShowsTheSameFingertips) {
  struct Other {
    PixelFormat format;
    double mean_limit_px, worst_limit_px;
    HandTracker tracker;
    double sum_px = 0;
    int count = 0;
  };
  Film film;
  std::vector<Other> others;
  const auto add = [&](PixelFormat format, double mean_limit_px, double worst_limit_px) {
    others.push_back(
        {format, mean_limit_px, worst_limit_px, HandTracker(film.camera, film.hand_model), 0, 0});
  };
  add(PixelFormat::rgb, 0.01, 0.01);
  add(PixelFormat::bgra, 0.01, 0.01);
  add(PixelFormat::rgba, 0.01, 0.01);
  add(PixelFormat::yuyv, 0.8, 2.5);  // colour at half the width
  add(PixelFormat::nv12, 0.8, 2.5);
  for (int i = 0; i < 20; ++i) {
    const TrackResult& expected = film.next();
    for (Other& other : others) {
      const Converted frame = convert(film.picture(), other.format, 14);
      const TrackResult r = other.tracker.process(frame.view, film.time_s);
      ASSERT_EQ(r.status, FrameStatus::ok);
      if (i < 14) continue;
      ASSERT_EQ(r.state, State::tracking) << int(other.format);
      for (int f = 0; f < kFingerCount; ++f) {
        const double apart_px = (r.tips[f].px - expected.tips[f].px).norm();
        EXPECT_LT(apart_px, other.worst_limit_px) << int(other.format) << " " << kFingerNames[f];
        other.sum_px += apart_px;
        ++other.count;
      }
    }
  }
  for (const Other& other : others)
    EXPECT_LT(other.sum_px / other.count, other.mean_limit_px) << int(other.format);
}

TEST(TrackerInput, RowsMayBeStoredBottomUp) {
  Film film;
  HandTracker tracker(film.camera, film.hand_model);
  for (int i = 0; i < 14; ++i) {
    film.next();
    const Picture p = film.picture();
    const std::ptrdiff_t row = p.width() * 3;
    std::vector<std::uint8_t> flipped(row * p.height());
    for (int y = 0; y < p.height(); ++y)
      std::copy_n(p.at(0, y), row, flipped.begin() + row * (p.height() - 1 - y));
    const ImageView view{flipped.data() + row * (p.height() - 1), p.width(), p.height(), -row,
                         PixelFormat::bgr};
    const TrackResult r = tracker.process(view, film.time_s);
    ASSERT_EQ(r.state, film.result.state);
    for (int f = 0; f < kFingerCount; ++f) EXPECT_EQ(r.tips[f].px, film.result.tips[f].px);
  }
  EXPECT_EQ(film.result.state, State::tracking);
}

TEST(TrackerInput, AMirroredFrameShowsMirroredTipsAndTheOtherLayout) {
  Film film;
  HandTracker tracker(film.camera, film.hand_model);
  TrackResult mirrored;
  for (int i = 0; i < 20; ++i) {
    film.next();
    mirrored = tracker.process(film.picture().mirrored().view(), film.time_s);
  }
  ASSERT_EQ(film.result.state, State::tracking);
  ASSERT_EQ(mirrored.state, State::tracking);
  EXPECT_EQ(film.result.layout, Layout::thumb_right);
  EXPECT_EQ(mirrored.layout, Layout::thumb_left);
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2d px = mirrored.tips[f].px;
    EXPECT_LT((Eigen::Vector2d(639 - px.x(), px.y()) - film.result.tips[f].px).norm(), 2.0)
        << kFingerNames[f];
  }
  Eigen::Isometry3d expected = film.result.pose->T_camera_hand;  // mirrored in x on both sides
  const Eigen::Matrix3d M = Eigen::Vector3d(-1, 1, 1).asDiagonal();
  expected.linear() = M * expected.linear() * M;
  expected.translation() = M * expected.translation();
  EXPECT_LT(test::rotation_error_rad(expected, mirrored.pose->T_camera_hand), deg(2));
  EXPECT_LT(test::translation_error_m(expected, mirrored.pose->T_camera_hand), 0.004);
}

class TrackerAtSize : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(TrackerAtSize, TracksTheHand) {
  const auto [width, height] = GetParam();
  Film film({}, width, height);
  ASSERT_LT(film.until(State::tracking, 1), 1);
  const double limit_px = std::max(2.5, 4 * std::max(width, height) / 640.0);
  for (int i = 0; i < 5; ++i) {
    film.next();
    ASSERT_EQ(film.result.state, State::tracking);
    EXPECT_LT(film.worst_tip_px(), limit_px);
  }
}
INSTANTIATE_TEST_SUITE_P(Sizes, TrackerAtSize,
                         testing::Values(std::pair{321, 241}, std::pair{641, 479},
                                         std::pair{480, 640}, std::pair{1280, 720}),
                         [](const auto& s) {
                           return std::to_string(s.param.first) + "x" +
                                  std::to_string(s.param.second);
                         });

TEST(TrackerInput, TheSmallestAndOddestSizesAreReadWithoutFault) {
  for (const auto& [width, height] : {std::pair{160, 120}, {161, 121}, {121, 163}, {4096, 121}}) {
    Film film({}, width, height);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(film.next().status, FrameStatus::ok);
  }
}

TEST(TrackerInput, AnotherSizeRescalesTheCamera) {
  Film film;
  ASSERT_LT(film.until(State::tracking, 1), 1);
  film.camera = film.camera.scaled_to(1280, 960);  // the tracker keeps the one it was given
  EXPECT_LT(film.until(State::tracking, 1), 0.5);
  for (int i = 0; i < 5; ++i) film.next();
  ASSERT_TRUE(film.result.pose);
  EXPECT_LT(test::translation_error_m(film.T_camera_hand, film.result.pose->T_camera_hand), 0.01);
}

TEST(TrackerInput, FramesThatCannotBeReadChangeNothing) {
  Film film, untouched;
  for (int i = 0; i < 20; ++i) {
    film.next();
    untouched.next();
    const Picture p = film.picture();
    ImageView grey = p.view(), none = p.view(), tiny = p.view();
    grey.format = PixelFormat::gray;
    none.data = nullptr;
    tiny.width_px = tiny.height_px = 1;
    EXPECT_EQ(film.tracker.process(grey, film.time_s + 0.001).status,
              FrameStatus::gray_unsupported);
    EXPECT_EQ(film.tracker.process(none, film.time_s + 0.002).status, FrameStatus::no_data);
    EXPECT_EQ(film.tracker.process(tiny, film.time_s + 0.003).status,
              FrameStatus::size_unsupported);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const double t : {film.time_s, film.time_s - 1, std::nan(""), kInfinity, -kInfinity}) {
      const TrackResult r = film.tracker.process(p.view(), t);
      EXPECT_EQ(r.status, FrameStatus::time_not_increasing) << t;
      EXPECT_FALSE(r.pose || r.raw_pose) << "an old pose passed off as new";
    }
    ASSERT_EQ(film.result.state, untouched.result.state);
    for (int f = 0; f < kFingerCount; ++f)
      ASSERT_EQ(film.result.tips[f].px, untouched.result.tips[f].px);
  }
  EXPECT_EQ(film.result.state, State::tracking);
}

/// The numbers of a result, to be compared bit by bit.
std::vector<double> numbers(const TrackResult& r) {
  std::vector<double> n = {double(r.state), r.layout ? double(*r.layout) : -1};
  for (const auto& points : {std::span<const Tip>(r.tips), std::span<const Tip>(r.webs)})
    for (const Tip& t : points)
      for (const double x : {double(t.seen), t.px.x(), t.px.y()}) n.push_back(x);
  const auto add = [&](const Eigen::Isometry3d& T, const Matrix6d& covariance) {
    n.insert(n.end(), T.data(), T.data() + 16);
    n.insert(n.end(), covariance.data(), covariance.data() + 36);
  };
  if (r.raw_pose) add(r.raw_pose->T_camera_hand, r.raw_pose->covariance);
  if (r.pose) add(r.pose->T_camera_hand, r.pose->covariance);
  return n;
}

TEST(TrackerInput, TheSameInputGivesTheSameResultBitByBit) {
  const auto play = [](Film& film) {
    std::vector<double> all;
    film.textured = true;
    film.frame = 0;
    for (int i = 0; i < 40; ++i) {
      film.present = i < 25 || i > 30;
      const std::vector<double> n = numbers(film.next());
      all.insert(all.end(), n.begin(), n.end());
    }
    return all;
  };
  Film first, second;
  const std::vector<double> expected = play(first);
  EXPECT_EQ(first.result.state, State::tracking);
  EXPECT_EQ(play(second), expected) << "a fresh tracker";
  for (const int searched : {30, 31}) {
    second.present = false;
    for (int i = 0; i < searched; ++i) second.next();
    second.tracker.reset();
    second.time_s = 0;  // newly made: time may begin again
    EXPECT_EQ(play(second), expected) << "the same tracker after reset()";
  }
}

TEST(TrackerInput, HardlyAnySmoothingGivesPosesToo) {
  Config config;
  config.smoothing = 1e-12;
  Film film(config);
  ASSERT_LT(film.until(State::tracking, 1), 1);
  for (int i = 0; i < 30; ++i) {
    const TrackResult& r = film.next();
    ASSERT_TRUE(r.pose) << "frame " << film.frame;
    EXPECT_TRUE(r.pose->covariance.allFinite());
    EXPECT_LT(test::rotation_error_rad(film.T_camera_hand, r.pose->T_camera_hand), deg(3));
  }
}

TEST(TrackerInput, TheResultSaysWhatIsAssumed) {
  Camera camera = Camera::from_field_of_view(640, 480);
  HandModel hand = average_adult_hand();
  const Picture empty(640, 480);
  const auto look = [&] { return HandTracker(camera, hand).process(empty.view(), 0); };
  EXPECT_TRUE(look().camera_assumed);
  EXPECT_TRUE(look().scale_assumed);
  hand.source = HandSource::checkerboard;
  EXPECT_FALSE(look().scale_assumed);
  camera.assumed = false;
  EXPECT_FALSE(look().camera_assumed);
}

double tick_s() {
  static double t = 0;
  return t += 0.001;
}

TEST(TrackerInput, StagesAreTimedOnlyWithAClock) {
  Film silent;
  EXPECT_EQ(silent.next().times.total_ms, 0);
  Config config;
  config.now_s = tick_s;
  Film timed(config);
  ASSERT_LT(timed.until(State::tracking, 1), 1);
  timed.next();
  const StageTimes& t = timed.result.times;
  for (const double ms : {t.segmentation_ms, t.pose_ms, t.filter_ms}) EXPECT_GT(ms, 0.9);
  EXPECT_GE(t.total_ms + 1e-6, t.segmentation_ms + t.pose_ms + t.filter_ms);
}

}  // namespace
}  // namespace handyar
