// SPDX-License-Identifier: MIT
#include "handyar/evaluation/markers.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/apriltag_pose.h>
#include <apriltag/tag36h11.h>

#include <array>
#include <cstdlib>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/affine.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace handyar::evaluation {
namespace {

cv::Matx33d matrix_of(const Camera& c) {
  return {c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1};
}

Eigen::Isometry3d isometry(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  Eigen::Isometry3d T;
  cv::cv2eigen(cv::Affine3d(rotation, translation).matrix, T.matrix());
  return T;
}

const std::map<std::string, cv::aruco::PREDEFINED_DICTIONARY_NAME> kDictionaries = {
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL}};

class ArucoFinder final : public MarkerFinder {
 public:
  explicit ArucoFinder(const Marker& marker) : marker_(marker) {
    const auto known = kDictionaries.find(marker.dictionary);
    if (known == kDictionaries.end())
      throw std::invalid_argument("no such marker dictionary: " + marker.dictionary);
    dictionary_ = cv::aruco::getPredefinedDictionary(known->second);
    parameters_ = cv::aruco::DetectorParameters::create();
    parameters_->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  }

  std::optional<Eigen::Isometry3d> find(const cv::Mat& gray, const Camera& camera) override {
    cv::aruco::detectMarkers(gray, dictionary_, corners_, ids_, parameters_);
    const std::vector<cv::Point2f>* seen = nullptr;
    for (std::size_t i = 0; i < ids_.size(); ++i)
      if (marker_.id == ids_[i] ||
          (marker_.id < 0 && (!seen || cv::contourArea(corners_[i]) > cv::contourArea(*seen))))
        seen = &corners_[i];
    if (!seen) return std::nullopt;
    const double h = marker_.size_m / 2;
    const std::array<cv::Point3d, 4> square = {{{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}}};
    cv::Vec3d r, t;
    if (!cv::solvePnP(square, *seen, matrix_of(camera), camera.distortion, r, t, false,
                      cv::SOLVEPNP_IPPE_SQUARE))
      return std::nullopt;
    return isometry(r, t);
  }

 private:
  Marker marker_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  std::vector<std::vector<cv::Point2f>> corners_;
  std::vector<int> ids_;
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

  std::optional<Eigen::Isometry3d> find(const cv::Mat& gray, const Camera& camera) override {
    image_u8_t view{gray.cols, gray.rows, int(gray.step[0]), gray.data};
    zarray_t* detections = apriltag_detector_detect(detector_.get(), &view);
    apriltag_detection_t* seen = nullptr;
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* d = nullptr;
      zarray_get(detections, i, &d);
      if (marker_.id == d->id || (marker_.id < 0 && (!seen || area(*d) > area(*seen)))) seen = d;
    }
    std::optional<Eigen::Isometry3d> T;
    if (seen) T = pose(seen, camera);
    apriltag_detections_destroy(detections);
    return T;
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

std::vector<Eigen::Vector3d> Board::corners_m() const {
  std::vector<Eigen::Vector3d> corners;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) corners.emplace_back(x * square_m, y * square_m, 0);
  return corners;
}

std::optional<BoardView> find_board(const cv::Mat& gray, const Board& board, const Camera& camera) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(
          gray, {board.columns, board.rows}, corners,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
    return std::nullopt;
  cv::cornerSubPix(gray, corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01});
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector3d& p : board.corners_m()) points.emplace_back(p.x(), p.y(), p.z());
  cv::Vec3d r, t;
  if (!cv::solvePnP(points, corners, matrix_of(camera), camera.distortion, r, t))
    return std::nullopt;
  BoardView view;
  view.T_camera_board = isometry(r, t);
  for (const cv::Point2f& c : corners) view.corners_px.emplace_back(c.x, c.y);
  return view;
}

std::vector<std::string> aruco_dictionaries() {
  std::vector<std::string> names;
  for (const auto& [name, dictionary] : kDictionaries) names.push_back(name);
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
