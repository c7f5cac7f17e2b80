// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "align/silhouette.hpp"
#include "handyar/image_view.hpp"
#include "synthetic_hand.hpp"

namespace handyar::test {

/// A hand of one colour: the mean figure, or another person's.
struct DrawnHand {
  Appearance appearance;
  HandState state;  ///< its pose is the film's
};

using Bgr = std::array<std::uint8_t, 3>;
inline constexpr Bgr kSkinColor = {120, 150, 205};
inline constexpr Bgr kWallColor = {150, 140, 120};

/// Rows of a picture, all of them unless told.
struct Rows {
  int first = 0, end = std::numeric_limits<int>::max();
};

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
  /// 1 / `px_per_unit`) says: a pixel at the edge by as much of it as lies inside.
  template <class Distance>
  void paint(const Distance& distance, double px_per_unit, const Bgr& color = kSkinColor,
             const Rows& rows = {}) {
    for (int y = rows.first; y < std::min(rows.end, height_); ++y)
      for (int x = 0; x < width_;) {
        const double d = distance(Eigen::Vector2d(x, y)) * px_per_unit;
        const double inside = std::clamp(0.5 - d, 0.0, 1.0);
        // What is far from the edge has neighbours on the same side.
        const int end =
            std::min(width_, x + 1 + static_cast<int>(std::min(0.4 * std::abs(d), 1e4)));
        for (; x < end; ++x)
          for (int c = 0; inside > 0 && c < 3; ++c)
            at(x, y)[c] =
                static_cast<std::uint8_t>((1 - inside) * at(x, y)[c] + inside * color[c] + 0.5);
      }
  }

  /// Paints the hand where a pinhole camera without distortion sees it.
  void paint(const DrawnHand& hand, const Camera& camera, const Eigen::Isometry3d& T_camera_hand,
             const Bgr& color = kSkinColor, const Rows& rows = {}) {
    HandState state = hand.state;
    state.T_camera_hand = T_camera_hand;
    const HandView view(camera, T_camera_hand.translation());
    const Silhouette silhouette(hand.appearance, state, view);
    paint(
        [&](const Eigen::Vector2d& px) {
          const Eigen::Vector3d ray = view.R_view_camera() * camera.unproject(px).homogeneous();
          return silhouette.distance_px((view.f_px() * ray.hnormalized()).cast<float>());
        },
        1, color, rows);
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
