// SPDX-License-Identifier: MIT
#include "handyar/evaluation/recording.hpp"

#include <algorithm>
#include <chrono>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "handyar/io/error.hpp"
#include "handyar/io/frame_source.hpp"
#include "handyar/paper/any_tracker.hpp"

namespace handyar::evaluation {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

HandTracker figure_tracker(const Sequence& s) {
  Config config;
  config.now_s = now_s;
  return HandTracker(s.camera, s.hand, config);
}

paper::Tracker paper_tracker(const Sequence& s, paper::FingertipMethod fingertips, bool half) {
  paper::Config config;
  config.half_resolution = half;
  config.fingertips = fingertips;
  config.now_s = now_s;
  return paper::Tracker(s.camera, s.hand, config);
}

/// The outer boundary of the hand, in pixels of the frame.
std::vector<Eigen::Vector2f> contour_of(const HandMask& mask) {
  std::vector<Eigen::Vector2f> contour;
  if (mask.width == 0) return contour;
  const cv::Mat pixels(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data),
                       static_cast<std::size_t>(mask.stride_bytes));
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(pixels, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto longest = std::max_element(outlines.begin(), outlines.end(),
                                        [](auto& a, auto& b) { return a.size() < b.size(); });
  if (longest == outlines.end()) return contour;
  for (const cv::Point& p : *longest)
    contour.emplace_back(mask.x0_px + p.x * mask.step_px, mask.y0_px + p.y * mask.step_px);
  return contour;
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
    views_.push_back(finder_->find(track_.half_resolution ? small_ : gray_, seen_by));
    track_.ms.push_back(1e3 * (now_s() - begin_s));
  }

  MarkerTrack take() {
    track_.T_camera_marker = follow_one(views_);
    return std::move(track_);
  }

 private:
  std::unique_ptr<MarkerFinder> finder_;
  MarkerTrack track_;
  std::vector<std::vector<MarkerView>> views_;  // one list a frame
  cv::Mat gray_, small_;
};

class Session {
 public:
  Session(const Sequence& sequence, Methods methods) {
    recording_.sequence = sequence;
    add(kFigure, false, figure_tracker(sequence));
    if (methods == Methods::figure_only) return;
    if (sequence.board) board_.emplace(*sequence.board, sequence.camera);
    for (const bool half : {false, true}) {
      add(kPaper, half, paper_tracker(sequence, paper::FingertipMethod::ellipse, half));
      add(kPaperCurvature, half, paper_tracker(sequence, paper::FingertipMethod::curvature, half));
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
    recording_.contours_px.push_back(contour_of(trackers_.front().mask()));
    for (MarkerPass& pass : markers_) pass.process(frame.bgr, s.camera);
    recording_.board_views.emplace_back();
    if (board_) recording_.board_views.back() = board_->find(frame.bgr);
  }

  Recording take() {
    for (std::size_t i = 0; i < trackers_.size(); ++i)
      recording_.tracks[i].hand = trackers_[i].hand();
    for (MarkerPass& pass : markers_) recording_.markers.push_back(pass.take());
    return std::move(recording_);
  }

  Recording& recording() { return recording_; }

 private:
  void add(const char* method, bool half, AnyTracker tracker) {
    trackers_.push_back(std::move(tracker));
    recording_.tracks.push_back({method, half, {}, {}});
  }

  Recording recording_;
  std::vector<AnyTracker> trackers_;
  std::vector<MarkerPass> markers_;
  std::optional<BoardFinder> board_;
};

}  // namespace

const MarkerTrack* Recording::find_marker(const std::string& system, bool half_resolution) const {
  for (const MarkerTrack& m : markers)
    if (m.system == system && m.half_resolution == half_resolution) return &m;
  return nullptr;
}

Recording record(const Sequence& sequence, Methods methods, const Progress& progress,
                 std::int64_t first_frame) {
  cv::setNumThreads(1);  // everything that is timed runs on one thread
  const auto source = io::open_input(sequence.video);
  Session session(sequence, methods);
  io::Frame frame;
  int done = 0;
  try {
    while (source->read(frame)) {
      if (frame.index < first_frame) continue;
      session.process(frame);
      ++done;
      if (progress) progress(done, int(source->info().frame_count));
    }
  } catch (const io::Error& e) {
    if (done == 0) throw;
    session.recording().broken_off = e.what();
  }
  return session.take();
}

}  // namespace handyar::evaluation
