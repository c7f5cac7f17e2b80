// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "handyar/hand_search.hpp"
#include "handyar/skin_model.hpp"
#include "handyar/tracker.hpp"
#include "skin_samples.hpp"
#include "stage_clock.hpp"

namespace handyar {

struct HandTracker::Impl {
  Impl(const Camera& c, const HandModel& hand, const Config& cfg)
      : config(cfg),
        calibrated_camera(c),
        camera(c),
        measured_layout(hand.layout),
        hands{hand.for_layout(Layout::thumb_right), hand.for_layout(Layout::thumb_left)},
        skin(cfg.skin),
        shape_model(hand, cfg.shape),
        modelled_shape(hand),
        stages(cfg.fingertips),
        search(stages, cfg.search, cfg.shape, shape_model),
        filter(cfg.filter) {}

  void prepare(const ImageView& frame);
  void forget() noexcept;
  void advance(bool seen) noexcept;

  // tracker_look.cpp
  class Look;
  bool look_at_hand(const ImageView& frame, const StageClock& clock, TrackResult& result) noexcept;

  // tracker_search.cpp
  bool find_anywhere(const ImageView& frame) noexcept;
  bool find_own_outline() noexcept;
  void go_to(const HandShape& candidate) noexcept;
  void forget_found() noexcept;
  bool adopt_found(const ImageView& frame) noexcept;

  // tracker_stages.cpp: in the order of the paper's Figure 2.
  bool read(const ImageView& frame, const PixelRect& part, int step, double noise,
            int radius) noexcept;
  bool read_neighbourhood(const ImageView& frame, bool anew) noexcept;
  bool segment(bool where_expected) noexcept;
  bool follow_outline() noexcept;
  bool trace(const Component* hand) noexcept;
  bool trace(const Mask& mask) noexcept;
  bool find_fingertips() noexcept;
  bool match(bool anew) noexcept;
  int assign_tips(bool anew) noexcept;
  bool find_valleys() noexcept;
  int judge_tips() noexcept;
  HandShapeConfig limits_of_belief() const noexcept;
  bool contradicts_model() const noexcept;
  bool has_turned_over(const HandShapeConfig& limits) const noexcept;
  void place_what_was_missed() noexcept;
  void measure_tips(TrackResult& result) noexcept;
  void measure_axes(TrackResult& result) noexcept;
  bool estimate_pose(TrackResult& result) noexcept;
  void filter_pose(TrackResult& result) noexcept;
  void learn(const BinView& image, const Mask& mask, const HandShape& hand_shape) noexcept;

  bool may_go_by_outline() const noexcept {
    return own_shape.is_known() && time_s - colored_s < config.acquisition.max_colorless_s;
  }
  /// Input pixels a mask's pixel, each way, around a hand that is followed.
  int tracking_step() const noexcept {
    const int enough_px = 900;  // along the longer side: finer than that costs and gains little
    const int step = std::max(1, std::max(width_px, height_px) / enough_px);
    return config.half_resolution ? 2 * step : step;
  }
  /// The same for whole frames, which have to find room where those are.
  int search_step() const noexcept {
    const float reduced = static_cast<float>(width_px) * static_cast<float>(height_px) /
                          static_cast<float>(config.search.pixels);
    return std::max({2, tracking_step(), static_cast<int>(std::lround(std::sqrt(reduced)))});
  }
  PixelRect region_of_interest(double dt_s) const noexcept;
  Eigen::Vector2f to_input(const Eigen::Vector2f& p) const noexcept {
    return {static_cast<float>(bins.x_px(p.x())), static_cast<float>(bins.y_px(p.y()))};
  }
  HandShape to_input(const HandShape& s) const noexcept {
    return s.transformed(static_cast<float>(bins.step_px), bins.origin_px());
  }
  HandShape to_mask(const HandShape& shape_px) const noexcept {
    const float scale = 1.0f / static_cast<float>(bins.step_px);
    return shape_px.transformed(scale, -scale * bins.origin_px());
  }
  int least_area() const noexcept { return bins.width * bins.height / 50; }
  const HandModel& hand(Layout layout) const noexcept { return hands[static_cast<int>(layout)]; }

  Config config;
  Camera calibrated_camera, camera;  // as given; at the size of the frames
  Layout measured_layout;
  HandModel hands[2];  // one per layout
  int width_px = 0, height_px = 0;

  SkinModel skin;
  SkinModel::Learned trusted_skin;  // as it was when the hand was last tracked
  HandShapeModel shape_model;
  OwnShape modelled_shape;
  MaskStages stages;
  HandSearch search;
  BinImage bins;  // of the neighbourhood, or of the whole frame while searching it
  ChromaSmoother chroma;
  ExpectedRegion expectation;
  const ExpectedRegion anywhere{.ratios = {ExpectedRegion::kInside}};
  PoseFilter filter;
  SkinSamples samples;
  Mask silhouette;
  std::vector<Eigen::Vector2f> contour_px;
  int contour_size = 0;

  // What is known of the hand from frame to frame.
  State state = State::searching;
  bool following = false;      // `shape` tells where the hand was in the last frame
  HandShape shape;             // input pixels
  bool noisy = false;          // colours around it were averaged in the last frame
  bool promising = false;      // `found` was refused, but not by much
  HandShape before, expected;  // mask pixels of this frame: `shape`, and where it should be now
  HandShape found;             // mask pixels of this frame
  std::array<bool, kFingerCount> tip_inferred{};   // of `found`: from own_shape
  std::array<float, kFingerCount> tip_doubt_px{};  // of `found`: how far off its tips may be
  OwnShape own_shape;
  Component component;
  Eigen::Vector2f centroid_px = Eigen::Vector2f::Zero();
  Eigen::Vector2f seen_palm_px = Eigen::Vector2f::Zero();  // where it was last seen
  Eigen::Vector2f velocity_px_s = Eigen::Vector2f::Zero();
  double time_s = -std::numeric_limits<double>::infinity();
  double seen_s = 0;        // when the hand was last seen
  double first_seen_s = 0;  // since when it is seen without a break
  double tracked_s = -std::numeric_limits<double>::infinity();   // when it was last tracked
  double filtered_s = -std::numeric_limits<double>::infinity();  // when a pose was last filtered
  double five_tips_s = 0;  // when all five tips were last seen
  int seen_frames = 0;
  bool colorless = false;                // the mask is the silhouette of an outline
  double colored_s = 0;                  // when it was last seen by its colours
  Layout layout_before{};                // of the hand that was followed last
  double planar_evidence = 0;            // log odds for the planar solution that is followed
  double relief_evidence = 0;            // log odds that heights are the model's, not mirrored
  std::optional<HandShape> found_again;  // by the search in this frame: who is being acquired
  float acquired_deviation = 1;  // of the search's best view of the hand that is being acquired
  struct {
    HandShape shape;
    bool following = false;
  } before_search;  // what was known, until what the search found is a hand at a closer look
};

}  // namespace handyar
