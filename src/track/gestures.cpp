// SPDX-License-Identifier: MIT
#include "track/gestures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "track/hand_prior.hpp"

namespace handyar {

std::string_view name(Gesture gesture) noexcept {
  switch (gesture) {
    case Gesture::open:
      return "open";
    case Gesture::fist:
      return "fist";
    case Gesture::four:
      return "four";
  }
  return "unknown";
}

std::string_view name(GestureEvent event) noexcept {
  switch (event) {
    case GestureEvent::grab:
      return "grab";
    case GestureEvent::release:
      return "release";
    case GestureEvent::click:
      return "click";
  }
  return "unknown";
}

namespace {

// The fingers in each posture but the open one, as they fit rendered hands best. Seen from the
// front, a fist's fingers point to the camera; a folded thumb lies before the palm or behind it.
constexpr std::array<Posture, 3> kFingers = {
    {{}, {{-0.74, 0, 0, 0, 0}, {0.65, 1.35, 1.35, 1.35, 1.35}}, {{-0.75}, {0.95}}}};

constexpr int kThumb = 0;

/// What is usual, and how the hand moves, is the mean of about this time, in which frames are alike
/// and a hand goes on as it went; for so long it may with no posture that fits, then it is given
/// up. Held still instead, it strays farther (docs/tried.md, "A palm while fingers move").
double while_s(const BeliefConfig& belief) { return belief.same_s + kLongest_s; }

// What the colours inside a part say; where they say nothing it is neither.
bool is_gone(double log_ratio) { return log_ratio < 0; }
bool is_there(double log_ratio) { return log_ratio > 0; }

/// How many of the fingers but the thumb are gone.
int gone_fingers(const PartRatios& inside) {
  return static_cast<int>(
      std::count_if(inside.begin() + 1, inside.begin() + kFingerCount, is_gone));
}
bool is_fist(const PartRatios& inside) {
  return is_there(inside[kFingerCount]) && is_gone(inside[kThumb]) &&
         gone_fingers(inside) == kFingerCount - 1;
}
bool is_folding(const PartRatios& inside) {
  return is_there(inside[kFingerCount]) && gone_fingers(inside) >= 2;
}
bool is_four(const PartRatios& inside) {
  return is_gone(inside[kThumb]) && std::all_of(inside.begin() + 1, inside.end(), is_there);
}

}  // namespace

bool Gestures::fits(const Alignment& open, const BeliefConfig& belief) const noexcept {
  const double folded_rad = kFingers[static_cast<int>(Gesture::four)].abduction_rad[kThumb];
  return open.state.posture.abduction_rad[kThumb] > 0.5 * folded_rad &&
         open.log_ratio > usual_ratio_ - belief.seen();
}

void Gestures::remember(const Hypothesis& open, double keep) noexcept {
  usual_ratio_ = keep * usual_ratio_ + (1 - keep) * open.alignment.log_ratio;
  const HandState before = hand_.alignment.state;
  hand_ = open;
  HandState& now = hand_.alignment.state;
  now.velocity = keep * before.velocity + (1 - keep) * now.velocity;
}

void Gestures::carry(Gesture posture, double dt_s, double keep) noexcept {
  Alignment palm = laid(posture);
  const HandState& before = hand_.alignment.state;
  palm.state.velocity =
      keep * before.velocity + (1 - keep) / dt_s * before.difference(palm.state).head<6>();
  hand_.alignment = palm;
}

void Gestures::go_on(double dt_s) noexcept {
  HandState& state = hand_.alignment.state;
  state.T_camera_hand = state.pose_after(dt_s);
}

void Gestures::open() noexcept {
  if (gesture_ == Gesture::fist) event_ = GestureEvent::release;
  gesture_ = leader_ = Gesture::open;
  holds_ = false;
  leads_s_ = unclear_s_ = 0;
}

void Gestures::forget() noexcept {
  open();
  usual_ratio_ = 0;
  watches_ = false;
}

void Gestures::lay(const ImageView& frame, const Camera& camera, double dt_s,
                   const TrackerConfig& config, Aligner& aligner) noexcept {
  for (int i = 0; i < kPostures; ++i) {
    HandState expected = hand_.alignment.state;
    expected.T_camera_hand = expected.pose_after(dt_s);
    expected.posture = static_cast<Gesture>(i) == Gesture::open ? hand_.person.rest() : kFingers[i];
    HandPrior prior = prior_around(expected, hand_.person, dt_s, config);
    prior.mean.posture = expected.posture;
    // They and the palm are held as firmly as the stillest hand: less of a folded hand's outline is
    // seen, and what is seen does not fit as well.
    prior.information.topLeftCorner<kBoundaryAt, kBoundaryAt>() /= kStillest * kStillest;
    const bool follows = folded() && leader_ == static_cast<Gesture>(i);
    laid_[i] = aligner.align(frame, camera, hand_.appearance, expected, prior,
                             follows ? kNearSteps : kFarSteps);
    if (!laid_[i].valid) laid_[i].log_ratio = -std::numeric_limits<double>::infinity();
  }
}

PartRatios Gestures::inside(const HandState& state, const ImageView& frame, const Camera& camera,
                            const Aligner& aligner) const noexcept {
  HandState outstretched = state;
  outstretched.posture = hand_.person.rest();
  return aligner.ratios_inside(frame, camera, hand_.appearance, outstretched);
}

Gesture Gestures::choose(const Hypothesis* tracked, const ImageView& frame, const Camera& camera,
                         const TrackerConfig& config, const Aligner& aligner) const noexcept {
  double outstretched = ratio(Gesture::open);
  if (tracked && tracked->alignment.log_ratio > config.belief.seen())
    outstretched = std::max(outstretched, tracked->alignment.log_ratio);
  // Better by as much as tells a hand from none, and not surely none itself: else fingers that open
  // again would pull the palm along.
  const double enough = config.belief.seen();
  if (ratio(Gesture::fist) > std::max(-enough, outstretched + enough) &&
      is_fist(inside(laid(Gesture::fist).state, frame, camera, aligner)))
    return Gesture::fist;
  // A four need only explain the picture better than an open hand that is whole.
  const auto whole_ratio = [&](Appearance appearance, const Alignment& open) {
    return open.valid &&
                   is_whole(open, aligner.ratios_inside(frame, camera, appearance, open.state))
               ? open.log_ratio
               : -std::numeric_limits<double>::infinity();
  };
  double whole = whole_ratio(hand_.appearance, laid(Gesture::open));
  if (tracked) whole = std::max(whole, whole_ratio(tracked->appearance, tracked->alignment));
  if (ratio(Gesture::four) > std::max(enough, whole) &&
      is_four(inside(laid(Gesture::four).state, frame, camera, aligner)))
    return Gesture::four;
  return Gesture::open;
}

void Gestures::lead(Gesture posture, double dt_s, double keep) noexcept {
  carry(posture, dt_s, keep);
  leads_s_ = posture == leader_ ? leads_s_ + dt_s : 0;
  leader_ = posture;
  holds_ = false;
  unclear_s_ = 0;
  // For as long as a hand may go on as it went: no single frame says it.
  if (posture == gesture_ || leads_s_ < kLongest_s) return;
  event_ = posture == Gesture::fist    ? GestureEvent::grab
           : gesture_ == Gesture::fist ? GestureEvent::release
                                       : GestureEvent::click;
  gesture_ = posture;
}

void Gestures::update(const ImageView& frame, const Camera& camera, const Hypothesis* tracked,
                      double dt_s, const TrackerConfig& config, Aligner& aligner) noexcept {
  event_.reset();
  watches_ = opened_ = false;
  const double keep = usual_ratio_ > 0 ? std::exp(-dt_s / while_s(config.belief)) : 0;
  if (tracked && fits(tracked->alignment, config.belief)) {
    open();
    remember(*tracked, keep);
    return;
  }
  // Only of hands that usually say as much as a frame can is it told what they do: of less, one
  // that is turned away or blurred cannot be told from a fist (clips of webcams: 790 instead of 810
  // of 974 open frames right, at no least).
  if (config.belief.says(usual_ratio_) < config.belief.most_frame()) return;
  watches_ = true;
  lay(frame, camera, dt_s, config, aligner);
  const Gesture posture = choose(tracked, frame, camera, config, aligner);
  if (posture != Gesture::open) return lead(posture, dt_s, keep);
  if (folded() && fits(laid(Gesture::open), config.belief)) {
    opened_ = true;
    carry(Gesture::open, dt_s, keep);
    return open();
  }
  unclear_s_ += dt_s;
  if (unclear_s_ > while_s(config.belief)) return forget();
  go_on(dt_s);
  if (gesture_ != Gesture::open) return;  // it may come back
  leader_ = Gesture::open;
  // Fingers between two postures are followed wherever the picture leads them: better to stay.
  holds_ = !(tracked && tracked->alignment.log_ratio > config.belief.seen()) &&
           is_folding(inside(hand_.alignment.state, frame, camera, aligner));
}

}  // namespace handyar
