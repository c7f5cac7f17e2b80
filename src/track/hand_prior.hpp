// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "handyar/stages/align.hpp"
#include "track/person.hpp"
#include "track/tracker_config.hpp"

namespace handyar {

constexpr double kLongAgo_s = std::numeric_limits<double>::infinity();

/// The prior of a frame around an expected state whose fingers were seen `dt_s` ago: they go back
/// to the person's rest in time, and are the less sure the longer ago it was (an Ornstein-Uhlenbeck
/// process). `liveliness`: how far they stray from rest, 1 as far as abduction_covariance_rad2 has
/// it.
HandPrior prior_around(const HandState& expected, const Person& person, double dt_s,
                       const TrackerConfig& config, double liveliness = 1) noexcept;

/// The least liveliness.
inline constexpr double kStillest = 0.125;

/// The liveliness, up to 1, after a frame in which the fingers were found so: fingers that are
/// still are held still, and a palm that tilts is not taken for fingers that bend. `same_s` as in
/// BeliefConfig.
double liveliness_after(double dt_s, const Posture& found, const Posture& rest, double before,
                        double same_s) noexcept;

}  // namespace handyar
