// SPDX-License-Identifier: MIT
#include "paper/fingertips.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace handyar::paper {
namespace {

// Palm radii: the contour's samples lie this far apart; a finger is about this wide.
constexpr float kSpacing = 0.06f, kFingerWidth = 0.42f;
// The arms of the angle at which the contour turns, from finest to coarsest scale.
constexpr std::array<float, 4> kArms{0.5f, 0.7f, 0.9f, 1.1f};
constexpr int kMostSamples = 1024;

}  // namespace

void FingertipFinder::reserve(int mask_pixels) {
  contour_.reserve(mask_pixels);
  samples_.reserve(kMostSamples);
  cosines_.reserve(kMostSamples);
}

/// The boundary, clockwise on the screen (Moore neighbours).
bool FingertipFinder::trace(const Mask& mask, Eigen::Vector2i first) noexcept {
  static constexpr int kDu[8] = {1, 1, 0, -1, -1, -1, 0, 1}, kDv[8] = {0, 1, 1, 1, 0, -1, -1, -1};
  const auto set = [&](const Eigen::Vector2i& p) {
    return p.x() >= 0 && p.y() >= 0 && p.x() < mask.width && p.y() < mask.height &&
           mask.at(p.x(), p.y());
  };
  contour_.clear();
  Eigen::Vector2i at = first;
  int direction = 0, first_direction = -1;
  while (contour_.size() < contour_.capacity()) {
    int d = (direction + 6) & 7, tries = 0;
    while (tries < 8 && !set(at + Eigen::Vector2i(kDu[d], kDv[d]))) {
      d = (d + 1) & 7;
      ++tries;
    }
    if (tries == 8 || (at == first && d == first_direction)) break;
    if (first_direction < 0) first_direction = d;
    contour_.push_back(at.cast<float>());
    at += Eigen::Vector2i(kDu[d], kDv[d]);
    direction = d;
  }
  return contour_.size() > 40;
}

/// Even samples, each the mean over the contour around it, which takes the pixels' stairs away.
void FingertipFinder::resample(float spacing) noexcept {
  samples_.clear();
  const int n = static_cast<int>(contour_.size());
  const int step = std::max(1, static_cast<int>(std::lround(spacing)));
  const int half = std::max(1, step);
  for (int i = 0; i < n && static_cast<int>(samples_.size()) < kMostSamples; i += step) {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    for (int k = -half; k <= half; ++k) sum += contour_[(i + k + n) % n];
    samples_.push_back(sum / static_cast<float>(2 * half + 1));
  }
  spacing_ = static_cast<float>(step) * 1.12f;  // steps are straight or diagonal
}

float FingertipFinder::cosine_at(int sample, int arm, bool& convex) const noexcept {
  const int n = static_cast<int>(samples_.size());
  const Eigen::Vector2f a = samples_[(sample - arm + n) % n] - samples_[sample];
  const Eigen::Vector2f b = samples_[(sample + arm) % n] - samples_[sample];
  convex = a.x() * b.y() - a.y() * b.x() < 0;
  return a.dot(b) / std::max(a.norm() * b.norm(), 1e-6f);
}

/// The end of the ellipse around the tip, along its major axis, away from the palm.
void FingertipFinder::fit_ellipse(Fingertip& tip, const Eigen::Vector2f& palm,
                                  float width) const noexcept {
  // Algebraic fit of a x^2 + b xy + c y^2 + d x + e y = 1 about the tip, in finger widths.
  using Vector5d = Eigen::Matrix<double, 5, 1>;
  Eigen::Matrix<double, 5, 5> A = Eigen::Matrix<double, 5, 5>::Zero();
  Vector5d y = Vector5d::Zero();
  const Eigen::Vector2f inwards = (palm - tip.at).normalized();
  const Eigen::Vector2f about = tip.at + 0.6f * width * inwards;
  int count = 0;
  for (const Eigen::Vector2f& p : contour_) {
    const Eigen::Vector2d d = ((p - about) / width).cast<double>();
    if (d.norm() > 0.8) continue;
    const Vector5d row(d.x() * d.x(), d.x() * d.y(), d.y() * d.y(), d.x(), d.y());
    A += row * row.transpose();
    y += row;
    ++count;
  }
  if (count < 12) return;
  const Vector5d c = A.ldlt().solve(y);
  const Eigen::Matrix2d Q = (Eigen::Matrix2d() << c[0], c[1] / 2, c[1] / 2, c[2]).finished();
  if (!c.allFinite() || Q.determinant() < 1e-3 || Q.trace() < 0) return;
  const Eigen::Vector2d centre = -0.5 * Q.inverse() * Eigen::Vector2d(c[3], c[4]);
  const double k = 1 + centre.dot(Q * centre);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(Q);
  const double major = std::sqrt(k / axes.eigenvalues()[0]);
  Eigen::Vector2d along = axes.eigenvectors().col(0);
  if (along.dot(inwards.cast<double>()) > 0) along = -along;
  constexpr double kMostMove = 0.5;  // finger widths
  const Eigen::Vector2f end = about + width * (centre + major * along).cast<float>();
  if ((end - tip.at).norm() < kMostMove * width) tip.at = end;
}

/// Of tips nearer than a finger's width the sharper one stays.
void FingertipFinder::add_tip(int sample, float cosine) noexcept {
  const Fingertip tip{samples_[sample], sample, cosine};
  if (count_ > 0) {
    Fingertip& last = tips_[count_ - 1];
    if (static_cast<float>(sample - last.sample) * kSpacing < kFingerWidth) {
      if (cosine > last.cosine) last = tip;
      return;
    }
  }
  if (count_ < kMostTips) tips_[count_++] = tip;
}

std::span<const Fingertip> FingertipFinder::find(const HandRegion& region) noexcept {
  count_ = 0;
  const float radius = region.palm_radius();
  if (!trace(region.mask(), region.first())) return {};
  resample(kSpacing * radius);
  const int n = static_cast<int>(samples_.size());
  cosines_.assign(samples_.size(), -1);
  for (int i = 0; i < n; ++i) {
    float sum = 0, best = -1;
    bool tip = true;
    for (const float arm : kArms) {
      const int steps = std::max(1, static_cast<int>(std::lround(arm * radius / spacing_)));
      if (steps * 2 >= n) return {};
      bool convex = false;
      const float cosine = cosine_at(i, steps, convex);
      tip &= convex;
      sum += cosine;
      best = std::max(best, cosine);
    }
    // Fingers end away from the palm: its own outline turns as well.
    tip &= (samples_[i] - region.palm()).norm() > 1.5f * radius;
    if (tip && best > static_cast<float>(config_.min_cosine))
      cosines_[i] = sum / static_cast<float>(kArms.size());
  }
  for (int i = 0; i < n; ++i) {
    const float here = cosines_[i];
    if (here > -1 && here >= cosines_[(i + n - 1) % n] && here > cosines_[(i + 1) % n])
      add_tip(i, here);
  }
  if (config_.fingertips == FingertipMethod::ellipse)
    for (int k = 0; k < count_; ++k) fit_ellipse(tips_[k], region.palm(), kFingerWidth * radius);
  return {tips_.data(), static_cast<std::size_t>(count_)};
}

}  // namespace handyar::paper
