// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <bit>

#include "find/constellation.hpp"
#include "find/face_network.hpp"
#include "find/network.hpp"
#include "hand_film.hpp"
#include "handyar/stages/hand_finder.hpp"

namespace handyar {
namespace {

using test::deg;
using test::Film;
using test::Picture;

/// A drawn hand of a span of about `span_px` before a room of patches.
struct Shown {
  Film film;
  Picture picture;

  explicit Shown(double span_px, double turn_rad = 0, int width_px = 640, int height_px = 480)
      : film({}, width_px, height_px), picture(width_px, height_px) {
    picture.texture(30, "Room");
    const double distance_m = 0.165 * film.camera.fx_px / span_px;
    Eigen::Isometry3d T = test::hand_at(distance_m, deg(15), 0.6);
    T.linear() = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()) * T.linear();
    film.T_camera_hand = T;
    picture.paint(film.hand, film.camera, T);
    picture.add_noise(4, 7);
  }

  HandPlace place() const {
    HandPlace hand;
    hand.palm_px = film.camera.project(film.T_camera_hand.translation()).cast<float>();
    for (int f = 0; f < kFingerCount; ++f) hand.tips_px[f] = film.true_tip_px(f).cast<float>();
    return hand;
  }

  /// Largest distance of a candidate's tips to the true ones, in spans.
  double worst(const HandCandidate& hand) const {
    double px = 0;
    for (int f = 0; f < kFingerCount; ++f)
      px = std::max(px, (hand.tips_px[f].cast<double>() - film.true_tip_px(f)).norm());
    return px / (film.true_tip_px(0) - film.true_tip_px(4)).norm();
  }
};

/// Maps of the finder's network, as a test wants them.
class DrawnMaps {
 public:
  DrawnMaps() : numbers_(FinderMaps::kWidth * FinderMaps::kHeight * FinderNetwork::kOutputs, -9) {}

  void peak(int map, const Eigen::Vector2f& place, float log_odds) {
    for (int y = 0; y < FinderMaps::kHeight; ++y)
      for (int x = 0; x < FinderMaps::kWidth; ++x) {
        float& here = numbers_[(y * FinderMaps::kWidth + x) * FinderNetwork::kOutputs + map];
        const float off = (Eigen::Vector2f(x, y) - place).norm();
        here = std::max(here, log_odds - 2 * off);
      }
  }

  /// The likeliest hand in them.
  HandCandidate likeliest() const {
    HandCandidates hands;
    read_constellations(FinderMaps(numbers_), hands);
    hands.sort();
    if (!hands.items().empty()) return hands.items()[0];
    HandCandidate none{};
    none.log_odds = -9;
    return none;
  }

 private:
  std::vector<float> numbers_;
};

/// Fingertips of an average hand with the thumb right, in cells, turned a little.
std::array<Eigen::Vector2f, kFingerCount> tips_in_cells() {
  const HandModel hand = average_adult_hand();
  const Eigen::Rotation2Df turn(0.3f);
  std::array<Eigen::Vector2f, kFingerCount> tips;
  for (int f = 0; f < kFingerCount; ++f)
    tips[f] = Eigen::Vector2f(19, 17) +
              80 * (turn * Eigen::Vector2f(hand.tips_m(0, f), -hand.tips_m(1, f)).cast<float>());
  return tips;
}

TEST(Constellation, FingertipsThatLookAlikeAreToldByHowTheyLie) {
  const auto tips = tips_in_cells();
  DrawnMaps maps;
  maps.peak(FinderNetwork::kPalms, {18.6f, 19.2f}, 0.5f);
  for (int map = 0; map < kFingerCount; ++map)
    for (const Eigen::Vector2f& tip : tips) maps.peak(FinderNetwork::kTips + map, tip, 0.5f);
  const HandCandidate hand = maps.likeliest();
  EXPECT_EQ(hand.layout, Layout::thumb_right);
  for (int f = 0; f < kFingerCount; ++f) EXPECT_LT((hand.tips_px[f] - tips[f]).norm(), 0.6f) << f;
}

TEST(Constellation, AMissingFingertipIsWhereTheOthersExpectIt) {
  const auto tips = tips_in_cells();
  for (int missing = 0; missing < kFingerCount; ++missing) {
    DrawnMaps maps;
    maps.peak(FinderNetwork::kPalms, {18.6f, 19.2f}, 2);
    for (int f = 0; f < kFingerCount; ++f)
      if (f != missing) maps.peak(FinderNetwork::kTips + f, tips[f], 2);
    const HandCandidate hand = maps.likeliest();
    ASSERT_GT(hand.span_px(), 0) << missing;
    const float off = (hand.tips_px[missing] - tips[missing]).norm();
    EXPECT_LT(off, 0.25f * (tips[0] - tips[4]).norm()) << missing;
  }
}

TEST(Constellation, FingertipsThatNoHandHasAreNone) {
  DrawnMaps maps;
  maps.peak(FinderNetwork::kPalms, {18.6f, 19.2f}, -2);
  for (int f = 0; f < kFingerCount; ++f)  // in a row, the thumb in the middle
    maps.peak(FinderNetwork::kTips + f, {std::array{20.0f, 8.0f, 30.0f, 14.0f, 26.0f}[f], 15}, 0);
  EXPECT_LT(maps.likeliest().log_odds, 0);
}

void expect_found(const Shown& shown, std::span<const HandCandidate> hands) {
  ASSERT_GT(hands.size(), 0u);
  EXPECT_GT(hands[0].log_odds, 1);
  EXPECT_EQ(hands[0].layout, Layout::thumb_right);
  EXPECT_LT(shown.worst(hands[0]), 0.2);
}

class FinderAt : public testing::TestWithParam<int> {};

TEST_P(FinderAt, FindsHandsOfEverySizeAndTurn) {
  HandFinder finder;
  for (const double turn : {-25.0, 0.0, 25.0, 90.0, 180.0}) {
    const Shown shown(GetParam(), deg(turn));
    SCOPED_TRACE(turn);
    expect_found(shown, finder.search(shown.picture.view()));
  }
}
INSTANTIATE_TEST_SUITE_P(SpansPx, FinderAt, testing::Values(110, 160, 240, 330));

TEST(Finder, ASmallHandIsFoundAgainAtOnceWhereItWasLost) {
  const Shown shown(45);  // too small for a look at the whole frame
  const HandPlace lost = shown.place();
  HandFinder finder;
  for (const HandCandidate& hand : finder.search(shown.picture.view())) EXPECT_LT(hand.log_odds, 0);
  finder.reset();
  expect_found(shown, finder.search(shown.picture.view(), lost.region(2.6f * lost.span_px())));
}

TEST(Finder, AHandThatIsNotWhereItWasLostIsFoundElsewhere) {
  const Shown shown(220);
  HandFinder finder;
  const FinderRegion corner{{90, 60}, 160};
  expect_found(shown, finder.search(shown.picture.view(), corner));
}

TEST(Finder, MirroredPicturesShowTheOtherLayout) {
  const Shown shown(220);
  HandFinder finder;
  const Picture mirrored = shown.picture.mirrored();
  const auto hands = finder.search(mirrored.view());
  ASSERT_GT(hands.size(), 0u);
  EXPECT_EQ(hands[0].layout, Layout::thumb_left);
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2d px = hands[0].tips_px[f].cast<double>();
    const double span = 220;
    EXPECT_LT((Eigen::Vector2d(639 - px.x(), px.y()) - shown.film.true_tip_px(f)).norm(),
              0.2 * span);
  }
}

// A second look sees every hand upright: the same picture on its side or its head looks the same.
TEST(Finder, LooksAtAKnownHandUpright) {
  const Shown shown(220);
  HandFinder finder;
  const auto looked = [&](const Picture& picture, const HandPlace& hand) {
    const auto found = finder.look(picture.view(), hand.region(2.6f * hand.span_px()));
    return found.empty() ? HandCandidate{} : found[0];
  };
  using Place = Eigen::Vector2f;
  const HandPlace as_it_is = shown.place();
  const HandCandidate first = looked(shown.picture, as_it_is);
  ASSERT_GT(first.log_odds, 1);
  Picture turned = shown.picture;
  HandPlace hand = as_it_is;
  for (int quarter = 1; quarter < 4; ++quarter) {
    const int height = turned.height();
    const auto turn = [&](const Place& px) { return Place(height - 1 - px.y(), px.x()); };
    Picture next(height, turned.width());
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < turned.width(); ++x)
        std::copy_n(turned.at(x, y), 3, next.at(height - 1 - y, x));
    turned = next;
    hand.palm_px = turn(hand.palm_px);
    for (Place& tip_px : hand.tips_px) tip_px = turn(tip_px);
    const HandCandidate again = looked(turned, hand);
    EXPECT_EQ(again.layout, first.layout) << quarter;
    EXPECT_NEAR(again.log_odds, first.log_odds, 0.1) << quarter;
  }
}

TEST(Finder, SizesAndShapesOfFramesDoNotMatter) {
  HandFinder finder;
  for (const auto& [width, height, span] : {std::tuple{161, 121, 60},
                                            {321, 243, 110},
                                            {480, 640, 200},
                                            {1280, 720, 400},
                                            {1920, 1080, 500}}) {
    const Shown shown(span, 0, width, height);
    const auto hands = finder.search(shown.picture.view());
    ASSERT_GT(hands.size(), 0u) << width;
    EXPECT_LT(shown.worst(hands[0]), 0.2) << width;
  }
}

TEST(Finder, SeesNothingWhereThereIsNothing) {
  HandFinder finder;
  Picture flat(640, 480), room(640, 480), noise(640, 480);
  room.texture(30, "Room");
  noise.add_noise(70, 3);
  for (const Picture* picture : {&flat, &room, &noise})
    for (int i = 0; i < 6; ++i)  // all of its parts
      for (const HandCandidate& hand : finder.search(picture->view())) EXPECT_LT(hand.log_odds, 0);
}

TEST(Finder, GivesTheSameBitsAgain) {
  const Shown shown(200);
  HandFinder a, b;
  const auto first = a.search(shown.picture.view());
  const std::vector<HandCandidate> expected(first.begin(), first.end());
  b.search(Picture(640, 480).view());
  b.reset();
  const auto second = b.search(shown.picture.view());
  ASSERT_EQ(second.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(second[i].log_odds, expected[i].log_odds);
    EXPECT_EQ(second[i].tips_px, expected[i].tips_px);
  }
}

// Layers are summed in one order everywhere: the outputs' bits are the same on every machine, with
// and without vectors. The number is made anew whenever the weights are.
TEST(Finder, TheNetworkGivesTheSameBitsEverywhere) {
  FinderNetwork network;
  layers::Workspace workspace;
  std::mt19937 rng = test::random_for("network");
  for (float& x : workspace.beside) x = static_cast<float>(rng() % 256);
  std::uint32_t hash = 2166136261u;
  for (const float x : network.run(workspace))
    hash = (hash ^ std::bit_cast<std::uint32_t>(x)) * 16777619u;
  EXPECT_EQ(hash, 4055477145u);
}

TEST(Finder, TheFacesNetworkGivesTheSameBitsEverywhere) {
  Picture noise(64, 64);
  noise.add_noise(80, 1);
  HandPlace hand;
  const auto tips = tips_in_cells();
  for (int f = 0; f < kFingerCount; ++f) hand.tips_px[f] = 1.5f * tips[f];
  const FaceNetwork network;
  layers::Workspace workspace;
  const float log_odds =
      network.look(noise.view(), hand, Layout::thumb_right, workspace).palm_log_odds;
  EXPECT_EQ(std::bit_cast<std::uint32_t>(log_odds), 1074939668u) << log_odds;
}

// A mirrored palm is a palm, and so is one that is turned or larger, and its fingers have their
// roots where they have them.
TEST(Finder, FaceAndRootsHangNeitherOnTheSideNorOnTurnAndSize) {
  const FaceNetwork network;
  layers::Workspace workspace;
  constexpr float kRootsOff = 0.15f;
  const Shown shown(220);
  const int width = shown.picture.width(), height = shown.picture.height();
  // The same picture, each of its pixels elsewhere.
  const auto read = [&](Layout layout, int new_width, int new_height, const auto& from,
                        const auto& to) {
    Picture picture(new_width, new_height);
    for (int y = 0; y < new_height; ++y)
      for (int x = 0; x < new_width; ++x) {
        const auto [old_x, old_y] = from(x, y);
        std::copy_n(shown.picture.at(old_x, old_y), 3, picture.at(x, y));
      }
    HandPlace hand;
    for (int f = 0; f < kFingerCount; ++f)
      hand.tips_px[f] = to(shown.film.true_tip_px(f).cast<float>().eval());
    const FaceNetwork::Look look = network.look(picture.view(), hand, layout, workspace);
    for (int f = 0; f < kFingerCount; ++f)
      EXPECT_LT((look.roots_px[f] - to(shown.film.true_root_px(f).cast<float>().eval())).norm(),
                kRootsOff * hand.span_px())
          << f << " of " << new_width << " x " << new_height;
    return look.palm_log_odds;
  };
  using Place = Eigen::Vector2f;
  const float upright = read(
      Layout::thumb_right, width, height, [](int x, int y) { return std::pair(x, y); },
      [](const Place& p) { return p; });
  const float mirrored = read(
      Layout::thumb_left, width, height, [&](int x, int y) { return std::pair(width - 1 - x, y); },
      [&](const Place& p) { return Place(width - 1 - p.x(), p.y()); });
  const float turned = read(
      Layout::thumb_right, height, width,
      [&](int x, int y) { return std::pair(y, height - 1 - x); },
      [&](const Place& p) { return Place(height - 1 - p.y(), p.x()); });
  const float doubled = read(
      Layout::thumb_right, 2 * width, 2 * height,
      [](int x, int y) { return std::pair(x / 2, y / 2); },
      [](const Place& p) { return Place(2 * p.x() + 0.5f, 2 * p.y() + 0.5f); });
  EXPECT_NEAR(mirrored, upright, 0.1);
  EXPECT_NEAR(turned, upright, 0.1);
  EXPECT_NEAR(doubled, upright, 0.5);
}

}  // namespace
}  // namespace handyar
