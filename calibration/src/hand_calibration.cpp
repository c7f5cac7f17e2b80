// SPDX-License-Identifier: MIT
#include "handyar/calibration/hand_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "handyar/calibration/camera_calibration.hpp"
#include "handyar/stages/hand_figure.hpp"
#include "text.hpp"

namespace handyar {
namespace {

constexpr int kMaxHandViews = 60;
constexpr double kTypicalHeight_m = 0.01;  // of the visible face of a hand that lies on a table

const Eigen::Vector2d kNotSeen =
    Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

struct Sights {
  std::vector<int> views;
  std::vector<Eigen::Isometry3d> T_camera_board;
};

// Most boards look the same after a turn, so views may have taken different corners for the first.
// The hand lies on one side and tells.
void agree_on_first_corner(Sights& sights, std::span<const CalibrationView> views,
                           const Camera& camera, const Board& board) {
  const std::vector<Eigen::Isometry3d> turns = board.turns();
  Eigen::Vector3d side = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < sights.views.size(); ++i) {
    Eigen::Vector3d towards_hand = -board.centre_m();
    for (const Tip& t : views[sights.views[i]].tips)
      towards_hand += unproject_to_plane(t.px, sights.T_camera_board[i], camera, kTypicalHeight_m) /
                      kFingerCount;
    towards_hand.z() = 0;
    const auto seen_from = [&](const Eigen::Isometry3d& turn) -> Eigen::Vector3d {
      return turn.linear().transpose() * towards_hand;
    };
    const Eigen::Isometry3d turn = *std::max_element(
        turns.begin(), turns.end(), [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
          return side.dot(seen_from(a)) < side.dot(seen_from(b));
        });
    sights.T_camera_board[i] = sights.T_camera_board[i] * turn;
    side += seen_from(turn);
  }
}

Sights choose_views(std::span<const CalibrationView> views, const Camera& camera,
                    const Board& board) {
  const double max_blur_px = kMaxBlurPx * std::max(camera.width_px, camera.height_px) / 640.0;
  Sights all;
  std::vector<Viewpoint> viewpoints;
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    if (!views[i].board_seen() || !views[i].hand_seen() || views[i].blur_px > max_blur_px) continue;
    all.views.push_back(i);
    all.T_camera_board.push_back(board_pose(views[i].corners_px, board, camera));
    viewpoints.push_back(
        viewpoint(all.T_camera_board.back(), board.centre_m(), -Eigen::Vector3d::UnitZ(), camera));
  }
  if (static_cast<int>(all.views.size()) < kMinViews)
    throw CalibrationError(
        text("the hand and the whole board are seen together in %zu frames, %d "
             "are needed: lay the hand beside the board, fingers spread, and "
             "keep both in the picture",
             all.views.size(), kMinViews));
  Sights chosen;
  for (int k : choose_diverse(viewpoints, kMaxHandViews)) {
    chosen.views.push_back(all.views[k]);
    chosen.T_camera_board.push_back(all.T_camera_board[k]);
  }
  if (static_cast<int>(chosen.views.size()) < kMinViews)
    throw CalibrationError(
        text("only %zu different views of hand and board, %d are needed: move "
             "the camera around them, nearer and farther",
             chosen.views.size(), kMinViews));
  agree_on_first_corner(chosen, views, camera, board);
  return chosen;
}

template <std::size_t N>
std::vector<PixelTrack> tracks(std::span<const CalibrationView> views, const std::vector<int>& used,
                               std::array<Tip, N> CalibrationView::*places) {
  std::vector<PixelTrack> out(N);
  for (int i : used)
    for (std::size_t k = 0; k < N; ++k) {
      const Tip& t = (views[i].*places)[k];
      out[k].push_back(t.seen ? t.px : kNotSeen);
    }
  return out;
}

// A hand that moved leaves no point that fits all views, or different ones in each half of the
// time.
void require_still(const StillPoints& tips, std::span<const PixelTrack> tip_tracks,
                   std::span<const Eigen::Isometry3d> poses, const Camera& camera) {
  constexpr double kMaxError_m = 0.003, kMaxShift_m = 0.006;
  const char* advice = "keep the hand still on the table while the camera moves";
  Eigen::Index worst = 0;
  const double error_m = tips.error_m.maxCoeff(&worst);
  if (error_m > kMaxError_m)
    throw CalibrationError(
        text("the hand moved: its %s fingertip is off by %.0f mm in a third of the "
             "views: %s",
             std::string(kFingerNames[worst]).c_str(), 1000 * error_m, advice));
  const std::size_t half = poses.size() / 2;
  std::vector<PixelTrack> early, late;
  for (const PixelTrack& t : tip_tracks) {
    early.emplace_back(t.begin(), t.begin() + half);
    late.emplace_back(t.begin() + half, t.end());
  }
  const double height_m = -tips.p_m.row(2).mean();
  const StillPoints a = on_plane(early, poses.first(half), camera, height_m);
  const StillPoints b = on_plane(late, poses.subspan(half), camera, height_m);
  const double shift_m = (a.p_m - b.p_m).colwise().norm().maxCoeff(&worst);
  if (shift_m > kMaxShift_m)
    throw CalibrationError(
        text("the hand moved: its %s fingertip lies %.0f mm elsewhere in the "
             "second half of the recording: %s",
             std::string(kFingerNames[worst]).c_str(), 1000 * shift_m, advice));
}

void require_plausible(double span_m, const Board& board) {
  constexpr double kLeastSpan_m = 0.10, kLargestSpan_m = 0.29;
  if (span_m >= kLeastSpan_m && span_m <= kLargestSpan_m) return;
  throw CalibrationError(
      text("the hand would measure %.0f mm from thumb tip to little fingertip: "
           "are the board's squares really %.4g mm?",
           1000 * span_m, 1000 * board.square_m));
}

bool seen_often(std::span<const PixelTrack> tracks) {
  return std::all_of(tracks.begin(), tracks.end(), [](const PixelTrack& t) {
    return std::count_if(t.begin(), t.end(), [](const auto& px) { return px.allFinite(); }) >=
           kMinViews;
  });
}

}  // namespace

HandCalibration calibrate_hand(std::span<const CalibrationView> views, const Camera& camera,
                               const Board& board, double thickness_m) {
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitZ();  // out of the board
  const Sights sights = choose_views(views, camera, board);
  const auto tip_tracks = tracks(views, sights.views, &CalibrationView::tips);
  const auto web_tracks = tracks(views, sights.views, &CalibrationView::webs);
  const auto& poses = sights.T_camera_board;

  HandCalibration out;
  out.views_used = sights.views;
  out.tips = triangulate(tip_tracks, poses, camera);
  require_plausible((out.tips.p_m.col(0) - out.tips.p_m.col(4)).norm(), board);
  require_still(out.tips, tip_tracks, poses, camera);
  out.plane_tips = on_plane(tip_tracks, poses, camera, thickness_m);

  HandPoints points{.tips_m = out.tips.p_m, .has_webs = seen_often(web_tracks)};
  HandPoints plane_points{.tips_m = out.plane_tips.p_m, .has_webs = points.has_webs};
  if (points.has_webs) {
    points.webs_m = triangulate(web_tracks, poses, camera).p_m;
    plane_points.webs_m = on_plane(web_tracks, poses, camera, thickness_m).p_m;
  }
  out.T_board_hand = hand_frame(points, up);
  out.by_triangulation = hand_model(points, out.T_board_hand);
  out.by_plane = hand_model(plane_points, hand_frame(plane_points, up));
  out.by_triangulation.rms_px = out.tips.rms_px;
  out.by_plane.rms_px = out.plane_tips.rms_px;
  out.height_m = -out.tips.p_m.row(2).mean();
  out.by_triangulation.thickness_m = std::max(out.height_m, 0.0);
  out.by_plane.thickness_m = thickness_m;
  out.by_triangulation.source = out.by_plane.source = HandSource::checkerboard;
  const Eigen::Matrix3d R_hand_board = out.T_board_hand.linear().transpose();
  for (int k = 0; k < kFingerCount; ++k) {
    const Eigen::Matrix3d c = R_hand_board * out.tips.covariance_m2[k] * R_hand_board.transpose();
    out.by_triangulation.tips_sigma_m.col(k) = c.diagonal().cwiseSqrt();
  }
  // Fingertips alone do not tell a small hand from one whose fingers lie together: what its outline
  // told the tracker of it does.
  const CalibrationView& last = views[sights.views.back()];
  out.by_triangulation.figure =
      last.hand.figure ? estimate_figure(out.by_triangulation, *last.hand.figure, last.posture)
                       : estimate_figure(out.by_triangulation);
  out.rms_difference_m =
      std::sqrt((out.tips.p_m - out.plane_tips.p_m).topRows<2>().colwise().squaredNorm().mean());
  return out;
}

}  // namespace handyar
