// SPDX-License-Identifier: MIT
#include "handyar/evaluation/recording.hpp"

#include <array>
#include <chrono>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"

namespace handyar::evaluation {
namespace {

/// The library's methods, the default one first.
struct Method {
  const char* name;
  FingertipMethod fingertips;
  PoseMethod pose;
};
constexpr std::array<Method, 4> kMethods = {
    {{"ellipse", FingertipMethod::ellipse, PoseMethod::outline},
     {"curvature", FingertipMethod::curvature, PoseMethod::outline},
     {kPoints, FingertipMethod::ellipse, PoseMethod::points},
     {kRigidTips, FingertipMethod::ellipse, PoseMethod::tips}}};

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

HandTracker make_tracker(const Sequence& s, const Method& method, bool half_resolution) {
  Config config;
  config.half_resolution = half_resolution;
  config.skin.personal = s.skin;
  config.fingertips.method = method.fingertips;
  config.pose.method = method.pose;
  config.now_s = now_s;
  return HandTracker(s.camera, s.hand, config);
}

/// One marker system at one resolution.
class MarkerPass {
 public:
  MarkerPass(std::string system, bool half, std::unique_ptr<MarkerFinder> finder)
      : finder_(std::move(finder)) {
    track_.system = std::move(system);
    track_.half_resolution = half;
  }

  void process(const cv::Mat& bgr, const Camera& camera) {
    const double begin_s = now_s();
    cv::cvtColor(bgr, gray_, cv::COLOR_BGR2GRAY);
    Camera seen_by = camera;
    if (track_.half_resolution) {
      cv::resize(gray_, small_, {gray_.cols / 2, gray_.rows / 2}, 0, 0, cv::INTER_AREA);
      seen_by = camera.scaled_to(small_.cols, small_.rows);
    }
    track_.T_camera_marker.push_back(
        finder_->find(track_.half_resolution ? small_ : gray_, seen_by));
    track_.ms.push_back(1e3 * (now_s() - begin_s));
  }

  MarkerTrack take() { return std::move(track_); }

 private:
  std::unique_ptr<MarkerFinder> finder_;
  MarkerTrack track_;
  cv::Mat gray_, small_;
};

class Session {
 public:
  explicit Session(const Sequence& sequence) {
    recording_.sequence = sequence;
    if (sequence.board) board_.emplace(*sequence.board, sequence.camera);
    for (const bool half : {false, true}) {
      for (const Method& method : kMethods) {
        if (method.pose == PoseMethod::points && !sequence.hand.has_axes) continue;  // the default
        trackers_.push_back(make_tracker(sequence, method, half));
        recording_.tracks.push_back({method.name, half, {}});
      }
      markers_.emplace_back("ArUco", half, make_aruco_finder(sequence.aruco));
      markers_.emplace_back("AprilTag", half, make_apriltag_finder(sequence.apriltag));
    }
  }

  void process(const io::Frame& frame) {
    const Sequence& s = recording_.sequence;
    recording_.frame_index.push_back(frame.index);
    recording_.time_s.push_back(frame.time_s);
    for (std::size_t i = 0; i < trackers_.size(); ++i) {
      const TrackResult result = trackers_[i].process(frame.view(), frame.time_s);
      if (result.status != FrameStatus::ok)
        throw io::Error(s.video,
                        "frame " + std::to_string(frame.index) + ": " + describe(result.status));
      recording_.tracks[i].results.push_back(result);
    }
    const auto contour = trackers_.front().contour_px();
    recording_.contours_px.emplace_back(contour.begin(), contour.end());
    for (MarkerPass& pass : markers_) pass.process(frame.bgr, s.camera);
    recording_.board_views.emplace_back();
    if (board_) recording_.board_views.back() = board_->find(frame.bgr);
  }

  Recording take() {
    for (MarkerPass& pass : markers_) recording_.markers.push_back(pass.take());
    return std::move(recording_);
  }

  Recording& recording() { return recording_; }

 private:
  Recording recording_;
  std::vector<HandTracker> trackers_;
  std::vector<MarkerPass> markers_;
  std::optional<BoardFinder> board_;
};

}  // namespace

const MarkerTrack* Recording::find_marker(const std::string& system, bool half_resolution) const {
  for (const MarkerTrack& m : markers)
    if (m.system == system && m.half_resolution == half_resolution) return &m;
  return nullptr;
}

Recording record(const Sequence& sequence, const Progress& progress) {
  cv::setNumThreads(1);  // everything that is timed runs on one thread
  const auto source = io::open_input(sequence.video);
  Session session(sequence);
  session.recording().frames_per_second = source->info().fps;
  io::Frame frame;
  int done = 0;
  try {
    while (source->read(frame)) {
      session.process(frame);
      if (progress) progress(++done, int(source->info().frame_count));
    }
  } catch (const io::Error& e) {
    if (done == 0) throw;
    session.recording().broken_off = e.what();
  }
  return session.take();
}

}  // namespace handyar::evaluation
