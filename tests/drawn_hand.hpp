// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/LU>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "drawn_mask.hpp"
#include "handyar/image_view.hpp"
#include "synthetic_hand.hpp"

namespace handyar::test {

/// Where the hand plane is hand: strokes, and a convex palm.
class HandOutline {
 public:
  void add(const Capsule& stroke) { strokes_.push_back(stroke); }

  /// The palm: the corners of a convex polygon, counter-clockwise (x right, y up).
  template <std::size_t N>
  void add_palm(const std::array<Eigen::Vector2d, N>& corners) {
    for (std::size_t i = 0; i < N; ++i) {
      const Eigen::Vector2d a = corners[i], along = (corners[(i + 1) % N] - a).normalized();
      sides_.push_back({along.y(), -along.x(), along.y() * a.x() - along.x() * a.y()});
    }
  }

  /// Signed distance (m, negative inside) of a point of the hand plane.
  double distance_m(double x, double y) const {
    double palm = -1;  // the largest of the distances to its sides
    for (const Side& side : sides_) palm = std::max(palm, side.nx * x + side.ny * y - side.offset);
    double d = palm;
    for (const Capsule& stroke : strokes_) d = std::min(d, stroke.distance(x, y));
    return d;
  }

 private:
  struct Side {
    double nx, ny, offset;  ///< of the line nx x + ny y = offset, its normal outwards
  };
  std::vector<Side> sides_;
  std::vector<Capsule> strokes_;
};

/// A flat hand of round strokes with the average adult's fingertips: the ends of the fingers are
/// exactly the tips of `average_adult_hand()`.
struct DrawnHand {
  Layout layout = Layout::thumb_right;
  std::array<double, kFingerCount> fold{};  ///< 0: outstretched, 1: folded into the palm
  bool forearm = true;

  void make_fist() { fold.fill(1); }

  /// As it is with the thumb on the right, whatever the layout.
  HandOutline outline_thumb_right() const {
    using V = Eigen::Vector2d;
    const HandModel hand = average_adult_hand();
    const std::array<V, kFingerCount> knuckles = {
        V{.052, -.036}, {.024, -.002}, {.001, .004}, {-.022, -.002}, {-.040, -.018}};
    constexpr std::array<double, kFingerCount> kRadii = {.010, .0085, .0085, .008, .007};
    HandOutline outline;
    outline.add_palm<8>({V{.027, .010},
                         {.012, .018},
                         {-.013, .018},
                         {-.036, .003},
                         {-.043, -.020},
                         {-.030, -.092},
                         {.028, -.092},
                         {.036, -.022}});
    for (int f = 0; f < kFingerCount; ++f) {
      const V tip = hand.tips_m.col(f).head<2>(), knuckle = knuckles[f];
      const V end = tip - kRadii[f] * (tip - knuckle).normalized();
      if (fold[f] < 1) outline.add({knuckle, end + fold[f] * (knuckle - end), kRadii[f]});
    }
    if (fold[0] < 1) outline.add({V(.018, -.066), knuckles[0], .013});
    if (forearm) outline.add({V(-.001, -.09), V(-.001, -.6), .029});
    return outline;
  }

  /// A function of a point (m) of the hand plane: its signed distance (m, negative inside).
  auto distance_m() const {
    return [outline = outline_thumb_right(), side = layout == Layout::thumb_right ? 1.0 : -1.0](
               double x, double y) { return outline.distance_m(side * x, y); };
  }
};

using Bgr = std::array<std::uint8_t, 3>;
inline constexpr Bgr kSkinColor = {120, 150, 205};
inline constexpr Bgr kWallColor = {150, 140, 120};

/// A picture in memory, BGR, that shapes are painted on with smooth edges.
class Picture {
 public:
  Picture(int width_px, int height_px, const Bgr& color = kWallColor)
      : width_(width_px), height_(height_px), bytes_(std::size_t(width_px) * height_px * 3) {
    for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = color[i % 3];
  }
  int width() const { return width_; }
  int height() const { return height_; }
  std::uint8_t* at(int x, int y) { return &bytes_[(std::size_t(y) * width_ + x) * 3]; }
  const std::uint8_t* at(int x, int y) const { return &bytes_[(std::size_t(y) * width_ + x) * 3]; }
  ImageView view() const { return {bytes_.data(), width_, height_, width_ * 3, PixelFormat::bgr}; }

  /// Patches of grey, blue and green of about `size_px`, as a room behind the hand.
  void texture(int size_px, const std::string& name) {
    std::mt19937 rng = random_for(name);
    for (int y0 = 0; y0 < height_; y0 += size_px)
      for (int x0 = 0; x0 < width_; x0 += size_px) {
        const int grey = 60 + int(rng() % 120), blue = int(rng() % 50), green = int(rng() % 30);
        for (int y = y0; y < std::min(y0 + size_px, height_); ++y)
          for (int x = x0; x < std::min(x0 + size_px, width_); ++x) {
            at(x, y)[0] = std::uint8_t(grey + blue);
            at(x, y)[1] = std::uint8_t(grey + green);
            at(x, y)[2] = std::uint8_t(grey);
          }
      }
  }

  /// Paints where `distance` (negative inside, of pixel coordinates; about in units of
  /// 1 / `px_per_unit`) says: edges are the mean of 4x4 points.
  template <class Distance>
  void paint(const Distance& distance, double px_per_unit, const Bgr& color = kSkinColor) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const double d = distance(Eigen::Vector2d(x, y)) * px_per_unit;
        if (std::abs(d) > 2) {  // no edge is that near: the next pixels are as this one
          const int end =
              std::min(width_, x + 1 + static_cast<int>(std::min(0.4 * std::abs(d), 1e4)));
          if (d < 0)
            for (int i = x; i < end; ++i) std::copy_n(color.data(), 3, at(i, y));
          x = end - 1;
          continue;
        }
        int inside = 0;
        for (int k = 0; k < 16; ++k)
          inside +=
              distance(Eigen::Vector2d(x + (k % 4) / 4.0 - 0.375, y + (k / 4) / 4.0 - 0.375)) < 0;
        for (int c = 0; c < 3; ++c)
          at(x, y)[c] =
              static_cast<std::uint8_t>((at(x, y)[c] * (16 - inside) + color[c] * inside + 8) / 16);
      }
  }

  /// Paints the hand where a pinhole camera without distortion sees it.
  void paint(const DrawnHand& hand, const Camera& camera, const Eigen::Isometry3d& T_camera_hand,
             const Bgr& color = kSkinColor) {
    Eigen::Matrix3d K;
    K << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
    Eigen::Matrix3d plane;
    plane << T_camera_hand.linear().leftCols<2>(), T_camera_hand.translation();
    const Eigen::Matrix3d hand_px = (K * plane).inverse();
    std::array<double, 9> h;  // by rows
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data()) = hand_px;
    paint(
        [h, distance_m = hand.distance_m()](const Eigen::Vector2d& px) {
          const double x = px.x(), y = px.y(), w = h[6] * x + h[7] * y + h[8];
          return distance_m((h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w);
        },
        camera.fx_px / T_camera_hand.translation().z(), color);
  }

  /// Noise of about the given standard deviation, the same for the same `seed`.
  void add_noise(double sigma, std::uint32_t seed) {
    std::uint32_t x = seed * 2654435761u + 12345u;
    const double scale = sigma / 128;  // of the sum of three bytes
    for (std::uint8_t& b : bytes_) {
      x = x * 1664525u + 1013904223u;
      const int sum = int(x >> 24) + int(x >> 16 & 255) + int(x >> 8 & 255) - 382;
      b = static_cast<std::uint8_t>(std::clamp(int(b + scale * sum + 0.5), 0, 255));
    }
  }

  Picture mirrored() const {
    Picture m(width_, height_);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) std::copy_n(at(width_ - 1 - x, y), 3, m.at(x, y));
    return m;
  }

 private:
  int width_, height_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace handyar::test
