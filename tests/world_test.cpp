// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "handyar/io/error.hpp"
#include "handyar/opencv/types.hpp"
#include "handyar/world/placement.hpp"
#include "handyar/world/world_tracker.hpp"
#include "temporary_folder.hpp"

// A tabletop that the test draws itself: a printed table, a box that stands on it, a flat grey hand
// that lies on it at first. So the truth of every frame is known.
namespace handyar::world {
namespace {

constexpr double kFrame_s = 1 / 30.0;
constexpr double kTexel_m = 0.0008;

/// Random numbers of the running test, others for each `stream`.
cv::RNG random_numbers(std::string_view stream) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = test->name() + std::string(stream);
  std::seed_seq seed(name.begin(), name.end());
  std::array<std::uint32_t, 2> numbers;
  seed.generate(numbers.begin(), numbers.end());
  return cv::RNG(std::uint64_t{numbers[0]} << 32 | numbers[1]);
}

/// A print of random rectangles, of many sizes and greys.
cv::Mat print(int size, cv::RNG random) {
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
cv::Mat keyboard_and_print(int size, cv::RNG random) {
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
Eigen::Isometry3d from(double azimuth_rad, double tilt_rad, double distance_m,
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
Errors errors(const Eigen::Isometry3d& T_camera_world, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d off = T_camera_world.inverse() * truth;
  return {Eigen::AngleAxisd(off.linear()).angle(), off.translation().norm()};
}

constexpr double kDegree = std::numbers::pi / 180;

/// The orbit of a test: still with the hand, then round the table, away, and back.
Eigen::Isometry3d orbit(int frame) {
  const double s = std::max(0, frame - 30) / 150.0;
  const double away = frame >= 140 && frame < 165 ? -80 * kDegree : 0;
  return from(0.9 * std::sin(4 * s), 0.5 + 0.25 * std::sin(7 * s), 0.5 + 0.1 * std::sin(5 * s),
              away);
}
constexpr int kFrames = 200, kHandUntil = 30, kAway = 140, kBack = 165;

TEST(World, IsSetByTheHandAndStaysWhereItWas) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  int set = -1, recognised = -1;
  double worst_rotation_rad = 0, worst_share = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const Eigen::Isometry3d truth = orbit(frame);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    const auto result = tracker.process(
        bgr, frame * kFrame_s, table.hand(with_hand ? std::optional(truth) : std::nullopt));
    if (set < 0 && result.state == WorldState::tracked) set = frame;
    if (frame >= kAway && frame < kBack) {
      EXPECT_EQ(result.state, WorldState::lost) << frame;
      EXPECT_FALSE(result.T_camera_world) << frame;
      continue;
    }
    if (set < 0) continue;
    ASSERT_TRUE(frame >= kAway || result.state == WorldState::tracked) << frame;
    if (!result.T_camera_world) continue;
    if (frame >= kBack && recognised < 0) recognised = frame;
    const Errors off = errors(*result.T_camera_world, truth);
    worst_rotation_rad = std::max(worst_rotation_rad, off.rotation_rad);
    worst_share = std::max(worst_share, off.distance_m / truth.translation().norm());
  }
  EXPECT_GE(set, 15);  // half a second
  EXPECT_LT(set, 20);
  EXPECT_LT(worst_rotation_rad, 1 * kDegree);
  EXPECT_LT(worst_share, 0.01);
  EXPECT_GE(recognised, kBack);
  EXPECT_LE(recognised, kBack + 9);  // 0.3 s
}

TEST(World, IsNotTakenForOneKeyOffWhereThingsRepeat) {
  Tabletop table("table", keyboard_and_print);
  WorldTracker tracker(table.camera);
  int tracked = 0;
  for (int frame = 0; frame < 240; ++frame) {
    // Round the table, and away and back faster and faster.
    const double s = std::max(0, frame - 30) / 150.0;
    const int swing = std::max(0, frame - 60) % 60;
    const double away_rad =
        swing < 40 ? 0 : -0.6 * kDegree * std::pow(10 - std::abs(50 - swing), 2);
    const Eigen::Isometry3d truth =
        from(0.5 * std::sin(4 * s), 0.3 + 0.2 * std::sin(7 * s), 0.5, away_rad);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    const auto result = tracker.process(
        bgr, frame * kFrame_s, table.hand(with_hand ? std::optional(truth) : std::nullopt));
    if (!result.T_camera_world) continue;
    ++tracked;
    const Errors off = errors(*result.T_camera_world, truth);
    EXPECT_LT(off.rotation_rad, 3 * kDegree) << frame;
    EXPECT_LT(off.distance_m, 0.05 * truth.translation().norm()) << frame;
  }
  EXPECT_GT(tracked, 120);
}

TEST(World, AHandWithWrongTiltIsPutRightByTheMovingCamera) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  // As the hand says, the frame is tilted by 3 degrees against the table.
  Eigen::Isometry3d T_table_hand = Eigen::Isometry3d::Identity();
  T_table_hand.linear() =
      Eigen::AngleAxisd(3 * kDegree, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  for (int frame = 0; frame < kAway; ++frame) {
    const Eigen::Isometry3d truth = orbit(frame);
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(truth, with_hand);
    tracker.process(bgr, frame * kFrame_s,
                    table.hand(with_hand ? std::optional(truth * T_table_hand) : std::nullopt));
  }
  ASSERT_TRUE(tracker.map());
  const Eigen::Vector3d up = T_table_hand.linear().transpose() * Eigen::Vector3d::UnitZ();
  const double off_rad = std::acos(std::min(1.0, up.dot(tracker.map()->ground.normal())));
  EXPECT_LT(off_rad, 0.5 * kDegree);
  EXPECT_GT(tracker.map()->keyframes.size(), 2u);
}

/// What hinders a hand in most of 1.5 s: the camera goes round the table by `turn_rad` a frame.
/// `T_table_hand` tells where the hand is in each frame.
Hindrance hindrance_of(Tabletop& table, double turn_rad,
                       const std::function<Eigen::Isometry3d(int)>& T_table_hand) {
  WorldTracker tracker(table.camera);
  std::map<Hindrance, int> frames;
  for (int frame = 0; frame < 45; ++frame) {
    const Eigen::Isometry3d T_camera_table = from(turn_rad * frame, 0.5, 0.5);
    const cv::Mat bgr = table.draw(T_camera_table, true);
    const auto result =
        tracker.process(bgr, frame * kFrame_s, table.hand(T_camera_table * T_table_hand(frame)));
    EXPECT_NE(result.state, WorldState::tracked) << frame;
    if (result.hindrance) ++frames[*result.hindrance];
  }
  EXPECT_FALSE(tracker.map());
  return std::max_element(frames.begin(), frames.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

Eigen::Isometry3d displaced(double x_m, double z_m, double tilt_rad = 0) {
  return Eigen::Translation3d(x_m, 0, z_m) * Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX());
}

TEST(World, AHandThatMovesOverTheTableSetsNothing) {
  Tabletop table;
  const auto at_6_cm_s = [](int frame) { return displaced(0.002 * frame, 0); };
  EXPECT_EQ(hindrance_of(table, 0, at_6_cm_s), Hindrance::moving);
}

TEST(World, AHandAboveTheTableSetsNothing) {
  Tabletop table;
  for (const double height_m : {0.1, 0.15, 0.2}) {
    const auto held = [&](int) { return displaced(0, height_m); };
    EXPECT_EQ(hindrance_of(table, 0.01, held), Hindrance::off_ground) << height_m;
  }
}

TEST(World, AHandSeenFromTheSideSetsNothing) {
  Tabletop table;
  const auto upright = [](int) { return displaced(0, 0, -1.9); };
  EXPECT_EQ(hindrance_of(table, 0, upright), Hindrance::tilted);
}

TEST(World, AHandOnABareTableSetsNothing) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  const cv::Mat bare(table.draw(truth, true).size(), CV_8UC3, cv::Scalar(90, 80, 70));
  for (int frame = 0; frame < 20; ++frame)
    EXPECT_EQ(tracker.process(bare, frame * kFrame_s, table.hand(truth)).hindrance,
              Hindrance::bare);
  EXPECT_FALSE(tracker.map());
}

TEST(World, AHandThatHasJustComeIsNotMissed) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  const WorldResult first = tracker.process(table.draw(truth, true), 0, table.hand(truth));
  EXPECT_EQ(first.state, WorldState::setting);
  EXPECT_FALSE(first.hindrance);
}

TEST(World, PicturesThatAreNotTheCamerasAreRefused) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  const cv::Mat bgr = table.draw(truth, true);
  for (int frame = 0; frame < 20; ++frame)
    tracker.process(bgr, frame * kFrame_s, table.hand(truth));
  cv::Mat half, grey;
  cv::resize(bgr, half, bgr.size() / 2);
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  for (const cv::Mat& other : {half, grey, cv::Mat()})
    EXPECT_THROW(tracker.process(other, 20 * kFrame_s, {}), cv::Exception) << other.size();
  EXPECT_EQ(tracker.process(bgr, 20 * kFrame_s, table.hand(truth)).state, WorldState::tracked);
}

TEST(World, TellsWhetherItWaitsForAHandOrForASurePose) {
  Tabletop table;
  WorldTracker tracker(table.camera);
  const Eigen::Isometry3d truth = from(0, 0.5, 0.5);
  EXPECT_EQ(tracker.process(table.draw(truth, false), 0, table.hand({})).hindrance,
            Hindrance::no_hand);
  const cv::Mat bgr = table.draw(truth, true);
  HandInWorld unsure = table.hand(truth);
  unsure.T_camera_hand.reset();
  EXPECT_EQ(tracker.process(bgr, kFrame_s, unsure).hindrance, Hindrance::unsure);
  // Then it lies still.
  for (int frame = 2; frame < 20; ++frame) {
    const auto result = tracker.process(bgr, frame * kFrame_s, table.hand(truth));
    EXPECT_TRUE(frame < 11 || !result.hindrance) << frame;
  }
  EXPECT_TRUE(tracker.map());
}

WorldMap made_map(Tabletop& table) {
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

TEST(World, IsRecognisedInAnotherRunAndByAnotherCameraAndNothingElseIs) {
  Tabletop table, other("another table");
  const test::TemporaryFolder folder;
  const std::string file = folder / "desk.map";
  write_map(file, made_map(table));
  const WorldMap map = read_map(file);
  table.camera = Camera::from_field_of_view(640, 480, 1.2);
  WorldTracker here(table.camera, map), elsewhere(other.camera, map);
  int recognised = 0;
  for (int frame = 0; frame < 20; ++frame) {
    const Eigen::Isometry3d truth = from(0.3 + 0.01 * frame, 0.55, 0.5);
    const auto result = here.process(table.draw(truth, false), frame * kFrame_s, table.hand({}));
    if (result.T_camera_world) {
      ++recognised;
      const Errors off = errors(*result.T_camera_world, truth);
      EXPECT_LT(off.rotation_rad, 1 * kDegree);
      EXPECT_LT(off.distance_m, 0.01 * truth.translation().norm());
    }
    const auto wrong =
        elsewhere.process(other.draw(truth, false), frame * kFrame_s, other.hand({}));
    EXPECT_EQ(wrong.state, WorldState::lost);
  }
  EXPECT_GE(recognised, 15);
}

TEST(World, IsRecognisedByACameraThatHasExposedAnew) {
  Tabletop table;
  WorldTracker tracker(table.camera, made_map(table));
  int recognised = 0;
  for (int frame = 0; frame < 20; ++frame) {
    const Eigen::Isometry3d truth = from(0.3 + 0.01 * frame, 0.55, 0.5);
    cv::Mat darker;
    table.draw(truth, false).convertTo(darker, -1, 0.5, 10);
    const auto result = tracker.process(darker, frame * kFrame_s, table.hand({}));
    if (!result.T_camera_world) continue;
    ++recognised;
    EXPECT_LT(errors(*result.T_camera_world, truth).rotation_rad, 1 * kDegree);
  }
  EXPECT_GE(recognised, 15);
}

TEST(World, MappingOnAThreadKeepsTheFrameToo) {
  Tabletop table;
  WorldTracker tracker(table.camera, Mapping::background);
  WorldResult result;
  for (int frame = 0; frame < kAway; ++frame) {
    const bool with_hand = frame < kHandUntil;
    const cv::Mat bgr = table.draw(orbit(frame), with_hand);
    result = tracker.process(bgr, frame * kFrame_s,
                             table.hand(with_hand ? std::optional(orbit(frame)) : std::nullopt));
  }
  ASSERT_TRUE(result.T_camera_world);
  EXPECT_LT(errors(*result.T_camera_world, orbit(kAway - 1)).rotation_rad, 1 * kDegree);
}

std::string fault_of(const std::string& bytes) {
  try {
    static_cast<void>(parse_map(bytes, "desk.map"));
  } catch (const io::Error& e) {
    return e.what();
  }
  return "";
}

TEST(MapFile, SaysWhatIsWrongWithIt) {
  Tabletop table;
  const test::TemporaryFolder folder;
  const std::string file = folder / "desk.map";
  write_map(file, made_map(table));
  std::ifstream stream(file, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(fault_of(whole), "");
  EXPECT_EQ(fault_of(""), "desk.map: is not a map of handyar");
  EXPECT_EQ(fault_of("{}\n"), "desk.map: is not a map of handyar");
  EXPECT_EQ(fault_of(whole.substr(0, whole.size() - 1)), "desk.map: ends within a picture");
  EXPECT_EQ(fault_of(whole + "x"), "desk.map: has more after its last picture");
  std::string changed = whole;
  changed.replace(changed.find("\"version\":1"), 11, "\"version\":9");
  EXPECT_EQ(fault_of(changed), "desk.map: \"version\" is not 1");
  changed = whole;
  changed.replace(changed.find("\"width_px\":640"), 14, "\"width_px\":960");
  EXPECT_EQ(fault_of(changed), "desk.map: a picture is no PNG of the camera's size");
  changed = whole.substr(0, whole.find('\n'));
  changed.replace(changed.find("\"width_px\":640"), 14, "\"width_px\":8192");
  changed.replace(changed.find("\"height_px\":480"), 15, "\"height_px\":8192");
  changed.replace(changed.find("\"keyframes\":["), 13, "\"keyframes\":[0,0,0,0,0,0,0,");
  EXPECT_EQ(fault_of(changed + '\n'),
            "desk.map: its keyframes are larger than 60 of 4096x2160 pixels");
  EXPECT_EQ(fault_of("{\"format\":\"handyar-map\",\"version\":1}\n"),
            "desk.map: key 'camera' not found");
  changed = whole;
  changed[changed.find("IDAT") + 20] ^= 1;
  testing::internal::CaptureStderr();
  EXPECT_EQ(fault_of(changed), "desk.map: a picture cannot be read");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "libpng's own words";
  EXPECT_THROW(static_cast<void>(read_map("/nowhere/desk.map")), io::Error);
}

const Eigen::Hyperplane<double, 3> kGround(Eigen::Vector3d::UnitZ(), 0.0);

Eigen::Isometry3d at(double x, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, 0, z));
}

/// A hand that is somewhere for a while; what happened last meanwhile.
struct Hand {
  Placement& placement;
  double time_s = 0;
  std::optional<PlacementEvent> stays(const std::optional<Eigen::Isometry3d>& T, double for_s) {
    std::optional<PlacementEvent> last;
    for (const double until_s = time_s + for_s; time_s < until_s; time_s += kFrame_s)
      if (const auto event = placement.update(time_s, kGround, T)) last = event;
    return last;
  }
  std::optional<PlacementEvent> goes(double from_x, double to_x, double z, double for_s) {
    std::optional<PlacementEvent> last;
    const double start_s = time_s;
    for (; time_s < start_s + for_s; time_s += kFrame_s) {
      const double x = from_x + (to_x - from_x) * (time_s - start_s) / for_s;
      if (const auto event = placement.update(time_s, kGround, at(x, z))) last = event;
    }
    return last;
  }
};

TEST(Placement, IsPickedUpCarriedAndPutDownWhereTheHandLies) {
  Placement placement(at(0, 0.02));
  Hand hand{placement};
  EXPECT_EQ(hand.stays(at(0, 0.02), 2), std::nullopt);  // it set the frame: it must leave first
  EXPECT_NEAR(placement.T_world_object().translation().z(), 0.02, 1e-9);  // on the hand
  EXPECT_EQ(hand.stays(at(0.3, 0.02), 1), std::nullopt);
  EXPECT_NEAR(placement.T_world_object().translation().z(), 0, 1e-9);  // on the table
  EXPECT_EQ(hand.stays(at(0, 0.02), 0.6), PlacementEvent::picked_up);
  EXPECT_EQ(hand.goes(0, 0.25, 0.1, 1), std::nullopt);
  EXPECT_TRUE(placement.carried());
  EXPECT_EQ(hand.stays(at(0.25, 0.03), 1), PlacementEvent::put_down);
  EXPECT_EQ(hand.stays(std::nullopt, 1), std::nullopt);
  EXPECT_NEAR((placement.T_world_object().translation() - Eigen::Vector3d(0.25, 0, 0)).norm(), 0,
              1e-3);
}

TEST(Placement, StaysWhereTheHandIsGone) {
  Placement placement(at(0, 0));
  Hand hand{placement};
  hand.stays(std::nullopt, 0.5);
  hand.stays(at(0.3, 0.1), 0.2);
  ASSERT_EQ(hand.stays(at(0, 0.05), 0.6), PlacementEvent::picked_up);
  hand.goes(0, 0.2, 0.1, 1);
  EXPECT_EQ(hand.stays(std::nullopt, 0.3), std::nullopt);  // a short loss changes nothing
  EXPECT_EQ(hand.stays(std::nullopt, 2), PlacementEvent::put_down);
  EXPECT_NEAR(placement.T_world_object().translation().x(), 0.2, 0.01);
  EXPECT_NEAR(placement.T_world_object().translation().z(), 0, 1e-9);
}

TEST(Placement, AHandThatPassesTakesNothing) {
  Placement placement(at(0, 0));
  Hand hand{placement};
  EXPECT_EQ(hand.goes(-0.4, 0.4, 0.05, 1.2), std::nullopt);
  EXPECT_FALSE(placement.carried());
}

}  // namespace
}  // namespace handyar::world
