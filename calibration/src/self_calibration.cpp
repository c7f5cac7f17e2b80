// SPDX-License-Identifier: MIT
#include "handyar/calibration/self_calibration.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>

#include "bundle.hpp"
#include "finger_axes.hpp"
#include "handyar/calibration/camera_calibration.hpp"
#include "handyar/opencv/types.hpp"
#include "text.hpp"

namespace handyar {
namespace {

constexpr int kMaxSelfViews = 60;
constexpr double kShapePrior_m = 0.020, kHeightPrior_m = 0.005;
constexpr double kDegree = std::numbers::pi / 180;

const Eigen::Vector2d kNotSeen =
    Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

// On which side of the hand the thumb shows in the picture, the fingers taken as up.
Layout layout_in_picture(const CalibrationView& v) {
  const Eigen::Vector2d root = (v.tips[0].px + v.tips[4].px) / 2;
  const Eigen::Vector2d up = v.tips[2].px - root, across = v.tips[0].px - v.tips[4].px;
  return up.x() * across.y() - up.y() * across.x() > 0 ? Layout::thumb_right : Layout::thumb_left;
}

std::vector<int> views_of_one_face(std::span<const CalibrationView> views, Layout& layout) {
  std::array<std::vector<int>, 2> faces;
  for (int i = 0; i < static_cast<int>(views.size()); ++i)
    if (views[i].hand_seen()) faces[static_cast<int>(layout_in_picture(views[i]))].push_back(i);
  layout = faces[0].size() >= faces[1].size() ? Layout::thumb_right : Layout::thumb_left;
  return faces[static_cast<int>(layout)];
}

// Both poses that explain the tips of a nearly flat hand, the better one first.
std::vector<Eigen::Isometry3d> planar_poses(const Eigen::Matrix3Xd& tips_m,
                                            const CalibrationView& view, const Camera& camera) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> image;
  for (int k = 0; k < kFingerCount; ++k) {
    object.emplace_back(tips_m(0, k), tips_m(1, k), 0.0);
    image.emplace_back(view.tips[k].px.x(), view.tips[k].px.y());
  }
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(object, image, camera_matrix(camera), camera.distortion, rotations,
                      translations, false, cv::SOLVEPNP_IPPE);
  std::vector<Eigen::Isometry3d> out;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Isometry3d T = isometry(rotations[i], translations[i]);
    // The visible face looks at the camera.
    if (T.translation().z() > 0 && T.linear().col(2).dot(T.translation()) < 0) out.push_back(T);
  }
  return out;
}

std::vector<int> choose_keyframes(std::span<const CalibrationView> views,
                                  const std::vector<int>& candidates, const HandModel& start,
                                  const Camera& camera, Bundle& bundle) {
  std::vector<int> posed;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<Viewpoint> viewpoints;
  for (int i : candidates) {
    const auto both = planar_poses(start.tips_m, views[i], camera);
    if (both.empty()) continue;
    posed.push_back(i);
    poses.push_back(both.front());
    viewpoints.push_back(
        viewpoint(both.front(), start.tips_m.rowwise().mean(), Eigen::Vector3d::UnitZ(), camera));
  }
  std::vector<int> used;
  for (int k : choose_diverse(viewpoints, kMaxSelfViews)) {
    used.push_back(posed[k]);
    bundle.T_camera_body.push_back(poses[k]);
  }
  return used;
}

// Points, their pixels and their prior. Valleys start where their pixels meet the hand plane.
void set_points(Bundle& bundle, std::span<const CalibrationView> views,
                const std::vector<int>& used, const HandModel& start, const Camera& camera) {
  bundle.tracks.assign(kFingerCount + kValleyCount, {});
  for (int i : used) {
    for (int k = 0; k < kFingerCount; ++k) bundle.tracks[k].push_back(views[i].tips[k].px);
    for (int k = 0; k < kValleyCount; ++k) {
      const Tip& v = views[i].valleys[k];
      bundle.tracks[kFingerCount + k].push_back(v.seen ? v.px : kNotSeen);
    }
  }
  const bool with_valleys =
      std::all_of(bundle.tracks.begin() + kFingerCount, bundle.tracks.end(), [](const auto& t) {
        return std::count_if(t.begin(), t.end(), [](auto& px) { return px.allFinite(); }) >=
               kMinViews;
      });
  if (!with_valleys) bundle.tracks.resize(kFingerCount);
  const auto n = static_cast<Eigen::Index>(bundle.tracks.size());
  bundle.p_m.resize(3, n);
  bundle.p_m.leftCols<kFingerCount>() = start.tips_m;
  if (with_valleys)
    bundle.p_m.rightCols<kValleyCount>() =
        on_plane(std::span(bundle.tracks).subspan(kFingerCount), bundle.T_camera_body, camera, 0)
            .p_m;
  bundle.prior_m = bundle.p_m;
  bundle.prior_sigma_m = Eigen::Matrix3Xd::Constant(3, n, kShapePrior_m);
  bundle.prior_sigma_m.row(2).setConstant(kHeightPrior_m);
  if (with_valleys) bundle.prior_sigma_m.topRightCorner<2, kValleyCount>().setConstant(0.1);
}

// A nearly flat hand has two poses that look alike; with a better shape the right one shows.
bool turn_to_better_poses(Bundle& bundle, std::span<const CalibrationView> views,
                          const std::vector<int>& used, const Camera& camera) {
  bool any = false;
  for (std::size_t i = 0; i < used.size(); ++i)
    for (const Eigen::Isometry3d& T : planar_poses(bundle.p_m, views[used[i]], camera))
      if (bundle.view_cost(i, T, camera) <
          0.9 * bundle.view_cost(i, bundle.T_camera_body[i], camera)) {
        bundle.T_camera_body[i] = T;
        any = true;
      }
  return any;
}

// Standard deviations of the tips along the hand's axes. Where the hand lies, how it is turned and
// how large it is (seven directions in the space of all tips) is convention or comes from outside,
// so errors in these directions are taken out.
Eigen::Matrix<double, 3, kFingerCount> shape_sigma_m(const Bundle& bundle,
                                                     const Eigen::Isometry3d& T_body_hand) {
  constexpr int kN = 3 * kFingerCount;
  const Eigen::Matrix3Xd tips = bundle.p_m.leftCols<kFingerCount>();
  const Eigen::Vector3d mean = tips.rowwise().mean();
  Eigen::Matrix<double, kN, 7> moves;
  Eigen::Matrix<double, kN, kN> R = Eigen::Matrix<double, kN, kN>::Zero();
  for (int k = 0; k < kFingerCount; ++k) {
    const Eigen::Vector3d d = tips.col(k) - mean;
    moves.block<3, 7>(3 * k, 0) << Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX().cross(d),
        Eigen::Vector3d::UnitY().cross(d), Eigen::Vector3d::UnitZ().cross(d), d;
    R.block<3, 3>(3 * k, 3 * k) = T_body_hand.linear().transpose();
  }
  const Eigen::Matrix<double, kN, kN> shape_only =
      Eigen::Matrix<double, kN, kN>::Identity() -
      moves * (moves.transpose() * moves).inverse() * moves.transpose();
  const Eigen::Matrix<double, kN, kN> in_hand = R * shape_only;
  const Eigen::Matrix<double, kN, 1> sigma =
      (in_hand * bundle.covariance_m2.topLeftCorner<kN, kN>() * in_hand.transpose())
          .diagonal()
          .cwiseMax(0)
          .cwiseSqrt();
  return Eigen::Map<const Eigen::Matrix<double, 3, kFingerCount>>(sigma.data());
}

// Factor that gives the hand its size.
double size_factor(const HandModel& hand, const KnownLength& known) {
  if (known.span_m) return *known.span_m / hand.span_m();
  const double average = fit_average_hand(hand.tips_m.topRows<2>()).scale;
  return known.hand_length_m.value_or(kAverageHandLength_m) / (average * kAverageHandLength_m);
}

void require_good(const SelfCalibration& out, const Bundle& bundle, const Camera& camera) {
  constexpr double kMaxError_m = 0.005;
  for (int k = 0; k < kFingerCount; ++k) {
    const double error_m =
        usual_error_m(bundle.tracks[k], bundle.T_camera_body, camera, bundle.p_m.col(k));
    if (error_m > kMaxError_m)
      throw CalibrationError(
          text("the fingers did not keep their places, the %s is off by %.0f mm "
               "in a third of the views: hold the hand stiff, fingers spread, "
               "and turn it as a whole",
               std::string(kFingerNames[k]).c_str(), 1000 * error_m));
  }
  if (out.turned_rad < 30 * kDegree)
    throw CalibrationError(
        text("the hand was seen from one side only, directions differ by %.0f "
             "degrees: turn it left, right, up and down by 30 degrees",
             out.turned_rad / kDegree));
}

}  // namespace

SelfCalibration self_calibrate_hand(std::span<const CalibrationView> views, const Camera& camera,
                                    const KnownLength& known) {
  SelfCalibration out;
  Layout layout{};
  const std::vector<int> candidates = views_of_one_face(views, layout);
  if (static_cast<int>(candidates.size()) < kMinViews)
    throw CalibrationError(
        text("five fingertips are seen in %zu of %zu frames, %d are needed: "
             "show the open hand, fingers spread",
             candidates.size(), views.size(), kMinViews));
  Bundle bundle;
  const HandModel start = average_adult_hand().for_layout(layout);
  out.views_used = choose_keyframes(views, candidates, start, camera, bundle);
  if (static_cast<int>(out.views_used.size()) < kMinViews)
    throw CalibrationError(
        text("only %zu different views of the hand, %d are needed: turn it "
             "left, right, up and down, nearer and farther",
             out.views_used.size(), kMinViews));
  set_points(bundle, views, out.views_used, start, camera);
  constexpr int kMaxRounds = 5;
  bundle.adjust(camera);
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!turn_to_better_poses(bundle, views, out.views_used, camera)) break;
    bundle.adjust(camera);
  }
  std::vector<Viewpoint> viewpoints;
  for (const auto& T : bundle.T_camera_body)
    viewpoints.push_back(
        viewpoint(T, bundle.p_m.rowwise().mean(), Eigen::Vector3d::UnitZ(), camera));
  out.turned_rad = directions_span_rad(viewpoints);
  require_good(out, bundle, camera);

  HandPoints points{.tips_m = bundle.p_m.leftCols<kFingerCount>(),
                    .has_valleys = bundle.p_m.cols() > kFingerCount};
  if (points.has_valleys) points.valleys_m = bundle.p_m.rightCols<kValleyCount>();
  const Eigen::Isometry3d T_body_hand = hand_frame(points, Eigen::Vector3d::UnitZ());
  out.hand = hand_model(points, T_body_hand);
  std::vector<Eigen::Isometry3d> T_camera_hand;
  for (const Eigen::Isometry3d& T : bundle.T_camera_body) T_camera_hand.push_back(T * T_body_hand);
  triangulate_axes(views, out.views_used, T_camera_hand, camera, out.hand);
  const double factor = size_factor(out.hand, known);
  for (auto* const points_m : {&out.hand.tips_m, &out.hand.axis_ends_m, &out.hand.axis_roots_m})
    *points_m *= factor;
  out.hand.valleys_m *= factor;
  out.hand.tips_sigma_m = factor * shape_sigma_m(bundle, T_body_hand);
  out.hand.source = HandSource::self;
  out.hand.rms_px = std::numbers::sqrt2 * bundle.sigma_px;
  out.hand.average_scale = !known.span_m && !known.hand_length_m;
  return out;
}

}  // namespace handyar
