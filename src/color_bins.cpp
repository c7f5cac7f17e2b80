// SPDX-License-Identifier: MIT
#include "handyar/color_bins.hpp"

#include <algorithm>

#include "vectorised.hpp"

namespace handyar {
namespace {

struct Color {
  int a, b, c;  // RGB or YCbCr, 0..255 (times the number of pixels summed)

  [[gnu::always_inline]] Color operator+(const Color& o) const {
    return {a + o.a, b + o.b, c + o.c};
  }
};

/// Asks for bytes that will be read soon. Of the rows of a part of a frame, the next is nowhere
/// near the end of the last, and hardware does not foresee it.
inline void fetch(const std::uint8_t* from, const std::uint8_t* to) {
  constexpr int kCacheLine = 64;
  for (; from < to; from += kCacheLine) __builtin_prefetch(from);
}

/// Reads pixel x of a row of interleaved channels, `R`, `G`, `B` being the bytes' places.
template <int kBytes, int R, int G, int B>
struct InterleavedRow {
  const std::uint8_t* row;
  InterleavedRow(const ImageView& f, int y) : row(f.data + y * f.stride_bytes) {}
  [[gnu::always_inline]] Color operator()(int x) const {
    const std::uint8_t* p = row + x * kBytes;
    return {p[R], p[G], p[B]};
  }
  [[gnu::always_inline]] static ColorBin bin(const Color& p) { return bin_of_rgb(p.a, p.b, p.c); }
  void prefetch(int x0, int x1) const { fetch(row + x0 * kBytes, row + x1 * kBytes); }
};

struct YuyvRow {
  const std::uint8_t* row;
  YuyvRow(const ImageView& f, int y) : row(f.data + y * f.stride_bytes) {}
  [[gnu::always_inline]] Color operator()(int x) const {
    const std::uint8_t* pair = row + (x & ~1) * 2;
    return {row[x * 2], pair[1], pair[3]};
  }
  [[gnu::always_inline]] static ColorBin bin(const Color& p) { return bin_of_ycbcr(p.a, p.b, p.c); }
  void prefetch(int x0, int x1) const { fetch(row + x0 * 2, row + x1 * 2); }
};

struct Nv12Row {
  const std::uint8_t *luma, *chroma;
  Nv12Row(const ImageView& f, int y)
      : luma(f.data + y * f.stride_bytes), chroma(f.chroma + (y / 2) * f.chroma_stride_bytes) {}
  [[gnu::always_inline]] Color operator()(int x) const {
    const std::uint8_t* pair = chroma + (x & ~1);
    return {luma[x], pair[0], pair[1]};
  }
  [[gnu::always_inline]] static ColorBin bin(const Color& p) { return bin_of_ycbcr(p.a, p.b, p.c); }
  void prefetch(int x0, int x1) const {
    fetch(luma + x0, luma + x1);
    fetch(chroma + x0, chroma + x1);
  }
};

/// Of a block's rows and of its columns two are read, as far apart as a quarter of the block leaves
/// on either side: their mean lies in its middle.
struct Read {
  int first, apart;

  explicit Read(int step) : first(step / 4), apart(step - 1 - 2 * first) {}
};

constexpr int kChunk = 256;    // pixels whose sums lie in the first-level cache
constexpr int kRowsAhead = 2;  // rows of `out` that are fetched before they are read

/// Sums of pixels channel by channel. They are read in one loop and made bins in another: each can
/// be vectorised.
struct Sums {
  std::uint16_t a[2 * kChunk], b[2 * kChunk], c[2 * kChunk];

  [[gnu::always_inline]] void set(int k, const Color& p) {
    a[k] = static_cast<std::uint16_t>(p.a);
    b[k] = static_cast<std::uint16_t>(p.b);
    c[k] = static_cast<std::uint16_t>(p.c);
  }
};

/// `count` bins from pixel x0 of two rows of their blocks on.
template <class Row>
[[gnu::always_inline]] inline void read_chunk(const Row& top, const Row& bottom, int x0, int step,
                                              int count, ColorBin* to) {
  Sums s;
  if (step == 1) {
    for (int k = 0; k < count; ++k) s.set(k, top(x0 + k));
    for (int k = 0; k < count; ++k) to[k] = Row::bin({s.a[k], s.b[k], s.c[k]});
  } else if (step == 2) {
    for (int k = 0; k < 2 * count; ++k) s.set(k, top(x0 + k) + bottom(x0 + k));
    for (int k = 0; k < count; ++k)
      to[k] = Row::bin({(s.a[2 * k] + s.a[2 * k + 1]) >> 2, (s.b[2 * k] + s.b[2 * k + 1]) >> 2,
                        (s.c[2 * k] + s.c[2 * k + 1]) >> 2});
  } else {
    const Read read(step);
    for (int k = 0, x = x0 + read.first; k < count; ++k, x += step)
      s.set(k, top(x) + top(x + read.apart) + bottom(x) + bottom(x + read.apart));
    for (int k = 0; k < count; ++k) to[k] = Row::bin({s.a[k] >> 2, s.b[k] >> 2, s.c[k] >> 2});
  }
}

template <class Row>
[[gnu::always_inline]] inline void read_rows(const ImageView& frame, BinImage& out) {
  ColorBin* to = out.bins.data();
  const int step = out.step_px;
  const Read read(step);
  const int x0 = out.x0_px, x1 = x0 + out.width * step;
  for (int v = 0; v < out.height; ++v, to += out.width) {
    const int y = out.y0_px + v * step + read.first,
              ahead = std::min(y + kRowsAhead * step, frame.height_px - step + read.first);
    Row(frame, ahead).prefetch(x0, x1);
    if (step > 1) Row(frame, ahead + read.apart).prefetch(x0, x1);
    const Row top(frame, y), bottom(frame, y + read.apart);
    for (int u = 0; u < out.width; u += kChunk)
      read_chunk(top, bottom, x0 + u * step, step, std::min(kChunk, out.width - u), to + u);
  }
}

HANDYAR_VECTORISED void read_bgr(const ImageView& frame, BinImage& out) {
  read_rows<InterleavedRow<3, 2, 1, 0>>(frame, out);
}
HANDYAR_VECTORISED void read_rgb(const ImageView& frame, BinImage& out) {
  read_rows<InterleavedRow<3, 0, 1, 2>>(frame, out);
}
HANDYAR_VECTORISED void read_bgra(const ImageView& frame, BinImage& out) {
  read_rows<InterleavedRow<4, 2, 1, 0>>(frame, out);
}
HANDYAR_VECTORISED void read_rgba(const ImageView& frame, BinImage& out) {
  read_rows<InterleavedRow<4, 0, 1, 2>>(frame, out);
}
HANDYAR_VECTORISED void read_yuyv(const ImageView& frame, BinImage& out) {
  read_rows<YuyvRow>(frame, out);
}
HANDYAR_VECTORISED void read_nv12(const ImageView& frame, BinImage& out) {
  read_rows<Nv12Row>(frame, out);
}

}  // namespace

Eigen::Vector3d rgb_of(ColorBin bin) noexcept {
  const auto [y, cb, cr] = ycbcr_of(bin);
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
      return read_bgr(frame, out);
    case PixelFormat::rgb:
      return read_rgb(frame, out);
    case PixelFormat::bgra:
      return read_bgra(frame, out);
    case PixelFormat::rgba:
      return read_rgba(frame, out);
    case PixelFormat::yuyv:
      return read_yuyv(frame, out);
    case PixelFormat::nv12:
      return read_nv12(frame, out);
    case PixelFormat::gray:
      break;
  }
  out.width = out.height = 0;
}

}  // namespace handyar
