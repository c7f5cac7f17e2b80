// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "align/silhouette.hpp"
#include "track/tracker_state.hpp"

namespace handyar {
namespace {

/// A convex polygon is filled row by row between its leftmost and rightmost crossing.
class PolygonFiller {
 public:
  PolygonFiller(std::uint8_t* pixels, int width, int height)
      : pixels_(pixels), width_(width), height_(height) {}

  void fill(const Eigen::Vector2f* corners, int count) const {
    float top = std::numeric_limits<float>::max(), bottom = -top;
    for (int i = 0; i < count; ++i) {
      top = std::min(top, corners[i].y());
      bottom = std::max(bottom, corners[i].y());
    }
    const int last = last_to(bottom, height_);
    for (int y = first_from(top, height_); y <= last; ++y) fill_row(corners, count, y);
  }

 private:
  void fill_row(const Eigen::Vector2f* corners, int count, int y) const {
    float left = std::numeric_limits<float>::max(), right = std::numeric_limits<float>::lowest();
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2f &a = corners[i], &b = corners[(i + 1) % count];
      if ((a.y() > y) == (b.y() > y)) continue;
      const float x = a.x() + (y - a.y()) * (b.x() - a.x()) / (b.y() - a.y());
      left = std::min(left, x);
      right = std::max(right, x);
    }
    // Where it only touches the row nothing crosses it.
    const int from = first_from(left, width_), to = last_to(right, width_);
    if (from <= to) std::fill(pixels_ + y * width_ + from, pixels_ + y * width_ + to + 1, 255);
  }

  /// The first and the last pixel of `count` that lie between; none where it ends before it begins.
  static int first_from(float from, int count) {
    return static_cast<int>(std::ceil(std::clamp(from, 0.0f, static_cast<float>(count))));
  }
  static int last_to(float to, int count) {
    return static_cast<int>(std::floor(std::clamp(to, -1.0f, static_cast<float>(count - 1))));
  }

  std::uint8_t* pixels_;
  int width_, height_;
};

}  // namespace

HandMask HandTracker::Impl::draw_mask() noexcept {
  if (!in_view()) return {};
  const Hypothesis& best = *in_view();
  const HandView view(camera, best.alignment.state.T_camera_hand.translation());
  const Silhouette silhouette(best.appearance, best.alignment.state, view);
  if (!silhouette.valid()) return {};
  mask.assign(static_cast<std::size_t>(camera.width_px) * camera.height_px, 0);
  const PolygonFiller filler(mask.data(), camera.width_px, camera.height_px);
  const auto boundary = static_cast<float>(best.alignment.state.boundary_px);
  silhouette.each_convex_piece(boundary, [&](std::span<const Eigen::Vector2f> view_px) {
    std::array<Eigen::Vector2f, Silhouette::kMostCorners> corners{};
    for (std::size_t i = 0; i < view_px.size(); ++i) corners[i] = view.to_frame(view_px[i]);
    filler.fill(corners.data(), static_cast<int>(view_px.size()));
  });
  return {mask.data(), camera.width_px, camera.height_px, camera.width_px, 0, 0, 1};
}

}  // namespace handyar
