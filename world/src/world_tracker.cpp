// SPDX-License-Identifier: MIT
#include "handyar/world/world_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "free_view.hpp"
#include "hand_at_rest.hpp"
#include "map_worker.hpp"
#include "matching.hpp"
#include "picture.hpp"
#include "recognition.hpp"
#include "resection.hpp"
#include "rigid.hpp"

namespace handyar::world {
namespace {

constexpr std::size_t kMostPoints = 150;  // looked for in a frame

// A pose is believed when so many points agree, and so great a share of those that should be seen,
// all over so many of the picture's 12 cells. After a loss more is asked.
struct Belief {
  std::size_t inliers;
  double share;
  int cells;
};
constexpr Belief kGoOn{12, 0.25, 3};
constexpr Belief kRecognise{25, 0.45, 4};

constexpr double kFollowRadius_px = 8;  // in a picture 640 pixels wide
constexpr double kConfirmRadius_px = 12;

// When the view differs so much from every keyframe, it becomes one.
constexpr double kNewAngle_rad = 0.14;
constexpr double kNewDistance = 0.2;  // of the distance to what is seen
constexpr double kLeastBetween_s = 0.25;
constexpr double kAfterHand_s = 0.4;
constexpr std::size_t kMostKeyframes = 60;
constexpr double kTries_s = 0.07;  // between attempts to recognise

constexpr double kNever_s = -1e9;

struct Pose {
  Eigen::Isometry3d T_camera_world = Eigen::Isometry3d::Identity();
  double time_s = 0;
};

}  // namespace

std::string_view name(WorldState state) noexcept {
  switch (state) {
    case WorldState::none:
      return "none";
    case WorldState::setting:
      return "setting";
    case WorldState::tracked:
      return "tracked";
    case WorldState::lost:
      break;
  }
  return "lost";
}

struct WorldTracker::Impl {
  Impl(const Camera& of, Mapping mapping) : camera(of), worker(mapping) {}

  WorldResult process(const cv::Mat& bgr, double time_s, const HandInWorld& hand);
  void adopt(std::shared_ptr<const WorldMap> next);

  Camera camera;
  MapWorker worker;
  std::shared_ptr<const WorldMap> map;

 private:
  struct Seen {
    Resection pose;
    Matches matches;
    std::size_t reference;  // the keyframe looked for
  };

  void set_frame(double time_s, const HandInWorld& hand, WorldResult& result);
  std::optional<Seen> look(const Eigen::Isometry3d& guess, double radius_px,
                           const Belief& belief) const;
  std::optional<Seen> go_on(double time_s) const;
  std::optional<Seen> find_again(double time_s);
  void take(const Seen& seen, double time_s, WorldResult& result);
  void offer_keyframe(const Seen& seen, double time_s);
  std::size_t reference_for(const Eigen::Isometry3d& T_camera_world) const;
  double scale() const { return camera.width_px / 640.0; }

  HandAtRest at_rest_;
  Picture picture_, last_picture_;
  cv::Mat free_;
  std::optional<Pose> last_, before_last_;
  std::vector<Observation> last_seen_;
  std::vector<int> tried_, found_;
  double last_keyframe_s_ = kNever_s, hand_gone_s_ = kNever_s, last_try_s_ = kNever_s;
};

WorldResult WorldTracker::Impl::process(const cv::Mat& bgr, double time_s,
                                        const HandInWorld& hand) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  last_picture_ = std::move(picture_);
  picture_ = make_picture(grey);
  free_ = free_of_hand(hand, camera);
  if (!free_.empty()) hand_gone_s_ = time_s;

  WorldResult result;
  if (auto next = worker.take()) adopt(std::move(next));
  if (!map) {
    set_frame(time_s, hand, result);
    return result;
  }
  result.state = WorldState::lost;
  result.scale_assumed = map->scale_assumed;
  const auto seen = last_ ? go_on(time_s) : find_again(time_s);
  if (!seen) {
    last_.reset();
    before_last_.reset();
    return result;
  }
  take(*seen, time_s, result);
  if (!worker.busy()) offer_keyframe(*seen, time_s);
  return result;
}

void WorldTracker::Impl::set_frame(double time_s, const HandInWorld& hand, WorldResult& result) {
  const HandAtRest::Rest rest = at_rest_.update(picture_, time_s, hand, free_, camera);
  if (rest == HandAtRest::Rest::no) return;
  result.state = WorldState::setting;
  if (rest == HandAtRest::Rest::lying) return;
  auto first = first_map(picture_.grey, free_, camera, hand);
  if (!first) return;
  adopt(std::make_shared<const WorldMap>(std::move(*first)));
  const auto seen = look(*hand.T_camera_hand, kFollowRadius_px * scale(), kGoOn);
  if (!seen) {
    map.reset();
    return;
  }
  last_keyframe_s_ = time_s;
  result.scale_assumed = map->scale_assumed;
  take(*seen, time_s, result);
}

// Points and their numbers may be others in the next map; what was seen last is where they are then
// expected.
void WorldTracker::Impl::adopt(std::shared_ptr<const WorldMap> next) {
  map = std::move(next);
  tried_.assign(map->points.size(), 0);
  found_.assign(map->points.size(), 0);
  last_seen_.clear();
  if (!last_) return;
  for (const Observation& o : map->keyframes[reference_for(last_->T_camera_world)].observations) {
    const MapPoint& point = map->points[static_cast<std::size_t>(o.point)];
    if (const auto px = pixel_of(point.p_world_m, {camera, last_->T_camera_world}))
      last_seen_.push_back({o.point, *px});
  }
}

/// The keyframe of which most is in view, from most nearly the same side.
std::size_t WorldTracker::Impl::reference_for(const Eigen::Isometry3d& T_camera_world) const {
  std::vector<double> weights(map->points.size(), -1);  // of a point in view, its distance
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (pixel_of(map->points[i].p_world_m, {camera, T_camera_world}))
      weights[i] = (T_camera_world * map->points[i].p_world_m).norm();
  std::size_t best = 0;
  double most = -1;
  for (std::size_t k = 0; k < map->keyframes.size(); ++k) {
    const Keyframe& keyframe = map->keyframes[k];
    double sum = 0;
    for (const Observation& o : keyframe.observations) {
      const double distance_m = weights[static_cast<std::size_t>(o.point)];
      if (distance_m < 0) continue;
      const Eigen::Vector3d& p = map->points[static_cast<std::size_t>(o.point)].p_world_m;
      const double angle = parallax_rad(T_camera_world, keyframe.T_camera_world, p);
      const double size = std::log(distance_m / (keyframe.T_camera_world * p).norm());
      sum += std::exp(-(angle * angle) / 0.1 - size * size / 0.2);
    }
    if (sum <= most) continue;
    most = sum;
    best = k;
  }
  return best;
}

std::optional<WorldTracker::Impl::Seen> WorldTracker::Impl::look(const Eigen::Isometry3d& guess,
                                                                 double radius_px,
                                                                 const Belief& belief) const {
  Seen seen;
  seen.reference = reference_for(guess);
  seen.matches = find_in_picture(*map, map->keyframes[seen.reference], picture_, free_,
                                 {camera, guess}, radius_px, kMostPoints);
  seen.pose = resect(*map, seen.matches.seen, camera, guess);
  const std::size_t inliers = seen.pose.inliers.size();
  const bool believed = inliers >= belief.inliers &&
                        static_cast<double>(inliers) >=
                            belief.share * static_cast<double>(seen.matches.expected.size()) &&
                        cells_with(seen.pose.inliers, camera) >= belief.cells;
  return believed ? std::optional(std::move(seen)) : std::nullopt;
}

// The camera goes on as it went; the flow from the last frame tells it better, and the keyframe
// best.
std::optional<WorldTracker::Impl::Seen> WorldTracker::Impl::go_on(double time_s) const {
  Eigen::Isometry3d guess = last_->T_camera_world;
  if (before_last_) {
    const Eigen::Isometry3d step = last_->T_camera_world * before_last_->T_camera_world.inverse();
    const double share =
        std::clamp((time_s - last_->time_s) / (last_->time_s - before_last_->time_s), 0.0, 2.0);
    const Eigen::AngleAxisd turn(step.linear());
    guess.linear() =
        Eigen::AngleAxisd(share * turn.angle(), turn.axis()) * last_->T_camera_world.linear();
    guess.translation() += share * (step * last_->T_camera_world).translation() -
                           share * last_->T_camera_world.translation();
  }
  std::vector<Observation> followed =
      follow(*map, last_picture_, last_seen_, picture_, {camera, guess});
  std::erase_if(followed, [&](const Observation& o) { return !is_free(free_, o.px); });
  const Resection flow = resect(*map, followed, camera, guess);
  if (flow.inliers.size() >= kGoOn.inliers) guess = flow.T_camera_world;
  return look(guess, kFollowRadius_px * scale(), kGoOn);
}

std::optional<WorldTracker::Impl::Seen> WorldTracker::Impl::find_again(double time_s) {
  if (time_s - last_try_s_ < kTries_s) return std::nullopt;
  last_try_s_ = time_s;
  const auto guess = recognise(*map, picture_, free_, camera);
  if (!guess) return std::nullopt;
  const auto nearly = look(*guess, kConfirmRadius_px * scale(), kGoOn);
  if (!nearly) return std::nullopt;
  return look(nearly->pose.T_camera_world, kFollowRadius_px / 2 * scale(), kRecognise);
}

void WorldTracker::Impl::take(const Seen& seen, double time_s, WorldResult& result) {
  for (const int point : seen.matches.expected) ++tried_[static_cast<std::size_t>(point)];
  for (const Observation& o : seen.matches.seen) ++found_[static_cast<std::size_t>(o.point)];
  before_last_ = last_;
  last_ = Pose{seen.pose.T_camera_world, time_s};
  last_seen_ = seen.pose.inliers;
  result.state = WorldState::tracked;
  result.T_camera_world = seen.pose.T_camera_world;
  result.points = static_cast<int>(seen.matches.expected.size());
  result.inliers = static_cast<int>(seen.pose.inliers.size());
  result.rms_px = seen.pose.rms_px;
  result.sigma_rotation_rad = sigma_rotation_rad(seen.pose.covariance);
  result.sigma_translation_m = sigma_translation_m(seen.pose.covariance);
}

void WorldTracker::Impl::offer_keyframe(const Seen& seen, double time_s) {
  if (map->keyframes.size() >= kMostKeyframes || time_s - last_keyframe_s_ < kLeastBetween_s)
    return;
  const Keyframe& reference = map->keyframes[seen.reference];
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Observation& o : seen.pose.inliers)
    centre += map->points[static_cast<std::size_t>(o.point)].p_world_m /
              static_cast<double>(seen.pose.inliers.size());
  const Eigen::Isometry3d& T = seen.pose.T_camera_world;
  const double distance_m = (T * centre).norm();
  const double other_m = (reference.T_camera_world * centre).norm();
  const bool turned = parallax_rad(T, reference.T_camera_world, centre) > kNewAngle_rad;
  const bool nearer = std::abs(std::log(distance_m / other_m)) > kNewDistance;
  const bool panned =
      2 * seen.matches.expected.size() < std::min(kMostPoints, reference.observations.size());
  const bool uncovered = reference.hand_in_view && time_s - hand_gone_s_ > kAfterHand_s;
  if (!turned && !nearer && !panned && !uncovered) return;
  if (!free_.empty() && !turned) return;  // the hand will go
  last_keyframe_s_ = time_s;
  worker.start(map, {picture_.grey, free_, T, seen.matches.seen, tried_, found_});
}

WorldTracker::WorldTracker(const Camera& camera, Mapping mapping)
    : impl_(std::make_unique<Impl>(camera, mapping)) {}

WorldTracker::WorldTracker(const Camera& camera, WorldMap map, Mapping mapping)
    : WorldTracker(camera, mapping) {
  impl_->adopt(std::make_shared<const WorldMap>(std::move(map)));
}

WorldTracker::~WorldTracker() = default;
WorldTracker::WorldTracker(WorldTracker&&) noexcept = default;
WorldTracker& WorldTracker::operator=(WorldTracker&&) noexcept = default;

WorldResult WorldTracker::process(const cv::Mat& bgr, double time_s, const HandInWorld& hand) {
  return impl_->process(bgr, time_s, hand);
}

std::shared_ptr<const WorldMap> WorldTracker::map() const noexcept { return impl_->map; }

}  // namespace handyar::world
