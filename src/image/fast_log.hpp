// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>

#include "vectorised.hpp"

namespace handyar {

/// Natural logarithm of a positive number to 1e-3, by the exponent and a polynomial: what a ratio
/// in eighths of a nat needs, and loops of it can be vectorised.
HANDYAR_ALWAYS_INLINE float fast_log(float x) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float m = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u) - 1.0f;
  const float log2m = m * (1.4385f + m * (-0.6765f + m * (0.3196f - 0.0822f * m)));
  return 0.6931472f * (exponent + log2m);
}

}  // namespace handyar
