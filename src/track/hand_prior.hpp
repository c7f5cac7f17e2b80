// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "handyar/stages/align.hpp"
#include "track/person.hpp"
#include "track/tracker_config.hpp"

namespace handyar {

constexpr double kLongAgo_s = std::numeric_limits<double>::infinity();

/// The prior of a frame around an expected state whose fingers were seen `dt_s` ago: they go back
/// to rest in time, and are the less sure the longer ago it was (an Ornstein-Uhlenbeck process).
HandPrior prior_around(const HandState& expected, const Person& person, double dt_s,
                       const TrackerConfig& config) noexcept;

}  // namespace handyar
