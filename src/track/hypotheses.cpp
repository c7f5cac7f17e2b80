// SPDX-License-Identifier: MIT
#include "track/hypotheses.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "track/hand_prior.hpp"
#include "track/start_pose.hpp"
#include "track/turning.hpp"

namespace handyar {
namespace {

// A new hand's colours are taken ever nearer to its outline while the figure settles on it, roughly
// from each start, then finely from where these ended.
constexpr std::array<Steps, 2> kRoughly{{{4, 3}, {3, 2}}}, kFinely{{{2, 1}, {1, 1}}};
// Whether a hand is small or its fingers are close together is told badly, and a figure that has
// settled in a wrong size stays in it: it begins with its fingers apart and almost side by side.
constexpr std::array<double, 2> kClosed{0, 0.7};

/// What a frame says counts by the time it stands for.
double share_of(double dt_s, const TrackerConfig& config) {
  return std::min(dt_s, kLongest_s) / config.belief.same_s;
}

/// The face of a new hand: the user tells, or the finder is sure. Then the ways to see it are ways
/// to see that face.
std::optional<Face> known_face(const HandCandidate& candidate, const TrackerConfig& config) {
  if (config.user.side)
    return side_of(Face::palm, candidate.layout) == *config.user.side ? Face::palm : Face::back;
  if (std::abs(candidate.palm_log_odds) < config.belief.believe) return std::nullopt;
  return candidate.palm_log_odds > 0 ? Face::palm : Face::back;
}

}  // namespace

void Hypotheses::sort_and_prune(const BeliefConfig& belief) noexcept {
  // In place: the library's stable sort takes memory.
  const auto weight = [&](const Hypothesis& h) {
    return h.log_weight + (h.leads ? belief.believe : 0);
  };
  const auto likelier = [&](const auto& a, const auto& b) { return weight(a) > weight(b); };
  for (auto item = items_.begin(); item != items_.begin() + count_; ++item)
    std::rotate(std::upper_bound(items_.begin(), item, *item, likelier), item, item + 1);
  while (count_ > 1 && items_[count_ - 1].log_weight < items_[0].log_weight - belief.most())
    --count_;
  const double best = count_ > 0 ? items_[0].log_weight : 0;
  for (int i = 0; i < count_; ++i) {
    items_[i].log_weight -= best;
    items_[i].leads = i == 0;
  }
}

void Hypotheses::resume(const Hypothesis& hypothesis) noexcept {
  clear();
  count_ = 1;
  since_reconsidered_s_ = 0;
  items_[0] = hypothesis;
  items_[0].log_weight = 0;
  items_[0].liveliness = 1;
  items_[0].fingers.reset();
}

void Hypotheses::keep_distinct(const Hypothesis& h, const BeliefConfig& belief) noexcept {
  if (!h.alignment.valid) return;
  const auto least = [](const Hypothesis& a, const Hypothesis& b) {
    return a.log_weight < b.log_weight;
  };
  Hypothesis* const end = items_.data() + count_;
  Hypothesis* rival = std::find_if(items_.data(), end, [&](const Hypothesis& other) {
    const HandVector apart = h.alignment.state.difference(other.alignment.state);
    return other.appearance == h.appearance && apart.head<3>().norm() < belief.doubt_rad;
  });
  if (rival == end && count_ < kMost) {
    items_[count_++] = h;
    return;
  }
  const bool leads = rival != end && (rival->leads || h.leads);
  if (rival == end) rival = std::min_element(items_.data(), end, least);
  if (least(*rival, h)) *rival = h;
  rival->leads |= leads;
}

void Hypotheses::keep_likely(const BeliefConfig& belief) noexcept {
  const Hypotheses all = *this;
  count_ = 0;
  for (const Hypothesis& h : std::span(all.items_.data(), all.count_)) keep_distinct(h, belief);
  sort_and_prune(belief);
}

namespace {

/// A hand that is begun in a frame, by a person's figure.
struct Beginning {
  const ImageView& frame;
  const Camera& camera;
  const Person& person;
  const TrackerConfig& config;
  Aligner& aligner;

  HandPrior prior_at(const Eigen::Isometry3d& T_camera_hand) const noexcept {
    HandState expected;
    expected.T_camera_hand = T_camera_hand;
    expected.figure = person.mean();
    return prior_around(expected, person, kLongAgo_s, config);
  }

  void align(Hypothesis& h, const HandPrior& prior, Steps steps) noexcept {
    const HandState from = h.alignment.state;
    h.alignment = aligner.align(frame, camera, h.appearance, from, prior, steps);
    h.log_weight = share_of(kLongest_s, config) * h.alignment.log_posterior;
  }

  /// Takes the colours that the hypothesis expects, and lays it on what they tell, ever nearer.
  void settle(Hypothesis& h, const HandPrior& prior, std::span<const Steps> how) noexcept {
    for (const Steps& steps : how) {
      aligner.learn(frame, camera, h.appearance, h.alignment.state, 0, steps.coarsest);
      align(h, prior, steps);
      if (!h.alignment.valid) return;
    }
  }
};

}  // namespace

bool Hypotheses::begin(const HandCandidate& candidate, const ImageView& frame, const Camera& camera,
                       const Person& person, const TrackerConfig& config,
                       Aligner& aligner) noexcept {
  clear();
  since_reconsidered_s_ = 0;
  aligner.forget();
  Beginning beginning{frame, camera, person, config, aligner};
  const RoughFingers fingers = rough_fingers(candidate);
  const std::optional<Face> known = known_face(candidate, config);
  for (const Face face : {Face::palm, Face::back}) {
    if (known && face != *known) continue;
    Hypotheses rough;
    for (const double closed : kClosed) {
      Hypothesis h;
      h.appearance = {face, candidate.layout};
      h.person = person;
      HandState& state = h.alignment.state;
      state.figure = person.mean();
      for (int f = 0; f < kFingerCount; ++f)
        state.posture.abduction_rad[f] = closed * closing_rad()[f];
      state.T_camera_hand = start_pose(fingers, posed_figure(h.appearance, state), camera,
                                       config.motion.rotation_sigma_rad);
      spread_as_seen(fingers, h.appearance, camera, state);
      HandPrior prior = beginning.prior_at(state.T_camera_hand);
      prior.fingers = fingers;
      beginning.settle(h, prior, kRoughly);
      rough.keep_distinct(h, config.belief);
    }
    rough.sort_and_prune(config.belief);
    // From here on the picture alone tells whether there is a hand: held by a thumb that the finder
    // only thinks is there, a figure lies on four fingers as well as on five.
    for (Hypothesis& h : std::span(rough.items_.data(), rough.count_)) {
      h.leads = false;
      const HandPrior prior = beginning.prior_at(h.alignment.state.T_camera_hand);
      beginning.settle(h, prior, kFinely);
      keep_distinct(h, config.belief);
      if (!h.alignment.valid) continue;
      h.alignment.state.T_camera_hand = other_planar_solution(h.alignment.state.T_camera_hand);
      beginning.align(h, prior, kFarSteps);
      keep_distinct(h, config.belief);
    }
  }
  expect(&candidate, camera, 1, config.belief);
  sort_and_prune(config.belief);
  return count_ > 0;  // with the colours of the way that was tried last, which do as well
}

bool Hypotheses::lay_anew(const ImageView& frame, const Camera& camera, const TrackerConfig& config,
                          Aligner& aligner) noexcept {
  aligner.forget();
  for (int i = count_ - 1; i >= 0; --i) {  // the best last: its colours are the ones to keep
    Hypothesis& h = items_[i];
    const double weight = h.log_weight;  // that it is laid anew says nothing for or against it
    Beginning beginning{frame, camera, h.person, config, aligner};
    const HandPrior prior =
        prior_around(h.alignment.state, h.person, kLongest_s, config, h.liveliness);
    beginning.settle(h, prior, kRoughly);
    beginning.settle(h, prior, kFinely);
    h.log_weight = weight;
  }
  keep_likely(config.belief);
  return count_ > 0;
}

void Hypotheses::expect(const HandCandidate* seen, const Camera& camera, double share,
                        const BeliefConfig& belief) noexcept {
  for (Hypothesis& h : std::span(items_.data(), count_)) {
    h.fingers.reset();
    if (seen == nullptr) continue;
    h.fingers = on_hand(rough_fingers(*seen), h.appearance, h.alignment.state, camera);
    if (h.appearance.face == Face::palm)
      h.log_weight += share * std::clamp<double>(seen->palm_log_odds, -belief.most_frame(),
                                                 belief.most_frame());
  }
}

Matrix6d Hypotheses::spread(bool average_size) const noexcept {
  const auto told = [average_size](const Hypothesis& h) {
    HandState state = h.alignment.state;
    if (average_size) state.T_camera_hand.translation() /= relative_size(state.figure);
    return state;
  };
  Matrix6d sum = Matrix6d::Zero();
  double weights = 0;
  for (const Hypothesis& h : std::span(items_.data(), count_)) {
    const double weight = std::exp(h.log_weight);
    const HandVector apart = told(best()).difference(told(h));
    sum += weight * apart.head<6>() * apart.head<6>().transpose();
    weights += weight;
  }
  return sum / weights;
}

void Hypotheses::learn_person(double share, const TrackerConfig& config) noexcept {
  for (Hypothesis& h : std::span(items_.data(), count_))
    h.person.learn(h.alignment,
                   prior_around(h.alignment.prior.mean, h.person, kLongAgo_s, config, h.liveliness),
                   share);
}

void Hypotheses::consider_edge(const MotionConfig& motion) noexcept {
  const HandState& state = best().alignment.state;
  if (count_ == kMost || turn_through_edge_rad(state.T_camera_hand) > motion.rotation_sigma_rad)
    return;
  Hypothesis& other = items_[count_++] = items_[0];
  other.alignment.state = beyond_edge(state);
  other.leads = false;
}

bool Hypotheses::follow(const ImageView& frame, const Camera& camera, double dt_s,
                        const TrackerConfig& config, Aligner& aligner) noexcept {
  const double share = share_of(dt_s, config);
  consider_edge(config.motion);
  for (int i = count_ - 1; i >= 0; --i) {  // the best last: its outline is the one to show
    Hypothesis& h = items_[i];
    const HandState before = h.alignment.state;
    HandState expected = before;
    expected.T_camera_hand = before.pose_after(dt_s);
    const auto laid = [&](Steps steps) {
      HandPrior prior = prior_around(expected, h.person, dt_s, config, h.liveliness);
      if (h.fingers) prior.fingers = h.fingers->in_frame(expected.T_camera_hand, camera);
      return aligner.align(frame, camera, h.appearance, expected, prior, steps);
    };
    h.alignment = laid(kNearSteps);
    if (!h.alignment.valid || h.alignment.log_ratio < config.belief.seen()) {
      h.liveliness = 1;  // what does not lie there any more may have moved its fingers
      const Alignment far = laid(kFarSteps);
      if (!h.alignment.valid || (far.valid && far.log_posterior > h.alignment.log_posterior))
        h.alignment = far;
    }
    if (!h.alignment.valid) continue;
    HandState& now = h.alignment.state;
    now.velocity = before.difference(now).head<6>() / dt_s;
    h.liveliness =
        liveliness_after(dt_s, now.posture, h.person.rest(), h.liveliness, config.belief.same_s);
    if (turn_over(h.appearance, now.T_camera_hand)) h.fingers.reset();
    h.log_weight += share * h.alignment.log_posterior;
  }
  keep_likely(config.belief);
  return count_ > 0;
}

void Hypotheses::reconsider(const ImageView& frame, const Camera& camera, double dt_s,
                            const TrackerConfig& config, Aligner& aligner) noexcept {
  since_reconsidered_s_ += dt_s;
  if (since_reconsidered_s_ <= config.learning.remember_s) return;
  since_reconsidered_s_ = 0;
  if (count_ != 1) return;
  const Hypothesis& now = items_[0];
  Appearance appearance = now.appearance;
  if (!config.user.side) appearance.face = opposite(appearance.face);
  HandState start = now.alignment.state;
  start.posture = {};
  start.velocity.setZero();
  start.T_camera_hand = other_planar_solution(start.T_camera_hand);
  Hypothesis alternative;
  alternative.appearance = appearance;
  alternative.person = now.person;
  alternative.liveliness = now.liveliness;  // judged alike
  alternative.alignment =
      aligner.align(frame, camera, appearance, start,
                    prior_around(start, now.person, kLongAgo_s, config, now.liveliness), kFarSteps);
  alternative.log_weight = now.log_weight - config.belief.most_frame();
  keep_distinct(alternative, config.belief);
}

}  // namespace handyar
