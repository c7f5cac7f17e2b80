// SPDX-License-Identifier: MIT
#include "handyar/color_bins.hpp"

#include <algorithm>

namespace handyar {
namespace {

struct Color {
  int a, b, c;  // RGB or YCbCr, 0..255 (times the number of pixels summed)
};

/// Reads pixel x of a row of interleaved channels, `R`, `G`, `B` being the bytes' places.
template <int kBytes, int R, int G, int B>
struct InterleavedRow {
  const std::uint8_t* row;
  InterleavedRow(const ImageView& f, int y) : row(f.data + y * f.stride_bytes) {}
  Color operator()(int x) const {
    const std::uint8_t* p = row + x * kBytes;
    return {p[R], p[G], p[B]};
  }
  static ColorBin bin(const Color& p) { return bin_of_rgb(p.a, p.b, p.c); }
};

struct YuyvRow {
  const std::uint8_t* row;
  YuyvRow(const ImageView& f, int y) : row(f.data + y * f.stride_bytes) {}
  Color operator()(int x) const {
    const std::uint8_t* pair = row + (x & ~1) * 2;
    return {row[x * 2], pair[1], pair[3]};
  }
  static ColorBin bin(const Color& p) { return bin_of_ycbcr(p.a, p.b, p.c); }
};

struct Nv12Row {
  const std::uint8_t *luma, *chroma;
  Nv12Row(const ImageView& f, int y)
      : luma(f.data + y * f.stride_bytes), chroma(f.chroma + (y / 2) * f.chroma_stride_bytes) {}
  Color operator()(int x) const {
    const std::uint8_t* pair = chroma + (x & ~1);
    return {luma[x], pair[0], pair[1]};
  }
  static ColorBin bin(const Color& p) { return bin_of_ycbcr(p.a, p.b, p.c); }
};

template <class Row>
void read_rows(const ImageView& frame, BinImage& out) {
  ColorBin* to = out.bins.data();
  const int step = out.step_px, half = step / 2;
  for (int v = 0; v < out.height; ++v) {
    const int y = out.y0_px + v * step;
    const Row top(frame, y);
    if (step == 1) {
      for (int u = 0; u < out.width; ++u) *to++ = Row::bin(top(out.x0_px + u));
      continue;
    }
    const Row bottom(frame, y + half);
    for (int u = 0; u < out.width; ++u) {
      const int x = out.x0_px + u * step;
      const Color p = top(x), q = top(x + half), r = bottom(x), s = bottom(x + half);
      *to++ = Row::bin({(p.a + q.a + r.a + s.a) >> 2, (p.b + q.b + r.b + s.b) >> 2,
                        (p.c + q.c + r.c + s.c) >> 2});
    }
  }
}

}  // namespace

Eigen::Vector3d rgb_of(ColorBin bin) noexcept {
  const auto chroma = [](int level) {
    return level < kFineChroma     ? 32 * level - 120.0
           : level < kCoarseChroma ? 2 * level - 15.0
                                   : 32 * level - 840.0;
  };
  const double y = (bin >> 10) * 8 + 4.0, cb = -chroma(bin >> 5 & 31), cr = chroma(bin & 31);
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
