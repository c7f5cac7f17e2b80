// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace handyar::io {

/// Of a TIFF's tags, or those of the EXIF in a JPEG, PNG or WebP: how the picture is to be turned
/// and mirrored (1 to 8, 1: not at all), and how a TIFF is compressed.
inline constexpr std::size_t kOrientationTag = 0x112, kCompressionTag = 0x103;

/// The short number that a picture's file gives for a tag; 0: none.
int exif_number(std::span<const std::uint8_t> file, std::size_t tag);

}  // namespace handyar::io
