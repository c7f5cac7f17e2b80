// SPDX-License-Identifier: MIT
#include "handyar/outline_search.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vectorised.hpp"

namespace handyar {
namespace {

constexpr int kHandDirections = 30;   // of a whole turn
constexpr float kFingerWidth_px = 4;  // of the maps: where templates are slid
constexpr float kLevelRatio = 1.19f;
constexpr int kLeastSide_px = 36;  // of the smallest maps, without their margin

/// Adds up what lies under four features; reads and writes whole blocks.
HANDYAR_VECTORISED void add_four(const std::uint8_t* a, const std::uint8_t* b,
                                 const std::uint8_t* c, const std::uint8_t* d, int blocks,
                                 std::uint16_t* __restrict sum) {
  for (int k = 0; k < blocks * EdgeMaps::kBlock; ++k)
    sum[k] =
        static_cast<std::uint16_t>(sum[k] + static_cast<std::uint8_t>(a[k] + b[k] + c[k] + d[k]));
}

}  // namespace

OutlineSearch::OutlineSearch(const OutlineSearchConfig& config) : config_(config) {
  config_.proposals = std::clamp(config_.proposals, 0, kMaxProposals);
  config_.directions_per_frame = std::clamp(config_.directions_per_frame, 1, kHandDirections);
  make_templates();
}

void OutlineSearch::make_templates() {
  const HandShape& hand = average_.hand_m();
  std::vector<Eigen::Vector2f> inside_m;
  for (int f = 0; f < kFingerCount; ++f)
    for (const float s : {0.25f, 0.5f, 0.75f})
      inside_m.push_back(hand.finger_base(f) + s * (hand.tips[f] - hand.finger_base(f)));
  for (const float y : {-0.060f, -0.040f, -0.020f})
    for (const float x : {-0.022f, 0.0f, 0.022f}) inside_m.emplace_back(x, y);

  const Eigen::Vector2f foreshortened[] = {{1, 1}, {0.75f, 1}, {1, 0.75f}};
  for (int k = 0; k < kHandDirections; ++k)
    for (const Layout layout : {Layout::thumb_right, Layout::thumb_left})
      for (Eigen::Vector2f scale : foreshortened) {
        Template t;
        t.layout = layout;
        scale *= kFingerWidth_px / hand.finger_width;
        if (layout == Layout::thumb_left) scale.x() = -scale.x();
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / kHandDirections;
        Eigen::Matrix2f axes;  // the hand's y points up, the image's down
        axes << std::cos(angle), std::sin(angle), std::sin(angle), -std::cos(angle);
        t.px_per_m = axes * scale.asDiagonal();
        const Eigen::Matrix2f normals = t.px_per_m.inverse().transpose();
        const auto add = [&](const Eigen::Vector2f& p_m, int map) {
          const Eigen::Vector2i p = (t.px_per_m * p_m).array().round().cast<int>();
          t.left = std::max(t.left, -p.x());
          t.right = std::max(t.right, p.x());
          t.up = std::max(t.up, -p.y());
          t.down = std::max(t.down, p.y());
          t.features.push_back({static_cast<std::int8_t>(p.x()), static_cast<std::int8_t>(p.y()),
                                static_cast<std::uint8_t>(map)});
        };
        for (const HandOutline::Point& p : average_.points())
          add(p.at_m, edges_.nearest_direction(normals * p.normal));
        for (const Eigen::Vector2f& p_m : inside_m) add(p_m, EdgeMaps::kCalm);
        // In an order that soon covers the whole hand, and by fours.
        std::vector<Feature> mixed;
        constexpr std::size_t kStride = 5;
        for (std::size_t first = 0; first < kStride; ++first)
          for (std::size_t i = first; i < t.features.size(); i += kStride)
            mixed.push_back(t.features[i]);
        mixed.resize(mixed.size() / 4 * 4);
        t.features = std::move(mixed);
        templates_.push_back(std::move(t));
      }
}

float OutlineSearch::least_scale() const noexcept {
  return static_cast<float>(config_.least_finger_bins) / kFingerWidth_px;
}

void OutlineSearch::reserve(int max_pixels, int max_side) {
  edges_.reserve(max_pixels, max_side, least_scale());
  sums_.resize(max_side + 2 * EdgeMaps::kBlock);
  offsets_.resize(templates_.empty() ? 0 : 2 * templates_[0].features.size());
}

/// Adds up what lies under the features at every second place of every second row.
void OutlineSearch::slide(const Template& t) noexcept {
  const int x0 = (t.left + 1) & ~1, count = (edges_.width() - t.right - x0) / 2;
  if (count <= 0) return;
  const int features = static_cast<int>(t.features.size()),
            blocks = (count + EdgeMaps::kBlock - 1) / EdgeMaps::kBlock;
  for (int k = 0; k < features; ++k)
    offsets_[k] = edges_.offset(t.features[k].map, x0 + t.features[k].dx, t.features[k].dy);
  // Places that look hopeless after a part of the features are left.
  const int early = features / 3 / 4 * 4;
  const float worst = proposal_count_ == config_.proposals
                          ? static_cast<float>(proposals_[proposal_count_ - 1].score)
                          : 0.0f;
  const float enough = 0.95f * worst * static_cast<float>(early) / static_cast<float>(features);
  std::uint16_t* sum = sums_.data();
  for (int y = t.up; y + t.down < edges_.height(); y += 2) {
    const std::uint8_t* at = edges_.data() + y * edges_.row_size();
    std::fill_n(sum, blocks * EdgeMaps::kBlock, std::uint16_t{0});
    const auto add = [&](int from, int to) {
      for (const int* k = offsets_.data() + from; k < offsets_.data() + to; k += 4)
        add_four(at + k[0], at + k[1], at + k[2], at + k[3], blocks, sum);
      std::uint16_t highest = 0;
      for (int i = 0; i < count; ++i) highest = std::max(highest, sum[i]);
      return highest;
    };
    if (add(0, early) < enough) continue;
    const int highest = add(early, features);
    if (proposal_count_ == config_.proposals && highest <= proposals_[proposal_count_ - 1].score)
      continue;
    const int best = static_cast<int>(std::find(sum, sum + count, highest) - sum);
    propose(t, Eigen::Vector2f(float(x0 + 2 * best), float(y)), highest);
  }
}

void OutlineSearch::propose(const Template& t, const Eigen::Vector2f& at_px, int score) noexcept {
  HandOutline::AffineMap maps_hand;
  maps_hand << t.px_per_m, at_px;
  Proposal made{.image_hand = edges_.to_image(maps_hand),
                .layout = t.layout,
                .slid_tips = {},
                .score = score,
                .shape = average_.hand_m()};
  for (int f = 0; f < kFingerCount; ++f)
    made.slid_tips[f] = made.image_hand * average_.hand_m().tips[f].homogeneous();
  // One place, one proposal: the better one.
  const float near = 0.15f * kFingerCount * (made.slid_tips[0] - made.slid_tips[4]).norm();
  int at = proposal_count_;
  for (int k = 0; k < proposal_count_ && at == proposal_count_; ++k) {
    float distance = 0;
    for (int f = 0; f < kFingerCount; ++f)
      distance += (made.slid_tips[f] - proposals_[k].slid_tips[f]).norm();
    if (distance > near) continue;
    if (proposals_[k].score >= score) return;
    at = k;
  }
  if (at == config_.proposals)
    --at;
  else if (at == proposal_count_)
    ++proposal_count_;
  for (; at > 0 && proposals_[at - 1].score < score; --at) proposals_[at] = proposals_[at - 1];
  proposals_[at] = made;
}

HandShape OutlineSearch::align(const Proposal& slid) const noexcept {
  constexpr std::array<float, 3> kSteps{1.0f, 0.5f, 0.25f};
  constexpr std::array<float, 9> kTurns_rad{0.0f,  0.07f,  -0.07f, 0.14f, -0.14f,
                                            0.21f, -0.21f, 0.28f,  -0.28f};
  constexpr std::array<float, 5> kLengths{1.0f, 0.93f, 1.07f, 0.86f, 1.14f};
  HandOutline::AffineMap maps_hand = edges_.from_image(slid.image_hand);
  average_.align(edges_, kSteps, maps_hand);
  HandShape hand = average_.hand_m();
  for (int f = 0; f < kFingerCount; ++f)
    hand.tips[f] = average_.bend(edges_, maps_hand, f, {kTurns_rad, kLengths}).tip_m;
  return hand.laid(edges_.to_image(maps_hand), slid.layout);
}

std::span<const HandShape> OutlineSearch::find(const BinView& image) noexcept {
  proposal_count_ = 0;
  if (config_.proposals == 0) return {};
  const int per_direction = static_cast<int>(templates_.size()) / kHandDirections;
  const int apart = kHandDirections / config_.directions_per_frame;
  for (float scale = least_scale();
       static_cast<float>(std::min(image.width, image.height)) >= scale * kLeastSide_px;
       scale *= kLevelRatio) {
    if (!edges_.read(image, scale)) break;
    for (int i = 0; i < config_.directions_per_frame; ++i) {
      const int direction = (turn_ + i * apart) % kHandDirections;
      for (int j = 0; j < per_direction; ++j) slide(templates_[direction * per_direction + j]);
    }
    // While the maps are at hand.
    for (int k = 0; k < proposal_count_; ++k) {
      if (!proposals_[k].aligned) proposals_[k].shape = align(proposals_[k]);
      proposals_[k].aligned = true;
    }
  }
  turn_ = (turn_ + 1) % apart;
  for (int k = 0; k < proposal_count_; ++k) found_[k] = proposals_[k].shape;
  return proposals();
}

float OutlineSearch::follow(const BinView& image, HandShape& hand) noexcept {
  // Roughly, with as much reach as a hand moves from frame to frame, and then finely.
  constexpr int kReach_px = 4;
  constexpr std::array<float, 8> kRough{2, 2, 1, 1, 0.5f, 0.5f, 0.25f, 0.25f};
  constexpr std::array<float, 6> kFine{1, 1, 0.5f, 0.5f, 0.25f, 0.25f};
  constexpr std::array<float, 5> kTurns_rad{0.0f, 0.05f, -0.05f, 0.1f, -0.1f};
  constexpr std::array<float, 5> kLengths{1.0f, 0.96f, 1.04f, 0.92f, 1.08f};
  own_.draw(hand.in_hand_plane());
  HandOutline::AffineMap image_hand = hand.image_thumb_right(), maps_hand;
  const float rough_scale = hand.finger_width / kFingerWidth_px;
  const auto align = [&](float scale, int reach, std::span<const float> steps) {
    if (!edges_.read(image, std::max(scale, least_scale()))) return false;
    maps_hand = edges_.from_image(image_hand);
    own_.shift(edges_, reach, maps_hand);
    own_.align(edges_, steps, maps_hand);
    image_hand = edges_.to_image(maps_hand);
    return true;
  };
  if (!align(rough_scale, kReach_px, kRough) || !align(rough_scale / 2, 0, kFine)) return 0;
  HandShape bent = own_.hand_m();
  for (int f = 0; f < kFingerCount; ++f) {
    const auto finger = own_.bend(edges_, maps_hand, f, {kTurns_rad, kLengths});
    if (finger.support < config_.least_finger_support) return 0;
    bent.tips[f] = finger.tip_m;
  }
  hand = bent.laid(image_hand, hand.layout);
  return own_.support(edges_, maps_hand);
}

}  // namespace handyar
