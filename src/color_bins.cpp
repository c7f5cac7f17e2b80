// SPDX-License-Identifier: MIT
#include "handyar/color_bins.hpp"

#include <algorithm>

namespace handyar {
namespace {

struct Color {
  int a, b, c;  // RGB or YCbCr, 0..255 (times the number of pixels summed)
};

ColorBin bin(const Color& p) {
  return static_cast<ColorBin>((p.a >> 3) << 10 | (p.b >> 3) << 5 | (p.c >> 3));
}

/// Reads pixel x of a row of interleaved channels, `R`, `G`, `B` being the bytes' places.
template <int kBytes, int R, int G, int B>
struct InterleavedRow {
  const std::uint8_t* row;
  InterleavedRow(const ImageView& f, int y) : row(f.data + y * f.stride_bytes) {}
  Color operator()(int x) const {
    const std::uint8_t* p = row + x * kBytes;
    return {p[R], p[G], p[B]};
  }
};

struct YuyvRow {
  const std::uint8_t* row;
  YuyvRow(const ImageView& f, int y) : row(f.data + y * f.stride_bytes) {}
  Color operator()(int x) const {
    const std::uint8_t* pair = row + (x & ~1) * 2;
    return {row[x * 2], pair[1], pair[3]};
  }
};

struct Nv12Row {
  const std::uint8_t *luma, *chroma;
  Nv12Row(const ImageView& f, int y)
      : luma(f.data + y * f.stride_bytes), chroma(f.chroma + (y / 2) * f.chroma_stride_bytes) {}
  Color operator()(int x) const {
    const std::uint8_t* pair = chroma + (x & ~1);
    return {luma[x], pair[0], pair[1]};
  }
};

template <class Row>
void read_rows(const ImageView& frame, BinImage& out) {
  ColorBin* to = out.bins.data();
  const int step = out.step_px, half = step / 2;
  for (int v = 0; v < out.height; ++v) {
    const int y = out.y0_px + v * step;
    const Row top(frame, y);
    if (step == 1) {
      for (int u = 0; u < out.width; ++u) *to++ = bin(top(out.x0_px + u));
      continue;
    }
    const Row bottom(frame, y + half);
    for (int u = 0; u < out.width; ++u) {
      const int x = out.x0_px + u * step;
      const Color p = top(x), q = top(x + half), r = bottom(x), s = bottom(x + half);
      *to++ = bin({(p.a + q.a + r.a + s.a) >> 2, (p.b + q.b + r.b + s.b) >> 2,
                   (p.c + q.c + r.c + s.c) >> 2});
    }
  }
}

}  // namespace

ColorSpace color_space(PixelFormat format) noexcept {
  return format == PixelFormat::yuyv || format == PixelFormat::nv12 ? ColorSpace::ycbcr
                                                                    : ColorSpace::rgb;
}

Eigen::Vector3d rgb_of(ColorBin bin, ColorSpace space) noexcept {
  const auto centre = [](int level) { return level * 8 + 4.0; };
  const Eigen::Vector3d p(centre(bin >> 10), centre((bin >> 5) & 31), centre(bin & 31));
  if (space == ColorSpace::rgb) return p;
  const double y = (p[0] - 16) * 255 / 219;
  const double cb = (p[1] - 128) * 255 / 224, cr = (p[2] - 128) * 255 / 224;
  return {y + 1.402 * cr, y - 0.344136 * cb - 0.714136 * cr, y + 1.772 * cb};
}

void read_bins(const ImageView& frame, const PixelRect& roi, int step_px, BinImage& out) noexcept {
  const int x0 = std::clamp(roi.x0_px, 0, frame.width_px);
  const int y0 = std::clamp(roi.y0_px, 0, frame.height_px);
  const int x1 = std::clamp(roi.x0_px + roi.width_px, x0, frame.width_px);
  const int y1 = std::clamp(roi.y0_px + roi.height_px, y0, frame.height_px);
  out.x0_px = x0;
  out.y0_px = y0;
  out.step_px = step_px;
  out.width = (x1 - x0) / step_px;
  out.height = (y1 - y0) / step_px;
  switch (frame.format) {
    case PixelFormat::bgr:
      return read_rows<InterleavedRow<3, 2, 1, 0>>(frame, out);
    case PixelFormat::rgb:
      return read_rows<InterleavedRow<3, 0, 1, 2>>(frame, out);
    case PixelFormat::bgra:
      return read_rows<InterleavedRow<4, 2, 1, 0>>(frame, out);
    case PixelFormat::rgba:
      return read_rows<InterleavedRow<4, 0, 1, 2>>(frame, out);
    case PixelFormat::yuyv:
      return read_rows<YuyvRow>(frame, out);
    case PixelFormat::nv12:
      return read_rows<Nv12Row>(frame, out);
    case PixelFormat::gray:
      break;
  }
  out.width = out.height = 0;
}

}  // namespace handyar
