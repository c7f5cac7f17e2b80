// SPDX-License-Identifier: MIT
#include "outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "handyar/calibration/hand_frame.hpp"

namespace handyar {
namespace {

constexpr int kViews = 12;           // the most frontal ones
constexpr double kPixel_m = 0.0005;  // of the picture in which outlines are averaged
constexpr double kSpacing_m = 0.002;

// Picture of the hand plane: x to the right, y up, as the hand is looked at.
struct PlanePicture {
  double left_m, top_m;
  cv::Size size;
  cv::Point2f pixel(const Eigen::Vector2d& p_m) const {
    return {static_cast<float>((p_m.x() - left_m) / kPixel_m),
            static_cast<float>((top_m - p_m.y()) / kPixel_m)};
  }
  Eigen::Vector2d point_m(const cv::Point2d& px) const {
    return {left_m + px.x * kPixel_m, top_m - px.y * kPixel_m};
  }
  double row_of(double y_m) const { return (top_m - y_m) / kPixel_m; }
};

// The contour's pixels carried to the plane z = 0 of the hand (metres).
std::vector<Eigen::Vector2d> carried(const std::vector<Eigen::Vector2f>& contour_px,
                                     const Eigen::Isometry3d& T_camera_hand, const Camera& camera) {
  const Eigen::Isometry3d T_hand_camera = T_camera_hand.inverse();
  const Eigen::Vector3d eye = T_hand_camera.translation();
  std::vector<Eigen::Vector2d> out;
  for (const Eigen::Vector2f& px : contour_px) {
    const Eigen::Vector3d ray =
        T_hand_camera.linear() * camera.unproject(px.cast<double>()).homogeneous();
    out.push_back((eye - eye.z() / ray.z() * ray).head<2>());
  }
  return out;
}

std::vector<cv::Point> drawn(const std::vector<Eigen::Vector2d>& contour_m,
                             const PlanePicture& picture) {
  std::vector<cv::Point> out;
  for (const Eigen::Vector2d& p : contour_m) {
    const cv::Point2f q = picture.pixel(p);
    // A forearm may reach far out of the picture.
    out.emplace_back(cvRound(std::clamp(q.x, -9999.f, 9999.f)),
                     cvRound(std::clamp(q.y, -9999.f, 9999.f)));
  }
  return out;
}

// How far down a view shows the arm at its full width. The tracker looks in an upright box, which
// cuts the arm off obliquely to the hand: the highest point at the box's edge, below `below_y_m`.
double arm_end_m(const std::vector<Eigen::Vector2f>& contour_px,
                 const std::vector<Eigen::Vector2d>& contour_m, double below_y_m) {
  Eigen::AlignedBox2f box;
  for (const Eigen::Vector2f& px : contour_px) box.extend(px);
  double end_m = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < contour_px.size(); ++i) {
    const Eigen::Vector2f inside = (contour_px[i] - box.min()).cwiseMin(box.max() - contour_px[i]);
    if (inside.minCoeff() < 1.5f && contour_m[i].y() < below_y_m)
      end_m = std::max(end_m, contour_m[i].y());
  }
  return end_m;
}

constexpr double kSearch_m = 0.025;  // around where the average hand has its wrist

// The narrowest row there, down to where the arm is seen.
int wrist_row(const cv::Mat& mask, const PlanePicture& picture, double expected_y_m,
              double arm_end_y_m) {
  const int first = std::clamp(cvRound(picture.row_of(expected_y_m + kSearch_m)), 0, mask.rows - 1);
  const double last_y_m = std::max(expected_y_m - kSearch_m, arm_end_y_m);
  const int last = std::clamp(cvRound(picture.row_of(last_y_m)), 0, mask.rows - 1);
  int best = first, narrowest = mask.cols + 1;
  for (int row = first; row <= last; ++row) {
    const int width = cv::countNonZero(mask.row(row));
    if (width == 0) break;  // the region ends above
    if (width < narrowest) narrowest = width, best = row;
  }
  return best;
}

std::vector<cv::Point> largest_contour(const cv::Mat& mask) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (contours.empty()) return {};
  return *std::max_element(contours.begin(), contours.end(), [](const auto& a, const auto& b) {
    return cv::contourArea(a) < cv::contourArea(b);
  });
}

// From the wrist's corner on the thumb's side over the fingertips to its other corner.
std::vector<Eigen::Vector2d> from_wrist_to_wrist(const std::vector<cv::Point>& contour, int wrist,
                                                 const PlanePicture& picture, bool thumb_right) {
  std::vector<Eigen::Vector2d> ring;
  for (const cv::Point& p : contour) ring.push_back(picture.point_m(p));
  // The wrist's two corners are the outermost points of the lowest row.
  int left = -1, right = -1;
  const int n = static_cast<int>(contour.size());
  for (int i = 0; i < n; ++i) {
    if (contour[i].y < wrist) continue;
    if (left < 0 || contour[i].x < contour[left].x) left = i;
    if (right < 0 || contour[i].x > contour[right].x) right = i;
  }
  if (left < 0) return {};
  int begin = thumb_right ? right : left, end = thumb_right ? left : right;
  std::vector<Eigen::Vector2d> way, other;
  for (int i = begin;; i = (i + 1) % n) {
    way.push_back(ring[i]);
    if (i == end) break;
  }
  for (int i = begin;; i = (i + n - 1) % n) {
    other.push_back(ring[i]);
    if (i == end) break;
  }
  if (other.size() > way.size()) way.swap(other);
  std::vector<Eigen::Vector2d> out{way.front()};
  for (const Eigen::Vector2d& p : way)
    if ((p - out.back()).norm() >= kSpacing_m) out.push_back(p);
  return out;
}

}  // namespace

std::vector<Eigen::Vector2d> measure_outline(std::span<const CalibrationView> views,
                                             const std::vector<int>& used,
                                             std::span<const Eigen::Isometry3d> T_camera_board,
                                             const Camera& camera,
                                             const Eigen::Isometry3d& T_board_hand,
                                             const HandModel& hand) {
  struct Candidate {
    double frontality;
    std::size_t k;
  };
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < used.size(); ++k) {
    if (views[used[k]].contour_px.size() < 50) continue;
    const Eigen::Isometry3d T = T_camera_board[k] * T_board_hand;
    candidates.push_back({-T.translation().normalized().dot(T.linear().col(2)), k});
  }
  if (candidates.empty()) return {};
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.frontality > b.frontality; });
  candidates.resize(std::min<std::size_t>(candidates.size(), kViews));

  const double scale = fit_average_hand(hand.tips_m.topRows<2>()).scale;
  const double wrist_y_m = hand.tips_m(1, 2) - scale * kAverageHandLength_m;
  const double margin_m = 0.03;
  const double half_width_m = hand.tips_m.row(0).cwiseAbs().maxCoeff() + margin_m;
  PlanePicture picture{-half_width_m, hand.tips_m.row(1).maxCoeff() + margin_m, {}};
  picture.size = {cvRound(2 * half_width_m / kPixel_m),
                  cvRound(picture.row_of(wrist_y_m - 2 * margin_m))};

  std::vector<double> arm_ends_m;
  cv::Mat votes = cv::Mat::zeros(picture.size, CV_32F);
  for (const Candidate& c : candidates) {
    cv::Mat mask = cv::Mat::zeros(picture.size, CV_32F);
    const auto& contour_px = views[used[c.k]].contour_px;
    const auto contour_m = carried(contour_px, T_camera_board[c.k] * T_board_hand, camera);
    arm_ends_m.push_back(arm_end_m(contour_px, contour_m, wrist_y_m + kSearch_m));
    const std::vector<std::vector<cv::Point>> polygon{drawn(contour_m, picture)};
    cv::fillPoly(mask, polygon, 1.0);
    votes += mask;
  }
  cv::Mat mask = votes > candidates.size() / 2.0;
  // Three quarters of the views see the arm as far as this.
  std::sort(arm_ends_m.begin(), arm_ends_m.end());
  const int wrist = wrist_row(mask, picture, wrist_y_m, arm_ends_m[(arm_ends_m.size() * 3) / 4]);
  mask.rowRange(std::min(wrist + 1, mask.rows), mask.rows).setTo(0);
  const auto contour = largest_contour(mask);
  if (contour.empty()) return {};
  const int lowest = std::max_element(contour.begin(), contour.end(), [](auto& a, auto& b) {
                       return a.y < b.y;
                     })->y;
  return from_wrist_to_wrist(contour, lowest, picture, hand.layout == Layout::thumb_right);
}

}  // namespace handyar
