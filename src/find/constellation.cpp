// SPDX-License-Identifier: MIT
#include "find/constellation.hpp"

#include <algorithm>
#include <cmath>

namespace handyar {
namespace {

using Tips = Eigen::Matrix<float, 2, kFingerCount>;
using White = Eigen::Matrix<float, 6, 1>;

/// How the fingertips of a hand lie to each other in pictures, thumb right, turned, scaled and
/// moved onto their mean. Numbers are x of each finger, then y.
struct Constellation {
  std::array<float, 10> mean;
  std::array<std::array<float, 10>, 6> whiten;  ///< what differs from it
  std::array<std::array<float, 6>, 2> guess;    ///< where the missing fingertip is, by that

  Eigen::Vector2f mean_of(int finger) const { return {mean[finger], mean[kFingerCount + finger]}; }
  White whitened(const Tips& off_mean) const {
    White white = White::Zero();
    for (int i = 0; i < white.size(); ++i)
      for (int f = 0; f < kFingerCount; ++f)
        white[i] += whiten[i][f] * off_mean(0, f) + whiten[i][kFingerCount + f] * off_mean(1, f);
    return white;
  }
  Eigen::Vector2f guess_by(const White& white) const {
    Eigen::Vector2f off = Eigen::Vector2f::Zero();
    for (int i = 0; i < white.size(); ++i)
      off += white[i] * Eigen::Vector2f(guess[0][i], guess[1][i]);
    return off;
  }
};

#include "find/constellation_statistics.inc"

// A hand whose log odds are less is not worth the time of laying a figure on it.
constexpr float kLeastOdds = -1.5f;
// What a fingertip that is not seen adds to the sum of all.
constexpr float kMissingTip = kOdds[4] / kOdds[2];

/// Turns, scales and moves the mean of a constellation onto fingertips as well as it can; `missing`
/// is left out.
class Similarity {
 public:
  Similarity(const Constellation& constellation, const Tips& tips, int missing)
      : middle_(tips.rowwise().sum() / (missing < kFingerCount ? kFingerCount - 1 : kFingerCount)) {
    // As complex numbers; those of the mean have the norm 1.
    for (int f = 0; f < kFingerCount; ++f) {
      if (f == missing) continue;
      const Eigen::Vector2f off = tips.col(f) - middle_, mean = constellation.mean_of(f);
      scale_ += Eigen::Vector2f(off.dot(mean), off.y() * mean.x() - off.x() * mean.y());
    }
  }

  bool valid() const { return scale_.squaredNorm() > 0; }
  Eigen::Vector2f operator()(const Eigen::Vector2f& v) const {
    return middle_ + Eigen::Vector2f(scale_.x() * v.x() - scale_.y() * v.y(),
                                     scale_.x() * v.y() + scale_.y() * v.x());
  }
  Eigen::Vector2f inverse(const Eigen::Vector2f& place) const {
    const Eigen::Vector2f v = place - middle_;
    return Eigen::Vector2f(scale_.dot(v), scale_.x() * v.y() - scale_.y() * v.x()) /
           scale_.squaredNorm();
  }

 private:
  Eigen::Vector2f middle_, scale_ = Eigen::Vector2f::Zero();
};

/// The likeliest places of a fingertip.
struct Peaks {
  struct Peak {
    Eigen::Vector2f place;
    float log_odds;
  };
  std::array<Peak, kMostPeaks + 1> items;  ///< the likeliest first, that there is none last
  int count = 0;

  Peaks() = default;
  Peaks(const FinderMaps& maps, int map) {
    for (int y = 0; y < FinderMaps::kHeight; ++y)
      for (int x = 0; x < FinderMaps::kWidth; ++x) {
        const float log_odds = maps.at(map, x, y);
        if (log_odds < kLeastTip || !maps.peaks(map, x, y)) continue;
        int rank = count;
        while (rank > 0 && items[rank - 1].log_odds < log_odds) --rank;
        if (rank == kMostPeaks) continue;
        count = std::min(count + 1, kMostPeaks);
        std::move_backward(items.begin() + rank, items.begin() + count - 1, items.begin() + count);
        items[rank] = {maps.centre(map, x, y), log_odds};
      }
    items[count] = {Eigen::Vector2f::Zero(), kMissingTip};
  }
};

/// Goes through the choices of peaks.
class Reader {
 public:
  Reader(const FinderMaps& maps, HandCandidates& hands) : maps_(maps), hands_(hands) {
    for (int f = kFingerCount - 1; f >= 0; --f) {
      peaks_[f] = Peaks(maps, FinderNetwork::kTips + f);
      if (f > 0) rest_[f - 1] = rest_[f] + peaks_[f].items[0].log_odds;
    }
  }

  void read(Layout layout) {
    layout_ = layout;
    palm_map_ = FinderNetwork::kPalms + (layout == Layout::thumb_right ? 0 : 1);
    likeliest_palm_ = kNoPalm;
    for (int y = 0; y < FinderMaps::kHeight; ++y)
      for (int x = 0; x < FinderMaps::kWidth; ++x)
        likeliest_palm_ = std::max(likeliest_palm_, maps_.at(palm_map_, x, y));
    choose(0, 0);
  }

 private:
  float odds(float palm, float tips, float distance) const {
    return kOdds[0] + kOdds[1] * palm + kOdds[2] * tips +
           kOdds[3] * std::log1p(distance / kFreedom);
  }

  /// All choices for this finger and those after it.
  void choose(int finger, float tips_log_odds) {
    if (finger == kFingerCount) return judge(tips_log_odds);
    const Peaks& peaks = peaks_[finger];
    for (int i = 0; i <= peaks.count; ++i) {
      const float sum = tips_log_odds + peaks.items[i].log_odds;
      if (odds(likeliest_palm_, sum + rest_[finger], 0) < kLeastOdds) return;
      const bool none = i == peaks.count;
      if (none && missing_ < kFingerCount) return;
      if (none) missing_ = finger;
      chosen_[finger] = i;
      choose(finger + 1, sum);
      if (none) missing_ = kFingerCount;
    }
  }

  /// Where the chosen peaks are, mirrored if the thumb is left; of a missing one zero.
  Tips chosen_tips() const {
    Tips tips = Tips::Zero();
    for (int f = 0; f < kFingerCount; ++f)
      if (f != missing_) tips.col(f) = mirrored(peaks_[f].items[chosen_[f]].place);
    return tips;
  }

  Eigen::Vector2f mirrored(const Eigen::Vector2f& place) const {
    return {layout_ == Layout::thumb_right ? place.x() : -place.x(), place.y()};
  }

  /// Offers the hand of the chosen peaks if it is likely enough.
  void judge(float tips_log_odds) {
    const Constellation& constellation = kConstellations[missing_];
    Tips tips = chosen_tips();
    const Similarity onto(constellation, tips, missing_);
    if (!onto.valid()) return;
    Tips off_mean = Tips::Zero();
    for (int f = 0; f < kFingerCount; ++f)
      if (f != missing_) off_mean.col(f) = onto.inverse(tips.col(f)) - constellation.mean_of(f);
    const White white = constellation.whitened(off_mean);
    if (odds(likeliest_palm_, tips_log_odds, white.squaredNorm()) < kLeastOdds) return;
    if (missing_ < kFingerCount)
      tips.col(missing_) = onto(constellation.mean_of(missing_) + constellation.guess_by(white));
    HandCandidate hand;
    hand.layout = layout_;
    for (int f = 0; f < kFingerCount; ++f) {
      hand.tips_px[f] = mirrored(tips.col(f));
      hand.palm_px += kPalmOfTips[f] * hand.tips_px[f];
    }
    const float palm = maps_.largest_about(palm_map_, hand.palm_px, kNoPalm);
    hand.log_odds = odds(palm, tips_log_odds, white.squaredNorm());
    if (hand.log_odds >= kLeastOdds) hands_.offer(hand);
  }

  const FinderMaps& maps_;
  HandCandidates& hands_;
  std::array<Peaks, kFingerCount> peaks_;
  std::array<float, kFingerCount> rest_{};  ///< of the fingers after each, at most
  Layout layout_ = Layout::thumb_right;
  int palm_map_ = 0;
  float likeliest_palm_ = 0;
  std::array<int, kFingerCount> chosen_{};
  int missing_ = kFingerCount;
};

}  // namespace

bool HandPlace::same_tips(const HandPlace& other) const noexcept {
  const float near_px = kSameHand * other.reach_px();
  for (int f = 0; f < kFingerCount; ++f)
    if ((tips_px[f] - other.tips_px[f]).norm() > near_px) return false;
  return true;
}

float HandCandidate::tip_sigma_px() const noexcept { return kTipSigma * span_px(); }

void HandCandidates::offer(const HandCandidate& hand) noexcept {
  for (int i = 0; i < count_; ++i) {
    HandCandidate& known = items_[i];
    const float span = std::max(known.span_px(), hand.span_px());
    if (known.layout != hand.layout || (known.palm_px - hand.palm_px).norm() > kSameHand * span)
      continue;
    if (hand.log_odds > known.log_odds) known = hand;
    return;
  }
  if (count_ < kMost) {
    items_[count_++] = hand;
    return;
  }
  auto worst = std::min_element(items_.begin(), items_.end(), [](const auto& a, const auto& b) {
    return a.log_odds < b.log_odds;
  });
  if (worst->log_odds < hand.log_odds) *worst = hand;
}

void HandCandidates::sort() noexcept {
  std::sort(items_.begin(), items_.begin() + count_,
            [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
}

void read_constellations(const FinderMaps& maps, HandCandidates& hands) noexcept {
  Reader reader(maps, hands);
  for (const Layout layout : {Layout::thumb_right, Layout::thumb_left}) reader.read(layout);
}

}  // namespace handyar
