// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "handyar/world/world_map.hpp"

namespace handyar::world {

/// Bundle adjustment: moves the keyframes named in `free` and the points they show to where all
/// keyframes that show those points agree best; the other keyframes stay. The first keyframe always
/// stays: it is what the frame was set by. Points that were laid on the plane under the hand are
/// held near it, which holds the scale.
void adjust(WorldMap& map, std::span<const int> free);

}  // namespace handyar::world
