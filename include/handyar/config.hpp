// SPDX-License-Identifier: MIT
#pragma once

#include "handyar/chroma_noise.hpp"
#include "handyar/fingertips.hpp"
#include "handyar/hand_search.hpp"
#include "handyar/hand_shape.hpp"
#include "handyar/matching.hpp"
#include "handyar/pose.hpp"
#include "handyar/pose_filter.hpp"
#include "handyar/skin_model.hpp"

namespace handyar {

/// When a hand that was seen is believed, and when it is given up (paper 2.2, 2.3). In seconds, so
/// that it holds at any frame rate.
struct AcquisitionConfig {
  double confirm_s = 0.27;    ///< a new hand must be seen for this long (paper: 10 frames)
  double reconfirm_s = 0.06;  ///< the same after a hand was lost less than `remember_s` ago
  int confirm_frames = 3;     ///< and in at least so many frames
  int reconfirm_frames = 2;
  double takeover_share = 0.9;  ///< another place must deviate less than this share of the hand
                                ///< that is being acquired, to be acquired instead
  double remember_s = 3.0;
  double coast_s = 0.2;             ///< how long a lost hand is still looked for where it was
  double max_colorless_s = 2.0;     ///< how long edges alone will do, where colours do not tell
  double least_support = 0.60;      ///< edge under the outline of a hand that is followed by it
  double sure_support = 0.66;       ///< and of one that is found by it, see OutlineSearch::follow
  double max_missing_tip_s = 0.25;  ///< how long four tips will do
  double max_residual_m = 0.0038;   ///< of the pose of a measured hand, see PoseEstimate::rms_px
  double new_residual_m = 0.0030;   ///< the same for a hand that was not followed till now
};

/// All settings, a struct per stage; the defaults are what the command line uses.
struct Config {
  bool half_resolution = false;  ///< segment and find fingertips at half the input's size
  ChromaNoiseConfig noise;
  SkinModelConfig skin;
  HandSearchConfig search;
  FingertipConfig fingertips;
  HandShapeConfig shape;
  MatchingConfig matching;
  AcquisitionConfig acquisition;
  PoseConfig pose;
  PoseFilterConfig filter;

  /// Clock for StageTimes, in seconds; null: times stay zero. Nothing else depends on it.
  double (*now_s)() = nullptr;
};

}  // namespace handyar
