// SPDX-License-Identifier: MIT
#include "matching.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <optional>

#include "handyar/opencv/lens.hpp"
#include "handyar/opencv/types.hpp"

namespace handyar::world {
namespace {

constexpr double kMargin_px = 8;  // from the picture's edge: half a window
constexpr float kAlike = 0.75f;   // least correlation of two patches that show the same
constexpr double kLeastScale = 0.4, kMostScale = 2.5;  // of the keyframe in the picture
// What looks the same farther along a grain or an edge is not found but stays where it was guessed:
// the mean square gradient across is at least so much, or half of what is usual in a dull keyframe.
constexpr double kEnoughStructure = 1;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

bool within(const Eigen::Vector2d& px, const cv::Size& size) {
  return px.x() >= kMargin_px && px.y() >= kMargin_px && px.x() < size.width - kMargin_px &&
         px.y() < size.height - kMargin_px;
}

/// The homography by which the ground takes pixels of the keyframe to the picture; lenses'
/// distortion, which differs little from place to place, is left out.
std::optional<Eigen::Matrix3d> by_ground(const WorldMap& map, const Keyframe& keyframe,
                                         const View& view) {
  Eigen::Hyperplane<double, 3> plane = map.ground;
  plane.transform(Eigen::Affine3d(
      keyframe.T_camera_world));  // n . p + offset = 0 in the keyframe's camera frame
  if (std::abs(plane.offset()) < 0.02) return std::nullopt;  // seen edge-on
  const Eigen::Isometry3d T = view.T_camera_world * keyframe.T_camera_world.inverse();
  const Eigen::Matrix3d between =
      T.linear() - T.translation() * plane.normal().transpose() / plane.offset();
  const auto intrinsics = [](const Camera& c) {
    Eigen::Matrix3d K;
    K << c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1;
    return K;
  };
  return intrinsics(view.camera) * between * intrinsics(map.camera).inverse();
}

/// The middle one, which moves to the middle.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Between the pixels of a picture, x and y not negative and less than its last column and row.
float bilinear(const cv::Mat& grey, float x, float y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float right = x - static_cast<float>(column), low = y - static_cast<float>(row);
  const std::uint8_t* const above = grey.ptr(row) + column;
  const std::uint8_t* const below = grey.ptr(row + 1) + column;
  return (1 - low) * ((1 - right) * above[0] + right * above[1]) +
         low * ((1 - right) * below[0] + right * below[1]);
}

/// The square of 11 x 11 grey values round a point that is within() a picture, bilinear between
/// pixels.
class Patch {
 public:
  Patch(const cv::Mat& grey, const cv::Point2f& at) {
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j)
        greys_[static_cast<std::size_t>(i * kSide + j)] = bilinear(
            grey, at.x + static_cast<float>(j - kReach), at.y + static_cast<float>(i - kReach));
    for (const float value : greys_) mean_ += value / kSide / kSide;
    for (float& value : greys_) value -= mean_;
    for (const float value : greys_) deviation_ += value * value / kSide / kSide;
    deviation_ = std::sqrt(deviation_);
  }

  /// Mean square of the gradient, in the direction in which it is least.
  double structure() const {
    double xx = 0, yy = 0, xy = 0;
    for (int i = 1; i + 1 < kSide; ++i)
      for (int j = 1; j + 1 < kSide; ++j) {
        const float* const at = &greys_[static_cast<std::size_t>(i * kSide + j)];
        const double x = 0.5 * (at[1] - at[-1]), y = 0.5 * (at[kSide] - at[-kSide]);
        xx += x * x;
        yy += y * y;
        xy += x * y;
      }
    return (0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy)) / ((kSide - 2) * (kSide - 2));
  }

  float mean() const { return mean_; }
  float deviation() const { return deviation_; }

  /// Correlation, -1 .. 1; 0 where one of them shows nothing.
  friend float likeness(const Patch& a, const Patch& b) {
    if (std::min(a.deviation_, b.deviation_) < 0.5f) return 0;
    float sum = 0;
    for (std::size_t i = 0; i < a.greys_.size(); ++i) sum += a.greys_[i] * b.greys_[i];
    return sum / (kSide * kSide * a.deviation_ * b.deviation_);
  }

 private:
  static constexpr int kReach = 5, kSide = 2 * kReach + 1;
  std::array<float, kSide * kSide> greys_;  // less their mean
  float mean_ = 0, deviation_ = 0;
};

/// A keyframe laid over a picture, as far as it is needed; the rest is black.
class Overlaid {
 public:
  Overlaid(const Eigen::Matrix3d& H, const cv::Mat& keyframe, const cv::Size& size)
      : H_(H), keyframe_(keyframe), grey_(size, CV_8U, cv::Scalar(0)) {}

  void lay() {
    cv::Mat H_cv;
    cv::eigen2cv(H_, H_cv);
    cv::warpPerspective(keyframe_, grey_, H_cv, grey_.size());
  }

  /// Only squares round some pixels, which takes less time.
  void lay(std::span<const cv::Point2f> middles, int reach_px) {
    const Eigen::Matrix3f back = H_.inverse().cast<float>();
    const cv::Size inner(keyframe_.cols - 1, keyframe_.rows - 1);
    const cv::Point reach(reach_px, reach_px);
    for (const cv::Point2f& middle : middles) {
      const cv::Rect square =
          cv::Rect(cv::Point(middle) - reach, cv::Size(2 * reach_px + 1, 2 * reach_px + 1)) &
          cv::Rect({}, grey_.size());
      for (int y = square.y; y < square.br().y; ++y)
        for (int x = square.x; x < square.br().x; ++x) {
          const Eigen::Vector3f at =
              back * Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), 1);
          const float u = at.x() / at.z(), v = at.y() / at.z();
          if (!(u >= 0 && v >= 0 && u < static_cast<float>(inner.width) &&
                v < static_cast<float>(inner.height)))
            continue;
          grey_.at<std::uint8_t>(y, x) =
              static_cast<std::uint8_t>(bilinear(keyframe_, u, v) + 0.5f);
        }
    }
  }

  const cv::Mat& grey() const { return grey_; }

  /// Where a pixel of the keyframe lies; empty where its surroundings are stretched or pressed too
  /// much to be recognised, or do not lie in the picture.
  std::optional<Eigen::Vector2d> place(const Eigen::Vector2d& px) const {
    const Eigen::Vector3d h = H_ * px.homogeneous();
    if (h.z() <= 0) return std::nullopt;
    const double area = H_.determinant() / (h.z() * h.z() * h.z());
    if (!(area > kLeastScale * kLeastScale && area < kMostScale * kMostScale)) return std::nullopt;
    const Eigen::Vector2d at = h.hnormalized();
    return within(at, grey_.size()) ? std::optional(at) : std::nullopt;
  }

  std::vector<Patch> patches(std::span<const cv::Point2f> middles) const {
    std::vector<Patch> result;
    for (const cv::Point2f& middle : middles) result.emplace_back(grey_, middle);
    return result;
  }

  /// As bright and as rich in contrast as a picture, by patches of both that show about the same:
  /// cameras expose anew when they have looked elsewhere, and optical flow compares grey values.
  void expose_like(const cv::Mat& picture, std::span<const Patch> here,
                   std::span<const cv::Point2f> there) {
    std::vector<double> gains, offsets;
    std::vector<float> means;
    for (std::size_t i = 0; i < here.size(); ++i) {
      const Patch patch(picture, there[i]);
      gains.push_back(patch.deviation() / std::max(1.0f, here[i].deviation()));
      means.push_back(patch.mean());
    }
    const double gain = std::clamp(median(gains), 0.25, 4.0);
    for (std::size_t i = 0; i < here.size(); ++i)
      offsets.push_back(means[i] - gain * here[i].mean());
    grey_.convertTo(grey_, -1, gain, median(offsets));
  }

 private:
  Eigen::Matrix3d H_;
  const cv::Mat& keyframe_;
  cv::Mat grey_;
};

/// Those that optical flow can find, of the patches of a keyframe.
std::vector<bool> can_be_found(std::span<const Patch> patches) {
  std::vector<double> structures;
  for (const Patch& patch : patches) structures.push_back(patch.structure());
  std::vector<double> sorted = structures;
  const double least = std::min(kEnoughStructure, 0.75 * median(sorted));
  std::vector<bool> result;
  for (const double structure : structures) result.push_back(structure >= least);
  return result;
}

cv::Point2f point(const Eigen::Vector2d& px) {
  return {static_cast<float>(px.x()), static_cast<float>(px.y())};
}
Eigen::Vector2d pixel(const cv::Point2f& p) { return {p.x, p.y}; }

constexpr int kFlow = cv::OPTFLOW_USE_INITIAL_FLOW;
constexpr double kLeastEigenvalue = 2e-4;
const cv::TermCriteria kFlowEnd{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 15, 0.01};

}  // namespace

std::optional<Eigen::Vector2d> pixel_of(const Eigen::Vector3d& p_world, const View& view) {
  const Eigen::Vector3d p = view.T_camera_world * p_world;
  if (p.z() < 0.02 || p.head<2>().norm() > 2 * p.z()) return std::nullopt;
  const auto px = shown_at(view.camera, p);
  if (!px || !within(*px, {view.camera.width_px, view.camera.height_px})) return std::nullopt;
  return px;
}

std::optional<Eigen::Vector3d> on_ground(const Eigen::Vector2d& px, const View& view,
                                         const Eigen::Hyperplane<double, 3>& ground) {
  constexpr double kGrazing = 0.12, kFarthest_m = 3;
  const Eigen::Isometry3d T_world_camera = view.T_camera_world.inverse();
  const Eigen::Vector3d ray =
      (T_world_camera.linear() * view.camera.unproject(px).homogeneous()).normalized();
  const double along = -ground.normal().dot(ray);
  if (along < kGrazing) return std::nullopt;
  const double distance_m = ground.signedDistance(T_world_camera.translation()) / along;
  if (!(distance_m > 0.02 && distance_m < kFarthest_m)) return std::nullopt;
  return T_world_camera.translation() + distance_m * ray;
}

Matches find_in_picture(const WorldMap& map, const Keyframe& keyframe, const Picture& picture,
                        const cv::Mat& free, const View& view, double radius_px, std::size_t most) {
  Matches matches;
  const auto H = by_ground(map, keyframe, view);
  if (!H) return matches;
  Overlaid overlaid(*H, keyframe.grey, picture.grey.size());
  std::vector<int> points;
  std::vector<cv::Point2f> from, to;
  const std::size_t count = keyframe.observations.size();
  const std::size_t stride =
      std::max<std::size_t>(1, (count + most - 1) / std::max<std::size_t>(1, most));
  for (std::size_t i = 0; i < count; i += stride) {
    const Observation& o = keyframe.observations[i];
    const auto start = overlaid.place(o.px);
    const auto guess = pixel_of(map.points[static_cast<std::size_t>(o.point)].p_world_m, view);
    if (!start || !guess) continue;
    if (!free.empty() && free.at<std::uint8_t>(static_cast<int>(guess->y() + 0.5),
                                               static_cast<int>(guess->x() + 0.5)) == 0)
      continue;
    points.push_back(o.point);
    from.push_back(point(*start));
    to.push_back(point(*guess));
  }
  if (from.empty()) return matches;
  // Optical flow reaches as far as half its window; farther in smaller pictures.
  const int levels = radius_px < 0.6 * kFlowWindow_px.width ? 0 : 1;
  overlaid.lay(from, (kFlowWindow_px.width / 2 + 3) << levels);
  const std::vector<Patch> patches = overlaid.patches(from);
  const std::vector<bool> findable = can_be_found(patches);
  overlaid.expose_like(picture.grey, patches, to);
  const std::vector<cv::Point2f> guesses = to;
  std::vector<std::uint8_t> found;
  cv::calcOpticalFlowPyrLK(overlaid.grey(), picture.pyramid, from, to, found, cv::noArray(),
                           kFlowWindow_px, levels, kFlowEnd, kFlow, kLeastEigenvalue);
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!findable[i]) continue;
    matches.expected.push_back(points[i]);
    const Eigen::Vector2d px = pixel(to[i]);
    if (!found[i] || !within(px, picture.grey.size())) continue;
    if ((px - pixel(guesses[i])).norm() > radius_px) continue;
    if (likeness(patches[i], Patch(picture.grey, to[i])) < kAlike) continue;
    matches.seen.push_back({points[i], px});
  }
  return matches;
}

std::vector<Eigen::Vector2d> find_pixels(const WorldMap& map, const Keyframe& keyframe,
                                         std::span<const Eigen::Vector2d> px, const Keyframe& other,
                                         const Picture& other_picture) {
  constexpr double kRadius_px = 40;  // what stands on the ground is seen beside its foot
  std::vector<Eigen::Vector2d> result(px.size(), Eigen::Vector2d::Constant(kUnknown));
  const auto H = by_ground(map, keyframe, {map.camera, other.T_camera_world});
  if (!H) return result;
  Overlaid overlaid(*H, keyframe.grey, other.grey.size());
  std::vector<cv::Point2f> from;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < px.size(); ++i) {
    const auto start = overlaid.place(px[i]);
    if (!start) continue;
    from.push_back(point(*start));
    which.push_back(i);
  }
  if (from.empty()) return result;
  overlaid.lay();
  const std::vector<Patch> patches = overlaid.patches(from);
  const std::vector<bool> findable = can_be_found(patches);
  overlaid.expose_like(other.grey, patches, from);
  std::vector<cv::Point2f> to = from, back = from;
  std::vector<std::uint8_t> found, found_back;
  cv::calcOpticalFlowPyrLK(overlaid.grey(), other_picture.pyramid, from, to, found, cv::noArray(),
                           kFlowWindow_px, kFlowLevels, kFlowEnd, kFlow, kLeastEigenvalue);
  back = to;
  cv::calcOpticalFlowPyrLK(other_picture.pyramid, overlaid.grey(), to, back, found_back,
                           cv::noArray(), kFlowWindow_px, kFlowLevels, kFlowEnd, kFlow,
                           kLeastEigenvalue);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d at = pixel(to[i]);
    if (!findable[i] || !found[i] || !found_back[i] || !within(at, other.grey.size())) continue;
    if ((at - pixel(from[i])).norm() > kRadius_px) continue;
    if ((pixel(back[i]) - pixel(from[i])).norm() > 0.5) continue;
    if (likeness(patches[i], Patch(other.grey, to[i])) < kAlike) continue;
    result[which[i]] = at;
  }
  return result;
}

std::vector<Observation> follow(const WorldMap& map, const Picture& last,
                                std::span<const Observation> seen, const Picture& next,
                                const View& guess) {
  std::vector<Observation> followed;
  std::vector<cv::Point2f> from, to;
  for (const Observation& o : seen) {
    const auto px = pixel_of(map.points[static_cast<std::size_t>(o.point)].p_world_m, guess);
    from.push_back(point(o.px));
    to.push_back(px ? point(*px) : point(o.px));
  }
  if (from.empty()) return followed;
  std::vector<std::uint8_t> found;
  cv::calcOpticalFlowPyrLK(last.pyramid, next.pyramid, from, to, found, cv::noArray(),
                           kFlowWindow_px, kFlowLevels, kFlowEnd, kFlow, kLeastEigenvalue);
  for (std::size_t i = 0; i < from.size(); ++i)
    if (found[i] && within(pixel(to[i]), next.grey.size()))
      followed.push_back({seen[i].point, pixel(to[i])});
  return followed;
}

}  // namespace handyar::world
