// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace handyar {

/// Binary image of a bit a pixel, 64 in a word, the leftmost lowest. Around it lies a margin of
/// zeros, so that neighbours always exist and words can be shifted as one long row.
struct Mask {
  static constexpr int kMargin = 16;  ///< pixels, on every side

  int width = 0, height = 0;  ///< without the margin
  int stride = 0;             ///< words from row to row
  std::vector<std::uint64_t> words;

  /// Room for any mask of up to `max_pixels` in frames of up to `max_side` pixels a side.
  void reserve(int max_pixels, int max_side);
  /// Clears it.
  void resize(int new_width, int new_height) noexcept;
  void copy(const Mask& other) noexcept;  ///< keeps its own room

  int rows() const noexcept { return height + 2 * kMargin; }  ///< with the margin
  std::uint64_t* row(int v) noexcept { return words.data() + (v + kMargin) * stride; }
  const std::uint64_t* row(int v) const noexcept { return words.data() + (v + kMargin) * stride; }
  bool at(int u, int v) const noexcept { return row(v)[u >> 6] >> (u & 63) & 1; }
  /// The pixel in which a point lies.
  struct Pixel {
    int u, v;
    explicit Pixel(const Eigen::Vector2f& p) noexcept
        : u(static_cast<int>(std::lround(p.x()))), v(static_cast<int>(std::lround(p.y()))) {}
  };
  bool covers(const Pixel& p) const noexcept {
    return p.u >= 0 && p.v >= 0 && p.u < width && p.v < height;
  }
  /// That pixel is set; false outside.
  bool holds(const Eigen::Vector2f& point) const noexcept {
    const Pixel p(point);
    return covers(p) && at(p.u, p.v);
  }
  /// Sets that pixel; outside nothing.
  void set(const Eigen::Vector2f& point) noexcept {
    const Pixel p(point);
    if (covers(p)) row(p.v)[p.u >> 6] |= std::uint64_t{1} << (p.u & 63);
  }
  /// Sets row v from `width` bytes of 0 or 1; the row's last word is read to its end.
  void set_row(int v, const std::uint8_t* flags) noexcept;
  void set_run(int v, int u0, int u1) noexcept;  ///< u0 <= u < u1, within the row
  void clear_run(int v, int u0, int u1) noexcept;

  /// The first pixel of row v from u on that is set, or `width` or more; that is not set.
  int next_set(int v, int u) const noexcept {
    return u < width ? next(row(v), u, 0, (width - 1) >> 6) : width;
  }
  int next_clear(int v, int u) const noexcept { return next(row(v), u, ~std::uint64_t{0}, stride); }

  /// Becomes the bytes that are not 0, rows `stride_bytes` apart. Takes memory.
  void pack(const std::uint8_t* from, int new_width, int new_height, std::ptrdiff_t stride_bytes);

  /// Bytes of 255 (set) and 0, row by row without margin.
  void unpack(std::uint8_t* to) const noexcept;

 private:
  static int next(const std::uint64_t* row, int u, std::uint64_t flip, int last) noexcept {
    int i = u >> 6;
    std::uint64_t word = (row[i] ^ flip) >> (u & 63);
    if (word != 0) return u + std::countr_zero(word);
    while (++i <= last)
      if ((word = row[i] ^ flip) != 0) return i * 64 + std::countr_zero(word);
    return i * 64;
  }
};

/// Keeps the pixels around which a square of 2 * radius + 1 pixels a side is set; `scratch` is of
/// any size that was reserved like `mask`.
void erode(Mask& mask, int radius, Mask& scratch) noexcept;

/// Sets all pixels of such squares around those that are set, into the margin too: at most
/// kMaxDilation, and to be cut by intersect() afterwards.
void dilate(Mask& mask, int radius, Mask& scratch) noexcept;
inline constexpr int kMaxDilation = 9;

/// Sets the pixels of which at least five of nine, themselves and their neighbours, are set, and
/// clears the rest.
void majority(Mask& mask, Mask& scratch) noexcept;

/// Keeps what is set in both, which are of the same size.
void intersect(Mask& mask, const Mask& other) noexcept;

}  // namespace handyar
