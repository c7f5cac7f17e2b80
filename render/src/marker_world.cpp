// SPDX-License-Identifier: MIT
#include "handyar/render/marker_world.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "handyar/opencv/aruco.hpp"
#include "handyar/opencv/types.hpp"

namespace handyar::render {
namespace {

using Eigen::Isometry3d;
using Corners = std::vector<cv::Point2f>;  // top left, top right, bottom right, bottom left

constexpr double kHold_s = 1.5;    // without any marker the world stays for so long
constexpr int kAverage = 40;       // frames that a learned place is the mean of
constexpr double kMoved_px = 4.0;  // a marker this far from its place was moved
constexpr int kMovedFrames = 10;

std::map<int, Corners> detect(const cv::Mat& gray, int dictionary) {
  std::map<int, Corners> seen;
  for (SeenMarker& m : detect_markers(gray, dictionary))
    seen.emplace(m.id, std::move(m.corners_px));
  return seen;
}

/// Mean of poses, one after the other.
struct MeanPose {
  Isometry3d T = Isometry3d::Identity();
  int count = 0;

  void add(const Isometry3d& next) {
    count = std::min(count + 1, kAverage);
    const double weight = 1.0 / count;
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(T.linear()).slerp(weight, Eigen::Quaterniond(next.linear()));
    T.translation() += weight * (next.translation() - T.translation());
    T.linear() = q.normalized().toRotationMatrix();
  }
};

}  // namespace

struct MarkerWorld::Impl {
  struct Entry {
    SceneMarker marker;
    MeanPose T_world_marker;  // count 0: its place is not known yet
    int misplaced = 0;        // frames in a row that showed it elsewhere
  };
  struct View {
    Entry* entry;
    Corners corners_px;
    std::vector<Isometry3d> T_camera_marker;  // both solutions of a plane, the better first
  };

  std::vector<Entry> entries;
  std::optional<Isometry3d> T_camera_world;
  double seen_s = 0, now_s = 0;

  std::vector<View> look(const cv::Mat& gray, const Camera& camera) {
    std::map<int, std::map<int, Corners>> seen;
    for (const Entry& e : entries) {
      const int number = *dictionary_number(e.marker.dictionary);
      if (!seen.contains(number)) seen[number] = detect(gray, number);
    }
    std::vector<View> views;
    for (Entry& e : entries) {
      const auto& of_kind = seen[*dictionary_number(e.marker.dictionary)];
      const auto it = of_kind.find(e.marker.id);
      if (it == of_kind.end()) continue;
      std::vector<cv::Mat> r, t;
      cv::solvePnPGeneric(marker_corners_m(e.marker.size_m), it->second, camera_matrix(camera),
                          camera.distortion, r, t, false, cv::SOLVEPNP_IPPE_SQUARE);
      View view{&e, it->second, {}};
      for (std::size_t i = 0; i < r.size(); ++i)
        view.T_camera_marker.push_back(isometry(r[i], t[i]));
      if (!view.T_camera_marker.empty()) views.push_back(std::move(view));
    }
    return views;
  }

  static double error_px(const View& view, const Isometry3d& T_camera_marker,
                         const Camera& camera) {
    double sum = 0;
    const auto corners = marker_corners_m(view.entry->marker.size_m);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector3d p =
          T_camera_marker * Eigen::Vector3d(corners[i].x, corners[i].y, corners[i].z);
      if (p.z() <= 0) return std::numeric_limits<double>::infinity();
      const Eigen::Vector2d px = camera.project(p);
      sum += (px - Eigen::Vector2d(view.corners_px[i].x, view.corners_px[i].y)).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(corners.size()));
  }

  using Views = std::vector<const View*>;

  static double world_error_px(const View& view, const Isometry3d& T, const Camera& camera) {
    return error_px(view, T * view.entry->T_world_marker.T, camera);
  }

  /// Those of `views` that a pose of the world explains to within `limit_px`.
  static Views explained(const Views& views, const Isometry3d& T, double limit_px,
                         const Camera& camera) {
    Views good;
    for (const View* view : views)
      if (world_error_px(*view, T, camera) < limit_px) good.push_back(view);
    return good;
  }

  static Isometry3d refined(const Isometry3d& T, const Views& views, const Camera& camera) {
    std::vector<cv::Point3d> points_m;
    std::vector<cv::Point2d> points_px;
    for (const View* view : views) {
      for (const cv::Point3d& c : marker_corners_m(view->entry->marker.size_m)) {
        const Eigen::Vector3d p = view->entry->T_world_marker.T * Eigen::Vector3d(c.x, c.y, c.z);
        points_m.emplace_back(p.x(), p.y(), p.z());
      }
      points_px.insert(points_px.end(), view->corners_px.begin(), view->corners_px.end());
    }
    cv::Mat R, r, t;
    cv::eigen2cv(Eigen::Matrix3d(T.linear()), R);
    cv::eigen2cv(Eigen::Vector3d(T.translation()), t);
    cv::Rodrigues(R, r);
    cv::solvePnPRefineLM(points_m, points_px, camera_matrix(camera), camera.distortion, r, t);
    return isometry(r, t);
  }

  /// Pixels that a leap of the world from one frame to the next counts as.
  double leap_px(const Isometry3d& T) const {
    if (!T_camera_world) return 0;
    const double turn_rad =
        Eigen::AngleAxisd(T_camera_world->linear().transpose() * T.linear()).angle();
    return 3 * turn_rad + 20 * (T.translation() - T_camera_world->translation()).norm();
  }

  /// The world from all markers in view whose place is known; empty without one. Every single
  /// marker leaves two answers, and some may have been moved: the answer that explains most of them
  /// wins.
  std::optional<Isometry3d> solve(const std::vector<View>& views, const Camera& camera) const {
    Views known, trusted;
    for (const View& view : views) {
      if (view.entry->T_world_marker.count == 0) continue;
      known.push_back(&view);
      if (view.entry->misplaced == 0) trusted.push_back(&view);
    }
    if (!trusted.empty()) known = trusted;
    std::vector<Isometry3d> candidates;
    if (T_camera_world) candidates.push_back(*T_camera_world);
    for (const View* view : known)
      for (const Isometry3d& T : view->T_camera_marker)
        candidates.push_back(T * view->entry->T_world_marker.T.inverse());

    std::optional<Isometry3d> best;
    std::size_t most = 0;
    double least_px = 0;
    for (Isometry3d T : candidates) {
      Views good = explained(known, T, 4 * kMoved_px, camera);
      if (good.empty()) continue;
      T = refined(T, good, camera);
      const std::size_t before = good.size();
      good = explained(known, T, kMoved_px, camera);
      if (good.empty()) continue;
      if (good.size() != before) T = refined(T, good, camera);
      double cost_px = leap_px(T);
      for (const View* view : good)
        cost_px += world_error_px(*view, T, camera) / static_cast<double>(good.size());
      if (good.size() < most || (good.size() == most && cost_px >= least_px)) continue;
      best = T;
      most = good.size();
      least_px = cost_px;
    }
    return best;
  }

  /// Where the markers stand in the world, as far as the scene has not said it.
  void learn(const std::vector<View>& views, const Camera& camera) {
    for (const View& view : views) {
      Entry& e = *view.entry;
      if (e.marker.T_world_marker) continue;
      const bool moved = e.T_world_marker.count > 0 &&
                         error_px(view, *T_camera_world * e.T_world_marker.T, camera) > kMoved_px;
      e.misplaced = moved ? e.misplaced + 1 : 0;
      if (e.misplaced > kMovedFrames) e.T_world_marker.count = e.misplaced = 0;
      if (e.misplaced > 0) continue;
      // Of a plane's two answers, the one that agrees with its place so far.
      Isometry3d found = T_camera_world->inverse() * view.T_camera_marker.front();
      if (e.T_world_marker.count > 0)
        for (const Isometry3d& T : view.T_camera_marker) {
          const Isometry3d other = T_camera_world->inverse() * T;
          const auto turn = [&](const Isometry3d& a) {
            return Eigen::AngleAxisd(e.T_world_marker.T.linear().transpose() * a.linear()).angle();
          };
          if (turn(other) < turn(found)) found = other;
        }
      e.T_world_marker.add(found);
    }
  }
};

MarkerWorld::MarkerWorld(std::vector<SceneMarker> markers) : impl_(std::make_unique<Impl>()) {
  if (!markers.empty()) require_aruco();
  for (SceneMarker& m : markers) {
    Impl::Entry e{m, {}, 0};
    if (m.T_world_marker) e.T_world_marker = {*m.T_world_marker, 1};
    impl_->entries.push_back(std::move(e));
  }
}
MarkerWorld::~MarkerWorld() = default;
MarkerWorld::MarkerWorld(MarkerWorld&&) noexcept = default;
MarkerWorld& MarkerWorld::operator=(MarkerWorld&&) noexcept = default;

void MarkerWorld::observe(const cv::Mat& frame_bgr, const Camera& camera, double time_s) {
  Impl& im = *impl_;
  im.now_s = time_s;
  cv::Mat gray;
  cv::cvtColor(frame_bgr, gray, cv::COLOR_BGR2GRAY);
  const std::vector<Impl::View> views = im.look(gray, camera);
  if (views.empty()) return;
  std::optional<Isometry3d> T = im.solve(views, camera);
  const bool nothing_known = std::all_of(im.entries.begin(), im.entries.end(),
                                         [](const auto& e) { return e.T_world_marker.count == 0; });
  if (!T && nothing_known) {
    // The first marker ever seen is the world's origin.
    views.front().entry->T_world_marker = {Isometry3d::Identity(), kAverage};
    T = views.front().T_camera_marker.front();
  }
  if (!T) return;
  im.T_camera_world = T;
  im.seen_s = time_s;
  im.learn(views, camera);
}

std::optional<Eigen::Isometry3d> MarkerWorld::T_camera_marker(int index) const {
  const Impl& im = *impl_;
  if (!im.T_camera_world || im.now_s - im.seen_s > kHold_s) return std::nullopt;
  if (index < 0) return im.T_camera_world;
  const MeanPose& place = im.entries[static_cast<std::size_t>(index)].T_world_marker;
  if (place.count == 0) return std::nullopt;
  return *im.T_camera_world * place.T;
}

}  // namespace handyar::render
