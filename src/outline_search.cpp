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

constexpr float kPi = std::numbers::pi_v<float>;
constexpr int kHandDirections = 30;   // of a whole turn
constexpr float kFingerWidth_px = 4;  // of a level: where templates are slid
constexpr float kLevelRatio = 1.19f;
constexpr int kLeastSide_px = 36;      // of the smallest level
constexpr float kSpacing_m = 0.0085f;  // of features along the outline
constexpr int kMargin = 12;            // pixels around a level: hands may be cut by the border
constexpr int kMost = 63;              // of a map: four together fit a byte
constexpr int kBeyond = 6;             // what the margin holds: about what a picture holds
constexpr int kHalfStrength = 12;      // difference of two neighbours that counts for a half
constexpr int kTableReach = 63;        // of the table of edges; larger differences are halved
constexpr int kBlock = 16;             // places that are added up together

struct Bone {
  Eigen::Vector2f from, to;
  float radius;

  float distance(const Eigen::Vector2f& p) const {
    const Eigen::Vector2f along = to - from, d = p - from;
    const float s = std::clamp(d.dot(along) / along.squaredNorm(), 0.0f, 1.0f);
    return (d - s * along).norm() - radius;
  }
};

/// The hand as bones with flesh around them: fingers, what carries them in the palm, and webs.
std::vector<Bone> bones_of(const HandShape& hand) {
  constexpr std::array<float, kFingerCount> kRadius_m = {0.010f, 0.0085f, 0.0088f, 0.0083f,
                                                         0.0073f};
  constexpr float kWebRadius_m = 0.008f;
  const auto wrist = [](const Eigen::Vector2f& p) {
    return Eigen::Vector2f(0.45f * p.x(), -0.085f);
  };
  std::vector<Bone> bones;
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f base = hand.finger_base(f), tip = hand.tips[f];
    bones.push_back({base, tip - kRadius_m[f] * (tip - base).normalized(), kRadius_m[f]});
  }
  for (int f = 0; f < kFingerCount; ++f)
    bones.push_back({wrist(bones[f].from), bones[f].from, 1.3f * kRadius_m[f]});
  for (const Eigen::Vector2f& valley : hand.valleys) {
    const Eigen::Vector2f down = (wrist(valley) - valley).normalized();
    bones.push_back({wrist(valley), valley + kWebRadius_m * down, kWebRadius_m});
  }
  return bones;
}

/// Adds up what lies under four features; reads and writes whole blocks.
HANDYAR_VECTORISED void add_four(const std::uint8_t* a, const std::uint8_t* b,
                                 const std::uint8_t* c, const std::uint8_t* d, int blocks,
                                 std::uint16_t* __restrict sum) {
  for (int k = 0; k < blocks * kBlock; ++k)
    sum[k] =
        static_cast<std::uint16_t>(sum[k] + static_cast<std::uint8_t>(a[k] + b[k] + c[k] + d[k]));
}

}  // namespace

OutlineSearch::OutlineSearch(const OutlineSearchConfig& config)
    : config_(config), hand_(average_hand_shape()) {
  config_.proposals = std::clamp(config_.proposals, 0, kMaxProposals);
  config_.directions_per_frame = std::clamp(config_.directions_per_frame, 1, kHandDirections);
  edge_table_.resize((2 * kTableReach + 1) * (2 * kTableReach + 1));
  for (int gy = -kTableReach, k = 0; gy <= kTableReach; ++gy)
    for (int gx = -kTableReach; gx <= kTableReach; ++gx, ++k) {
      const float strength = std::hypot(static_cast<float>(gx), static_cast<float>(gy));
      const float share = std::min(1.0f, 1.2f * strength / (strength + kHalfStrength));
      float turns =
          std::atan2(static_cast<float>(gy), static_cast<float>(gx)) / kPi * kEdgeDirections;
      if (turns < 0) turns += kEdgeDirections;
      const float rest = turns - std::floor(turns);
      edge_table_[k] = {static_cast<std::uint8_t>(static_cast<int>(turns) % kEdgeDirections),
                        static_cast<std::uint8_t>(kMost * share * (1 - rest)),
                        static_cast<std::uint8_t>(kMost * share * rest),
                        static_cast<std::uint8_t>(kMost * (1 - share))};
    }
  draw_outline();
  make_templates();
}

void OutlineSearch::draw_outline() {
  const std::vector<Bone> bones = bones_of(hand_);
  const auto add = [&](int bone, const Eigen::Vector2f& center, const Eigen::Vector2f& normal) {
    constexpr float kWrist_m = -0.070f, kTouch_m = 0.0005f;
    const Eigen::Vector2f p = center + bones[bone].radius * normal;
    const bool hidden = std::ranges::any_of(
        bones, [&](const Bone& other) { return other.distance(p) < -kTouch_m; });
    if (!hidden && p.y() > kWrist_m) outline_.push_back({p, normal, bone});
  };
  for (int b = 0; b < static_cast<int>(bones.size()); ++b) {
    const float length = (bones[b].to - bones[b].from).norm();
    const Eigen::Vector2f along = (bones[b].to - bones[b].from) / length;
    const Eigen::Vector2f across(-along.y(), along.x());
    for (const float side : {-1.0f, 1.0f})
      for (float s = 0; s < length; s += kSpacing_m)
        add(b, bones[b].from + s * along, side * across);
    const int steps = static_cast<int>(kPi * bones[b].radius / kSpacing_m);
    for (int k = 1; k < steps; ++k) {
      const float angle = kPi * static_cast<float>(k) / static_cast<float>(steps);
      add(b, bones[b].to, std::cos(angle) * across + std::sin(angle) * along);
    }
  }
}

void OutlineSearch::make_templates() {
  std::vector<Eigen::Vector2f> inside_m;
  for (int f = 0; f < kFingerCount; ++f)
    for (const float s : {0.25f, 0.5f, 0.75f})
      inside_m.push_back(hand_.finger_base(f) + s * (hand_.tips[f] - hand_.finger_base(f)));
  for (const float y : {-0.060f, -0.040f, -0.020f})
    for (const float x : {-0.022f, 0.0f, 0.022f}) inside_m.emplace_back(x, y);

  const Eigen::Vector2f foreshortened[] = {{1, 1}, {0.75f, 1}, {1, 0.75f}};
  for (int k = 0; k < kHandDirections; ++k)
    for (const Layout layout : {Layout::thumb_right, Layout::thumb_left})
      for (Eigen::Vector2f scale : foreshortened) {
        Template t;
        t.layout = layout;
        scale *= kFingerWidth_px / hand_.finger_width;
        if (layout == Layout::thumb_left) scale.x() = -scale.x();
        const float angle = 2 * kPi * static_cast<float>(k) / kHandDirections;
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
        for (const OutlinePoint& p : outline_) add(p.at_m, nearest_direction(normals * p.normal));
        for (const Eigen::Vector2f& p_m : inside_m) add(p_m, kEdgeDirections);
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

void OutlineSearch::reserve(int max_pixels, int max_side) {
  const float scale = static_cast<float>(config_.least_finger_bins) / kFingerWidth_px;
  const auto largest = static_cast<std::size_t>(
      static_cast<float>(max_pixels) / (scale * scale) +
      4 * (kMargin + 1) * (static_cast<float>(max_side) / scale + kMargin + 1));
  colors_.resize(3 * largest);
  edges_.resize(kMaps * largest);
  maps_.resize(kMaps * largest + 2 * kBlock);  // whole blocks are read
  highest_.resize(max_side + 4 * kMargin);
  sums_.resize(max_side / 2 + 2 * kMargin + 2 * kBlock);
  offsets_.resize(templates_.empty() ? 0 : 2 * templates_[0].features.size());
}

OutlineSearch::Edge OutlineSearch::edge(int gx, int gy) const noexcept {
  while (std::max(std::abs(gx), std::abs(gy)) > kTableReach) {
    gx /= 2;
    gy /= 2;
  }
  return edge_table_[(gy + kTableReach) * (2 * kTableReach + 1) + gx + kTableReach];
}

int OutlineSearch::nearest_direction(const Eigen::Vector2f& normal) const noexcept {
  const Eigen::Vector2f g = normal * (kTableReach / normal.cwiseAbs().maxCoeff());
  const Edge e = edge(static_cast<int>(g.x()), static_cast<int>(g.y()));
  return e.next_strength > e.strength ? (e.direction + 1) % kEdgeDirections : e.direction;
}

/// Mean luma, yellowness and redness.
void OutlineSearch::read_colors(const BinImage& image, int width, int height,
                                float scale) noexcept {
  std::uint8_t* color = colors_.data();
  for (int v = 0; v < height; ++v) {
    const int y0 = static_cast<int>(static_cast<float>(v) * scale);
    const int y1 = std::max(y0 + 1, static_cast<int>(static_cast<float>(v + 1) * scale));
    for (int u = 0; u < width; ++u, color += 3) {
      const int x0 = static_cast<int>(static_cast<float>(u) * scale);
      const int x1 = std::max(x0 + 1, static_cast<int>(static_cast<float>(u + 1) * scale));
      int luma = 0, yellowness = 0, redness = 0;
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const ColorBin b = image.bins[static_cast<std::size_t>(y) * image.width + x];
          luma += b >> 10;
          yellowness += b >> 5 & 31;
          redness += b & 31;
        }
      const int count = (x1 - x0) * (y1 - y0);
      color[0] = static_cast<std::uint8_t>(8 * luma / count);
      color[1] = static_cast<std::uint8_t>(2 * yellowness / count);
      color[2] = static_cast<std::uint8_t>(2 * redness / count);
    }
  }
}

/// Leaves the maps of the image at 1/scale of its size: where an edge of each direction is near,
/// and where none is.
void OutlineSearch::read_level(const BinImage& image, float scale) noexcept {
  Level& level = level_;
  level.scale = scale;
  const int w = static_cast<int>(static_cast<float>(image.width) / level.scale);
  const int h = static_cast<int>(static_cast<float>(image.height) / level.scale);
  level.width = (w + 2 * kMargin + 1) & ~1;
  level.height = h + 2 * kMargin;
  read_colors(image, w, h, level.scale);
  const int size = level.width * level.height;
  std::fill_n(edges_.begin(), kEdgeDirections * size, std::uint8_t{kBeyond});
  std::fill_n(edges_.begin() + kEdgeDirections * size, size, std::uint8_t{kMost - kBeyond});
  for (int v = 0; v < h; ++v) {
    const int row = (v + kMargin) * level.width + kMargin;
    for (int m = 0; m < kEdgeDirections; ++m)
      std::fill_n(edges_.begin() + m * size + row, w, std::uint8_t{0});
    if (v == 0 || v + 1 == h) continue;
    const std::uint8_t* p = colors_.data() + 3 * v * w;
    for (int u = 1; u + 1 < w; ++u) {
      p += 3;
      int strongest = -1, gx = 0, gy = 0;
      for (int c = 0; c < 3; ++c) {
        const int dx = p[c + 3] - p[c - 3], dy = p[c + 3 * w] - p[c - 3 * w];
        if (dx * dx + dy * dy <= strongest) continue;
        strongest = dx * dx + dy * dy;
        gx = dx;
        gy = dy;
      }
      const Edge e = edge(gx, gy);
      std::uint8_t* to = edges_.data() + row + u;
      to[e.direction * size] = e.strength;
      to[(e.direction + 1) % kEdgeDirections * size] = e.next_strength;
      to[kEdgeDirections * size] = e.calm;
    }
  }
  for (int m = 0; m < kMaps; ++m) spread(m);
}

/// Edges reach one pixel further on every side, for hands differ; columns are sorted.
void OutlineSearch::spread(int map) noexcept {
  const Level& level = level_;
  const int w = level.width;
  const std::uint8_t* from = edges_.data() + map * w * level.height;
  std::uint8_t* __restrict even = maps_.data() + level.offset(map, 0, 0);
  std::uint8_t* __restrict odd = maps_.data() + level.offset(map, 1, 0);
  std::uint8_t* __restrict high = highest_.data() + 1;
  for (int y = 0; y < level.height; ++y, even += w / 2, odd += w / 2) {
    const std::uint8_t* at = from + y * w;
    if (map == kEdgeDirections) {
      for (int k = 0; k < w / 2; ++k) even[k] = at[2 * k];
      for (int k = 0; k < w / 2; ++k) odd[k] = at[2 * k + 1];
      continue;
    }
    const std::uint8_t *above = from + std::max(y - 1, 0) * w,
                       *below = from + std::min(y + 1, level.height - 1) * w;
    for (int x = 0; x < w; ++x) high[x] = std::max(at[x], std::max(above[x], below[x]));
    high[-1] = high[0];
    high[w] = high[w - 1];
    for (int k = 0; k < w / 2; ++k)
      even[k] = std::max(high[2 * k], std::max(high[2 * k - 1], high[2 * k + 1]));
    for (int k = 0; k < w / 2; ++k)
      odd[k] = std::max(high[2 * k + 1], std::max(high[2 * k], high[2 * k + 2]));
  }
}

/// Adds up what lies under the features at every second place of every second row.
void OutlineSearch::slide(const Template& t) noexcept {
  const Level& level = level_;
  const int x0 = (t.left + 1) & ~1, count = (level.width - t.right - x0) / 2;
  if (count <= 0) return;
  const int features = static_cast<int>(t.features.size()), blocks = (count + kBlock - 1) / kBlock;
  for (int k = 0; k < features; ++k)
    offsets_[k] = level.offset(t.features[k].map, x0 + t.features[k].dx, t.features[k].dy);
  // Places that look hopeless after a part of the features are left.
  const int early = features / 3 / 4 * 4;
  const float worst = proposal_count_ == config_.proposals
                          ? static_cast<float>(proposals_[proposal_count_ - 1].score)
                          : 0.0f;
  const float enough = 0.95f * worst * static_cast<float>(early) / static_cast<float>(features);
  std::uint16_t* sum = sums_.data();
  for (int y = t.up; y + t.down < level.height; y += 2) {
    const std::uint8_t* at = maps_.data() + y * level.row_size();
    std::fill_n(sum, blocks * kBlock, std::uint16_t{0});
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
  const float scale = level_.scale;
  const Eigen::Matrix2f linear = scale * t.px_per_m;
  const Eigen::Vector2f origin = (scale * (at_px.array() - kMargin + 0.5f) - 0.5f).matrix();
  Proposal made{hand_, {}, score};
  made.shape.layout = t.layout;
  for (auto& p : made.shape.tips) p = linear * p + origin;
  made.shape.image_hand << linear, origin;
  made.slid_tips = made.shape.tips;
  // One place, one proposal: the better one.
  const float near = 0.15f * kFingerCount * (made.shape.tips[0] - made.shape.tips[4]).norm();
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

/// Moves the hand as a whole and then each finger by itself to where edges lie under most of its
/// outline.
void OutlineSearch::align(HandShape& shape) const noexcept {
  const Level& level = level_;
  const auto under = [&](const Eigen::Vector2f& p, const Eigen::Vector2f& normal) {
    const int x = static_cast<int>(p.x() + 0.5f), y = static_cast<int>(p.y() + 0.5f);
    if (x < 0 || y < 0 || x >= level.width || y >= level.height) return kBeyond;
    return int{maps_[level.offset(nearest_direction(normal), x, y)]};
  };
  Eigen::Matrix<float, 2, 3> map = shape.image_hand / level.scale;
  map.col(2).array() += 0.5f / level.scale - 0.5f + kMargin;
  const auto score = [&](const Eigen::Matrix<float, 2, 3>& m) {
    const Eigen::Matrix2f linear = m.leftCols<2>(), normals = linear.inverse().transpose();
    int sum = 0;
    for (const OutlinePoint& p : outline_)
      sum += under(linear * p.at_m + m.col(2), normals * p.normal);
    return sum;
  };
  int best = score(map);
  const Eigen::Vector2f middle_m(0, 0.01f);
  for (const float step : {1.0f, 0.5f, 0.25f})
    for (int k = 0; k < 12; ++k) {
      const float by = k % 2 == 0 ? step : -step, px = 2 * by, share = 0.1f * by;
      Eigen::Matrix<float, 2, 3> changed = map;
      Eigen::Vector2f center = map * middle_m.homogeneous();
      switch (k / 2) {
        case 0:
          center.x() += px;
          break;
        case 1:
          center.y() += px;
          break;
        case 2:
          changed.leftCols<2>() = Eigen::Rotation2Df(share) * map.leftCols<2>();
          break;
        case 3:
          changed.leftCols<2>() *= 1 + share;
          break;
        case 4:
          changed.col(0) *= 1 + share;
          break;
        case 5:
          changed.col(1) *= 1 + share;
          break;
      }
      changed.col(2) = center - changed.leftCols<2>() * middle_m;
      const int sum = score(changed);
      if (sum <= best) continue;
      best = sum;
      map = changed;
    }

  const Eigen::Matrix2f linear = map.leftCols<2>(), normals = linear.inverse().transpose();
  const auto to_image = [&](const Eigen::Vector2f& p_m) -> Eigen::Vector2f {
    return level.scale * ((linear * p_m + map.col(2)).array() - kMargin + 0.5f) - 0.5f;
  };
  for (int k = 0; k < kValleyCount; ++k) shape.valleys[k] = to_image(hand_.valleys[k]);
  for (int f = 0; f < kFingerCount; ++f) {
    const Eigen::Vector2f base = hand_.finger_base(f), along = (hand_.tips[f] - base).normalized();
    int highest = -1;
    for (const float turn_rad : {0.0f, 0.07f, -0.07f, 0.14f, -0.14f, 0.21f, -0.21f, 0.28f, -0.28f})
      for (const float length : {1.0f, 0.93f, 1.07f, 0.86f, 1.14f}) {
        const Eigen::Matrix2f turn = Eigen::Rotation2Df(turn_rad).toRotationMatrix();
        const auto moved = [&](const Eigen::Vector2f& p) -> Eigen::Vector2f {
          const Eigen::Vector2f d = p - base;
          return base + turn * (d + (length - 1) * d.dot(along) * along);
        };
        int sum = 0;
        for (const OutlinePoint& p : outline_)
          if (p.bone == f)
            sum += under(linear * moved(p.at_m) + map.col(2), normals * (turn * p.normal));
        if (sum <= highest) continue;
        highest = sum;
        shape.tips[f] = to_image(moved(hand_.tips[f]));
      }
  }
  shape.image_hand << level.scale * linear, to_image(Eigen::Vector2f::Zero());
  if (shape.layout == Layout::thumb_left) shape.image_hand.col(0) *= -1;
  shape.finger_width = hand_.finger_width * level.scale * std::sqrt(std::abs(linear.determinant()));
}

std::span<const HandShape> OutlineSearch::find(const BinImage& image) noexcept {
  proposal_count_ = 0;
  if (config_.proposals == 0) return {};
  const int per_direction = static_cast<int>(templates_.size()) / kHandDirections;
  const int apart = kHandDirections / config_.directions_per_frame;
  for (float scale = static_cast<float>(config_.least_finger_bins) / kFingerWidth_px;
       static_cast<float>(std::min(image.width, image.height)) >= scale * kLeastSide_px;
       scale *= kLevelRatio) {
    read_level(image, scale);
    for (int i = 0; i < config_.directions_per_frame; ++i) {
      const int direction = (turn_ + i * apart) % kHandDirections;
      for (int j = 0; j < per_direction; ++j) slide(templates_[direction * per_direction + j]);
    }
    // While the level is at hand.
    for (int k = 0; k < proposal_count_; ++k) {
      if (!proposals_[k].aligned) align(proposals_[k].shape);
      proposals_[k].aligned = true;
    }
  }
  turn_ = (turn_ + 1) % apart;
  for (int k = 0; k < proposal_count_; ++k) found_[k] = proposals_[k].shape;
  return {found_.data(), static_cast<std::size_t>(proposal_count_)};
}

}  // namespace handyar
