// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "handyar/paper/any_tracker.hpp"
#include "output_folder.hpp"

namespace handyar::cli {

/// Numbers of frames, as "10,50-60" names them; no range: all.
struct FrameSet {
  std::vector<std::pair<std::int64_t, std::int64_t>> ranges;  ///< first and last

  bool contains(std::int64_t frame) const noexcept;
  std::int64_t last() const noexcept;
};
std::optional<FrameSet> parse_frames(const std::string& text);

/// What the tracker saw in chosen frames, as PNG files: frame_000050_1_input.png, where the finder
/// looked _2_candidates, and where there is a hand _3_outline, _4_region, _5_pose (docs/method.md
/// shows them).
class DebugPictures {
 public:
  /// Makes the folder; throws io::Error when files cannot be written to it.
  explicit DebugPictures(const std::string& folder) : folder_(folder, {"frame.png"}) {}

  /// After the tracker has processed the frame. `camera` is the one of this picture size. Throws
  /// io::Error.
  void write(const cv::Mat& bgr, std::int64_t frame, const AnyTracker& tracker,
             const Camera& camera, const TrackResult& result);

 private:
  void save(const cv::Mat& picture, const char* stage) const;

  OutputFolder folder_;
  std::int64_t frame_ = 0;
};

}  // namespace handyar::cli
