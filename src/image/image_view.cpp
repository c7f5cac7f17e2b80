// SPDX-License-Identifier: MIT
#include "handyar/image_view.hpp"

#include <algorithm>
#include <cstdlib>

namespace handyar {
namespace {

std::ptrdiff_t bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::bgr:
    case PixelFormat::rgb:
      return 3;
    case PixelFormat::bgra:
    case PixelFormat::rgba:
      return 4;
    case PixelFormat::yuyv:
      return 2;
    case PixelFormat::nv12:
    case PixelFormat::gray:
      return 1;
  }
  return 0;
}

}  // namespace

FrameStatus check(const ImageView& image) noexcept {
  if (image.data == nullptr) return FrameStatus::no_data;
  if (image.format == PixelFormat::gray) return FrameStatus::gray_unsupported;
  const int longer = std::max(image.width_px, image.height_px);
  const int shorter = std::min(image.width_px, image.height_px);
  if (longer < 160 || shorter < 120 || longer > 4096 || shorter > 2160)
    return FrameStatus::size_unsupported;
  const bool nv12 = image.format == PixelFormat::nv12;
  const bool subsampled = nv12 || image.format == PixelFormat::yuyv;
  if (subsampled && image.width_px % 2 != 0) return FrameStatus::size_unsupported;
  if (nv12 && image.height_px % 2 != 0) return FrameStatus::size_unsupported;
  if (nv12 && image.chroma == nullptr) return FrameStatus::no_data;
  if (std::abs(image.stride_bytes) < image.width_px * bytes_per_pixel(image.format))
    return FrameStatus::stride_too_small;
  if (nv12 && std::abs(image.chroma_stride_bytes) < image.width_px)
    return FrameStatus::stride_too_small;
  return FrameStatus::ok;
}

const char* describe(FrameStatus status) noexcept {
  switch (status) {
    case FrameStatus::ok:
      return "ok";
    case FrameStatus::no_data:
      return "no image data";
    case FrameStatus::gray_unsupported:
      return "grey image: handyar needs colour";
    case FrameStatus::size_unsupported:
      return "unsupported image size: 160x120 to 4096x2160 pixels, even for yuyv and nv12";
    case FrameStatus::stride_too_small:
      return "image rows overlap: stride too small";
    case FrameStatus::time_not_increasing:
      return "frame time is not after the previous frame's";
  }
  return "unknown";
}

}  // namespace handyar
