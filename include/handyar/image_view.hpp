// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "handyar/api.h"

namespace handyar {

/// How the bytes of a frame are laid out. `gray` exists so that it can be named and refused: a hand
/// is told from its surroundings by colour.
enum class PixelFormat : std::uint8_t { bgr, rgb, bgra, rgba, yuyv, nv12, gray };

/// A frame that somebody else owns; it must stay valid during the call it is passed to.
struct ImageView {
  const std::uint8_t* data = nullptr;  ///< first byte of the top row (of the luma plane for nv12)
  int width_px = 0;
  int height_px = 0;
  std::ptrdiff_t stride_bytes = 0;  ///< from one row to the next; negative: stored bottom-up
  PixelFormat format = PixelFormat::bgr;
  const std::uint8_t* chroma = nullptr;    ///< nv12 only: first byte of the interleaved UV plane
  std::ptrdiff_t chroma_stride_bytes = 0;  ///< nv12 only
};

/// Why a frame can or cannot be processed.
enum class FrameStatus : std::uint8_t {
  ok,
  no_data,           ///< null pointer
  gray_unsupported,  ///< one channel: there is no colour to segment by
  size_unsupported,  ///< outside 160x120 .. 4096x2160 in either orientation, or odd for yuyv, nv12
  stride_too_small,  ///< rows would overlap
  time_not_increasing  ///< the frame's time is not after the previous frame's, or is not finite
};

/// Checks everything but the time. Never reads a pixel.
[[nodiscard]] HANDYAR_API FrameStatus check(const ImageView& image) noexcept;

/// One line for a person, e.g. "grey image: handyar needs colour".
[[nodiscard]] HANDYAR_API const char* describe(FrameStatus status) noexcept;

}  // namespace handyar
