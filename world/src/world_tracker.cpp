// SPDX-License-Identifier: MIT
#include "handyar/world/world_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "free_view.hpp"
#include "hand_at_rest.hpp"
#include "look.hpp"
#include "mapping.hpp"
#include "matching.hpp"
#include "picture.hpp"
#include "recognition.hpp"
#include "resection.hpp"
#include "rigid.hpp"
#include "worker.hpp"

namespace handyar::world {
namespace {

// A sure look is enough; else it is looked again from where it led. What was recognised is believed
// when the next frame shows it too, and then more is asked.
constexpr Belief kSure{25, kShareOfRight}, kGoOn{12, kShareOfRight}, kConfirm{25, 0.8};

// When the view differs so much from every keyframe, it becomes one.
constexpr double kNewAngle_rad = 0.14;
constexpr double kNewDistance = 0.2;  // of the distance to what is seen
constexpr double kLeastBetween_s = 0.25;
constexpr double kAfterHand_s = 0.4;
constexpr std::size_t kMostKeyframes = 60;

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

std::string_view name(Hindrance hindrance) noexcept {
  switch (hindrance) {
    case Hindrance::no_hand:
      return "no_hand";
    case Hindrance::unsure:
      return "unsure";
    case Hindrance::tilted:
      return "tilted";
    case Hindrance::bare:
      return "bare";
    case Hindrance::moving:
      return "moving";
    case Hindrance::off_ground:
      break;
  }
  return "off_ground";
}

struct WorldTracker::Impl {
  Impl(const Camera& of, Mapping mapping) : camera(of), worker(mapping) {}

  WorldResult process(const cv::Mat& bgr, double time_s, const HandInWorld& hand);
  void adopt(std::shared_ptr<const WorldMap> next);

  Camera camera;
  Worker worker;
  std::shared_ptr<const WorldMap> map;

 private:
  void set_frame(double time_s, const HandInWorld& hand, WorldResult& result);
  std::optional<Seen> go_on(double time_s) const;
  void search(double time_s);
  void take_done();
  void take(const Seen& seen, double time_s, WorldResult& result);
  void offer_keyframe(const Seen& seen, double time_s);

  HandAtRest at_rest_;
  Picture picture_, last_picture_;
  cv::Mat free_;
  std::optional<Pose> last_, before_last_;
  bool confirmed_ = false;  // last_ was not just recognised
  std::vector<Observation> last_seen_;
  std::vector<int> tried_, found_;
  double last_keyframe_s_ = kNever_s, hand_gone_s_ = kNever_s;
};

WorldResult WorldTracker::Impl::process(const cv::Mat& bgr, double time_s,
                                        const HandInWorld& hand) {
  CV_Assert(bgr.type() == CV_8UC3 && bgr.size() == cv::Size(camera.width_px, camera.height_px));
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  // Noise looks like structure along a grain, and what is followed there would stay where it was
  // guessed.
  cv::GaussianBlur(grey, grey, {5, 5}, 1.0);
  last_picture_ = std::move(picture_);
  picture_ = make_picture(grey);
  free_ = free_of_hand(hand, camera);
  if (!free_.empty()) hand_gone_s_ = time_s;

  WorldResult result;
  take_done();
  if (!map) {
    set_frame(time_s, hand, result);
    return result;
  }
  result.state = WorldState::lost;
  result.scale_assumed = map->scale_assumed;
  const auto seen = last_ ? go_on(time_s) : std::nullopt;
  if (!seen) {
    search(time_s);
    return result;
  }
  take(*seen, time_s, result);
  if (!worker.busy()) offer_keyframe(*seen, time_s);
  return result;
}

void WorldTracker::Impl::set_frame(double time_s, const HandInWorld& hand, WorldResult& result) {
  const HandAtRest::Rest rest = at_rest_.update(picture_, time_s, hand, free_, camera);
  result.hindrance = at_rest_.hindrance();
  if (rest == HandAtRest::Rest::no) return;
  result.state = WorldState::setting;
  if (rest == HandAtRest::Rest::lying) return;
  std::optional<Seen> seen;
  if (auto first = first_map(picture_.grey, free_, camera, hand)) {
    adopt(std::make_shared<const WorldMap>(std::move(*first)));
    seen = look(*map, picture_, free_, {camera, *hand.T_camera_hand}, kGoOn);
  }
  if (!seen) {
    map.reset();
    at_rest_.reject(Hindrance::bare);
    result.hindrance = at_rest_.hindrance();
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
  for (const Observation& o :
       map->keyframes[reference_for(*map, {camera, last_->T_camera_world})].observations) {
    const MapPoint& point = map->points[static_cast<std::size_t>(o.point)];
    if (const auto px = pixel_of(point.p_world_m, {camera, last_->T_camera_world}))
      last_seen_.push_back({o.point, *px});
  }
}

// The camera goes on as it went; the last picture as a whole tells its turn better, the flow of its
// points better again, and the keyframe best.
std::optional<Seen> WorldTracker::Impl::go_on(double time_s) const {
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
  guess = turned_to_fit(last_picture_, last_->T_camera_world, picture_, guess, camera);
  std::vector<Observation> followed =
      follow(*map, last_picture_, last_seen_, picture_, {camera, guess});
  std::erase_if(followed, [&](const Observation& o) { return !is_free(free_, o.px); });
  const Resection flow = resect(*map, followed, camera, guess);
  if (flow.inliers.size() >= kGoOn.inliers) guess = flow.T_camera_world;
  const View view{camera, guess};
  if (auto seen = look(*map, picture_, free_, view, kSure)) return seen;
  return look_twice(*map, picture_, free_, view, confirmed_ ? kGoOn : kConfirm);
}

void WorldTracker::Impl::search(double time_s) {
  last_.reset();
  if (worker.busy()) return;
  worker.start([map = map, picture = picture_, free = free_, camera = camera, time_s] {
    return Recognised{picture, time_s, recognise(*map, picture, free, camera)};
  });
  take_done();
}

// What was recognised is gone on from in the next frame, although it may be some frames old.
void WorldTracker::Impl::take_done() {
  auto done = worker.take();
  if (!done) return;
  if (const auto* next = std::get_if<MapPointer>(&*done)) return adopt(*next);
  auto& [picture, time_s, seen] = std::get<Recognised>(*done);
  if (!seen) return;
  last_ = Pose{seen->pose.T_camera_world, time_s};
  before_last_.reset();
  confirmed_ = false;
  last_seen_ = std::move(seen->pose.inliers);
  last_picture_ = std::move(picture);
}

void WorldTracker::Impl::take(const Seen& seen, double time_s, WorldResult& result) {
  for (const int point : seen.matches.expected) ++tried_[static_cast<std::size_t>(point)];
  for (const Observation& o : seen.matches.seen) ++found_[static_cast<std::size_t>(o.point)];
  before_last_ = last_;
  last_ = Pose{seen.pose.T_camera_world, time_s};
  confirmed_ = true;
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
  worker.start(
      [map = map, view = NewView{picture_.grey, free_, T, seen.matches.seen, tried_, found_}] {
        return std::make_shared<const WorldMap>(extended(*map, view));
      });
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
