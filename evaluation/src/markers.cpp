// SPDX-License-Identifier: MIT
#include "handyar/evaluation/markers.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/apriltag_pose.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "handyar/evaluation/rigid.hpp"
#include "handyar/opencv/aruco.hpp"
#include "handyar/opencv/types.hpp"

namespace handyar::evaluation {
namespace {

class ArucoFinder final : public MarkerFinder {
 public:
  explicit ArucoFinder(const Marker& marker) : marker_(marker) {
    require_aruco();
    const std::optional<int> number = dictionary_number(marker.dictionary);
    if (!number) throw std::invalid_argument("no such marker dictionary: " + marker.dictionary);
    dictionary_ = *number;
  }

  std::vector<MarkerView> find(const cv::Mat& gray, const Camera& camera) override {
    std::vector<SeenMarker> markers = detect_markers(gray, dictionary_);
    std::erase_if(markers, [&](const SeenMarker& m) { return !marker_.is_or_may_be(m.id); });
    std::stable_sort(markers.begin(), markers.end(), [](const SeenMarker& a, const SeenMarker& b) {
      return cv::contourArea(a.corners_px) > cv::contourArea(b.corners_px);
    });
    std::vector<MarkerView> found;
    cv::Vec3d r, t;
    for (const SeenMarker& m : markers)
      if (cv::solvePnP(marker_corners_m(marker_.size_m), m.corners_px, camera_matrix(camera),
                       camera.distortion, r, t, false, cv::SOLVEPNP_IPPE_SQUARE))
        found.push_back({m.id, isometry(r, t)});
    return found;
  }

 private:
  Marker marker_;
  int dictionary_;
};

class AprilTagFinder final : public MarkerFinder {
 public:
  explicit AprilTagFinder(const Marker& marker)
      : marker_(marker),
        family_(tag36h11_create(), tag36h11_destroy),
        detector_(apriltag_detector_create(), apriltag_detector_destroy) {
    apriltag_detector_add_family(detector_.get(), family_.get());
    detector_->nthreads = 1;
    detector_->quad_decimate = 1;  // full accuracy; the library's default halves the picture
  }

  std::vector<MarkerView> find(const cv::Mat& gray, const Camera& camera) override {
    image_u8_t view{gray.cols, gray.rows, int(gray.step[0]), gray.data};
    zarray_t* detections = apriltag_detector_detect(detector_.get(), &view);
    std::vector<apriltag_detection_t*> tags;
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* d = nullptr;
      zarray_get(detections, i, &d);
      if (marker_.is_or_may_be(d->id)) tags.push_back(d);
    }
    std::stable_sort(tags.begin(), tags.end(),
                     [](const auto* a, const auto* b) { return area(*a) > area(*b); });
    std::vector<MarkerView> found;
    for (apriltag_detection_t* tag : tags) found.push_back({tag->id, pose(tag, camera)});
    apriltag_detections_destroy(detections);
    return found;
  }

 private:
  static double area(const apriltag_detection_t& d) {
    return std::abs((d.p[2][0] - d.p[0][0]) * (d.p[3][1] - d.p[1][1]) -
                    (d.p[2][1] - d.p[0][1]) * (d.p[3][0] - d.p[1][0]));
  }

  Eigen::Isometry3d pose(apriltag_detection_t* d, const Camera& camera) const {
    undistort(d, camera);
    apriltag_detection_info_t info{
        d, marker_.size_m, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
    apriltag_pose_t p{};
    estimate_tag_pose(&info, &p);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) T.linear()(r, c) = MATD_EL(p.R, r, c);
      T.translation()[r] = MATD_EL(p.t, r, 0);
    }
    std::free(p.R);  // Debian's library does not export matd_destroy, which is this
    std::free(p.t);
    // AprilTag has z into the print, and x and y as a print in OpenCV's orientation has them turned
    // by half a turn.
    T.linear() *= Eigen::Vector3d(-1, 1, -1).asDiagonal();
    return T;
  }

  /// AprilTag puts the picture's corner, not the first pixel's centre, at (0, 0), and its pose
  /// estimate knows no lens distortion: both are removed from the corners, the homography follows.
  static void undistort(apriltag_detection_t* d, const Camera& camera) {
    const std::array<cv::Point2f, 4> kTag = {{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}};
    std::array<cv::Point2f, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d ray = camera.unproject({d->p[i][0] - 0.5, d->p[i][1] - 0.5});
      d->p[i][0] = camera.fx_px * ray.x() + camera.cx_px;
      d->p[i][1] = camera.fy_px * ray.y() + camera.cy_px;
      corners[i] = {float(d->p[i][0]), float(d->p[i][1])};
    }
    const cv::Matx33d H = cv::getPerspectiveTransform(kTag.data(), corners.data());
    for (int i = 0; i < 9; ++i) d->H->data[i] = H.val[i];
  }

  Marker marker_;
  std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family_;
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector_;
};

}  // namespace

BoardFinder::BoardFinder(const Board& board, const Camera& camera)
    : board_(board), camera_(camera) {}

std::optional<BoardView> BoardFinder::find(const cv::Mat& picture) {
  std::vector<cv::Point2f> corners = find_board(picture, board_);
  if (corners.empty()) return std::nullopt;
  const Eigen::Isometry3d T = board_pose(corners, board_, camera_);
  const std::vector<Eigen::Isometry3d> turns = board_.turns();
  const auto turn_since_last_rad = [&](const Eigen::Isometry3d& turn) {
    return last_ ? angle_between(last_->linear(), T.linear() * turn.linear()) : 0;
  };
  const Eigen::Isometry3d turn = *std::min_element(
      turns.begin(), turns.end(), [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
        return turn_since_last_rad(a) < turn_since_last_rad(b);
      });
  last_ = T * turn;
  BoardView view{{}, *last_};
  for (const cv::Point3f& corner : board_.corners_m()) {
    const Eigen::Vector3d found_m = turn * Eigen::Vector3d(corner.x, corner.y, corner.z);
    const auto column = std::lround(found_m.x() / board_.square_m);
    const auto row = std::lround(found_m.y() / board_.square_m);
    const cv::Point2f& px = corners[std::size_t(row * board_.columns + column)];
    view.corners_px.emplace_back(px.x, px.y);
  }
  return view;
}

std::vector<std::optional<Eigen::Isometry3d>> follow_one(
    std::span<const std::vector<MarkerView>> frames) {
  std::map<int, int> times;
  for (const std::vector<MarkerView>& markers : frames)
    for (const MarkerView& m : markers) ++times[m.id];
  const auto most = std::max_element(times.begin(), times.end(),
                                     [](auto& a, auto& b) { return a.second < b.second; });
  std::vector<std::optional<Eigen::Isometry3d>> poses;
  for (const std::vector<MarkerView>& markers : frames) {
    const auto at = std::find_if(markers.begin(), markers.end(),
                                 [&](const MarkerView& m) { return m.id == most->first; });
    poses.push_back(at == markers.end() ? std::nullopt : std::optional(at->T_camera_marker));
  }
  return poses;
}

std::vector<std::string> aruco_dictionaries() {
  std::vector<std::string> names = dictionary_names();
  std::erase_if(names, [](const std::string& name) { return Marker{name}.is_apriltag(); });
  return names;
}

std::unique_ptr<MarkerFinder> make_aruco_finder(const Marker& marker) {
  return std::make_unique<ArucoFinder>(marker);
}

std::unique_ptr<MarkerFinder> make_apriltag_finder(const Marker& marker) {
  return std::make_unique<AprilTagFinder>(marker);
}

std::string opencv_version() { return CV_VERSION; }

}  // namespace handyar::evaluation
