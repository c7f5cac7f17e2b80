// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "handyar/color_bins.hpp"
#include "handyar/hand_shape.hpp"

namespace handyar {

struct OutlineSearchConfig {
  int directions_per_frame = 5;    ///< of 30 in which a hand may point; they take turns
  int proposals = 5;               ///< places a frame that are worth a closer look, at most 16
  double least_finger_bins = 6.5;  ///< width of the thinnest fingers that are looked for
};

/// Where hands may be, by their outline alone, whatever their colours. The outline of the average
/// hand, turned, mirrored, foreshortened and at many sizes, is slid over the directions of the
/// picture's edges, among which a faint one counts nearly as much as a strong one; inside the hand
/// there should be few. After Hinterstoisser et al., "Gradient Response Maps for Real-Time
/// Detection of Textureless Objects" (PAMI 2012). The best places are then aligned with the edges,
/// first the whole hand, then finger by finger.
class OutlineSearch {
 public:
  explicit OutlineSearch(const OutlineSearchConfig& config = {});

  /// Room for images of up to `max_pixels` bins and `max_side` bins a side.
  void reserve(int max_pixels, int max_side);

  /// Begins with the first of the directions again.
  void reset() noexcept { turn_ = 0; }

  /// The places most like a hand, each far from the others, in bins of `image`. Valid until the
  /// next call.
  std::span<const HandShape> find(const BinImage& image) noexcept;

 private:
  static constexpr int kEdgeDirections = 8;          // of half a turn
  static constexpr int kMaps = kEdgeDirections + 1;  // one for each, and one of calm
  static constexpr int kMaxProposals = 16;

  /// A point of the outline with its normal, in metres of the hand's plane.
  struct OutlinePoint {
    Eigen::Vector2f at_m, normal;
    int bone;  ///< a finger's number, or beyond
  };
  struct Feature {
    std::int8_t dx, dy;  ///< pixels of a level
    std::uint8_t map;
  };
  struct Template {
    Eigen::Matrix2f px_per_m;  ///< level from hand
    Layout layout = Layout::thumb_right;
    std::vector<Feature> features;
    int left = 0, right = 0, up = 0, down = 0;  ///< how far the features reach
  };
  /// The image at 1/scale of its size, with a margin around it; the even columns of each map lie
  /// together, then the odd ones.
  struct Level {
    float scale = 1;
    int width = 0, height = 0;

    int row_size() const noexcept { return width / 2; }
    int plane_size() const noexcept { return row_size() * height; }
    int offset(int map, int x, int y) const noexcept {
      return (2 * map + (x & 1)) * plane_size() + y * row_size() + (x >> 1);
    }
  };
  struct Proposal {
    HandShape shape;  ///< as slid, until it is aligned
    std::array<Eigen::Vector2f, kFingerCount> slid_tips;
    int score = 0;
    bool aligned = false;
  };
  /// What a colour step from one neighbour to the other means: shares of two edge directions.
  struct Edge {
    std::uint8_t direction, strength, next_strength, calm;
  };

  void draw_outline();
  void make_templates();
  Edge edge(int gx, int gy) const noexcept;
  int nearest_direction(const Eigen::Vector2f& normal) const noexcept;
  void read_colors(const BinImage& image, int width, int height, float scale) noexcept;
  void read_level(const BinImage& image, float scale) noexcept;
  void spread(int map) noexcept;
  void slide(const Template& t) noexcept;
  void propose(const Template& t, const Eigen::Vector2f& at_px, int score) noexcept;
  void align(HandShape& shape) const noexcept;

  OutlineSearchConfig config_;
  HandShape hand_;  // the average one, in metres
  std::vector<OutlinePoint> outline_;
  std::vector<Template> templates_;  // those of one direction next to each other
  std::vector<Edge> edge_table_;
  Level level_;                       // the one that is searched
  std::vector<std::uint8_t> colors_;  // three channels of the image at its size
  std::vector<std::uint8_t> edges_;   // its maps before edges are spread
  std::vector<std::uint8_t> maps_;
  std::vector<std::uint8_t> highest_;
  std::vector<std::uint16_t> sums_;
  std::vector<int> offsets_;
  std::array<Proposal, kMaxProposals> proposals_;
  std::array<HandShape, kMaxProposals> found_;
  int proposal_count_ = 0;
  int turn_ = 0;
};

}  // namespace handyar
