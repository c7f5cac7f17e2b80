// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

#include "handyar/api.h"

namespace handyar {

/// What the fingers do.
enum class Gesture : std::uint8_t {
  open,  ///< outstretched, or not known to do anything else
  fist,  ///< all closed
  four   ///< the thumb folded into the palm, the others outstretched
};
[[nodiscard]] HANDYAR_API std::string_view name(Gesture gesture) noexcept;

/// What the hand has just done.
enum class GestureEvent : std::uint8_t {
  grab,     ///< an open hand has closed
  release,  ///< the closed hand has opened, or is no longer seen
  click     ///< the thumb has been folded in
};
[[nodiscard]] HANDYAR_API std::string_view name(GestureEvent event) noexcept;

}  // namespace handyar
