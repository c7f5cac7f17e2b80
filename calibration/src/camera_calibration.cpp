// SPDX-License-Identifier: MIT
#include "handyar/calibration/camera_calibration.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "text.hpp"

namespace handyar {
namespace {

// In the order in which terms are tried: first what all cameras need.
struct DistortionModel {
  const char* name;
  int flags;
  int parameters;
};
constexpr int kNoTangent = cv::CALIB_ZERO_TANGENT_DIST;
constexpr int kSquare = cv::CALIB_FIX_ASPECT_RATIO;
constexpr std::array<DistortionModel, 6> kModels = {{
    {"none", kSquare | kNoTangent | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3, 3},
    {"k1", kSquare | kNoTangent | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3, 4},
    {"k1 k2", kSquare | kNoTangent | cv::CALIB_FIX_K3, 5},
    {"k1 k2 p1 p2", kSquare | cv::CALIB_FIX_K3, 7},
    {"k1 k2 p1 p2, pixels not square", cv::CALIB_FIX_K3, 8},
    {"k1 k2 p1 p2 k3, pixels not square", 0, 9},
}};

struct Fit {
  cv::Matx33d K = cv::Matx33d::eye();
  cv::Mat distortion = cv::Mat::zeros(1, 5, CV_64F);
  cv::Mat sigma, view_rms;
  double rms_px = 0;
};

Fit fit(std::span<const CalibrationView> views, const std::vector<int>& used, const Board& board,
        cv::Size size, int flags) {
  const std::vector<std::vector<cv::Point3f>> object(used.size(), board.corners_m());
  std::vector<std::vector<cv::Point2f>> image;
  for (int i : used) image.push_back(views[i].corners_px);
  Fit f;
  cv::Mat rotations, translations, sigma_poses;
  f.rms_px = cv::calibrateCamera(object, image, size, f.K, f.distortion, rotations, translations,
                                 f.sigma, sigma_poses, f.view_rms, flags | cv::CALIB_USE_LU);
  return f;
}

// The terms worth having: residuals of neighbouring corners and views are alike, so a corner counts
// as a third of an independent measurement.
std::pair<Fit, const DistortionModel*> best_fit(std::span<const CalibrationView> views,
                                                const std::vector<int>& used, const Board& board,
                                                cv::Size size) {
  const double n = 2.0 * used.size() * board.columns * board.rows / 3;
  Fit best;
  const DistortionModel* model = nullptr;
  double best_criterion = 0;
  for (const DistortionModel& m : kModels) {
    const Fit f = fit(views, used, board, size, m.flags);
    const double criterion = 2 * n * std::log(f.rms_px) + m.parameters * std::log(n);
    if (model && criterion >= best_criterion) continue;
    best = f;
    model = &m;
    best_criterion = criterion;
  }
  return {best, model};
}

std::vector<int> leave_outliers(const std::vector<int>& used, const cv::Mat& view_rms) {
  std::vector<double> sorted(view_rms.begin<double>(), view_rms.end<double>());
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  const double limit = std::max(2.5 * sorted[sorted.size() / 2], 0.05);
  std::vector<int> kept;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (view_rms.at<double>(static_cast<int>(i)) <= limit) kept.push_back(used[i]);
  return kept;
}

double median_square_px(std::span<const CalibrationView> views, const std::vector<int>& seen,
                        const Board& board) {
  std::vector<double> sides;
  for (int i : seen) {
    const auto& c = views[i].corners_px;
    const double row = cv::norm(c[board.columns - 1] - c[0]) / (board.columns - 1);
    const double column = cv::norm(c[c.size() - board.columns] - c[0]) / (board.rows - 1);
    sides.push_back(std::sqrt(row * column));
  }
  std::nth_element(sides.begin(), sides.begin() + sides.size() / 2, sides.end());
  return sides[sides.size() / 2];
}

// Views of the board that are fit for use, or the reason why there are too few of them.
std::vector<int> usable_views(std::span<const CalibrationView> views, const Board& board,
                              double px_scale) {
  std::vector<int> seen, sharp;
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    if (!views[i].board_seen()) continue;
    seen.push_back(i);
    if (views[i].blur_px <= kMaxBlurPx * px_scale) sharp.push_back(i);
  }
  if (static_cast<int>(seen.size()) < kMinViews)
    throw CalibrationError(
        text("the whole board of %dx%d inner corners is seen in %zu of %zu "
             "frames, %d are needed: keep all of it in the picture, flat and "
             "evenly lit",
             board.columns, board.rows, seen.size(), views.size(), kMinViews));
  if (static_cast<int>(sharp.size()) < kMinViews)
    throw CalibrationError(
        text("the board is blurred in %zu of the %zu frames that show it: move "
             "more slowly, with more light",
             seen.size() - sharp.size(), seen.size()));
  const double square_px = median_square_px(views, sharp, board);
  if (square_px < 10 * px_scale)
    throw CalibrationError(
        text("the board is too small in the picture, %.0f pixels a square: come "
             "closer or print it larger",
             square_px));
  return sharp;
}

void require_enough(const std::vector<int>& used) {
  if (static_cast<int>(used.size()) >= kMinViews) return;
  throw CalibrationError(
      text("only %zu different views of the board, %d are needed: move the "
           "camera around it slowly, nearer and farther",
           used.size(), kMinViews));
}

void require_good(const CameraCalibration& c, double px_scale) {
  if (c.rms_px > 1.0 * px_scale)
    throw CalibrationError(
        text("the corners do not fit one flat board and one camera, %.1f pixels "
             "rms: lay the board flat, switch zoom and stabilisation off, and "
             "move slowly (rolling shutter)",
             c.rms_px));
  const double focal_percent = 100 * c.focal_sigma_px / c.camera.fx_px;
  if (!(focal_percent < 2))
    throw CalibrationError(
        text("the views leave the focal length uncertain by %.0f %%: look at "
             "the board from more sides and distances",
             focal_percent));
}

}  // namespace

CameraCalibration calibrate_camera(std::span<const CalibrationView> views, const Board& board,
                                   cv::Size image_size) {
  const double px_scale = std::max(image_size.width, image_size.height) / 640.0;
  const std::vector<int> usable = usable_views(views, board, px_scale);

  // What a camera of 60 degrees would see is near enough to tell views apart.
  const Camera rough = Camera::from_field_of_view(image_size.width, image_size.height);
  std::vector<Viewpoint> viewpoints;
  for (int i : usable)
    viewpoints.push_back(viewpoint(board_pose(views[i].corners_px, board, rough), board.centre_m(),
                                   -Eigen::Vector3d::UnitZ(), rough));
  std::vector<int> used;
  std::vector<Viewpoint> used_viewpoints;
  for (int k : choose_diverse(viewpoints, kMaxViews)) {
    used.push_back(usable[k]);
    used_viewpoints.push_back(viewpoints[k]);
  }
  constexpr double kDegree = std::numbers::pi / 180;
  const double span_rad = directions_span_rad(used_viewpoints);
  if (span_rad < 20 * kDegree)
    throw CalibrationError(
        text("the board is seen from one side only, directions differ by %.0f "
             "degrees: look at it from above and tilted to all sides",
             span_rad / kDegree));
  require_enough(used);

  used = leave_outliers(used, fit(views, used, board, image_size, kModels[2].flags).view_rms);
  require_enough(used);
  const auto best = best_fit(views, used, board, image_size);
  const auto& f = best.first;

  CameraCalibration out;
  out.camera = {.width_px = image_size.width,
                .height_px = image_size.height,
                .fx_px = f.K(0, 0),
                .fy_px = f.K(1, 1),
                .cx_px = f.K(0, 2),
                .cy_px = f.K(1, 2)};
  for (int i = 0; i < 5; ++i) out.camera.distortion[i] = f.distortion.at<double>(i);
  out.rms_px = f.rms_px;
  const auto sigma = [&f](int i) { return f.sigma.at<double>(i); };
  out.focal_sigma_px = std::max(sigma(0), sigma(1));
  out.centre_sigma_px = std::max(sigma(2), sigma(3));
  out.distortion = best.second->name;
  out.views_used = used;
  require_good(out, px_scale);
  return out;
}

}  // namespace handyar
