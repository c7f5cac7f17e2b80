// SPDX-License-Identifier: MIT
#include "handyar/mask.hpp"

#include <algorithm>
#include <cstring>
#include <functional>

#include "vectorised.hpp"

namespace handyar {
namespace {

using Word = std::uint64_t;

/// Words that `width` pixels and the margin between two rows take.
int words_for(int width) { return (width + Mask::kMargin + 63) / 64; }

/// Each pixel becomes the combination of itself and the pixels `by` to both sides of it.
template <class Combine>
[[gnu::always_inline]] inline void combine_across(const Mask& from, Mask& to, int by,
                                                  Combine combine) {
  const Word* __restrict p = from.words.data();
  Word* __restrict q = to.words.data();
  const int last = from.stride * from.rows() - 1;
  for (int i = 1; i < last; ++i) {
    const Word left = p[i] << by | p[i - 1] >> (64 - by);
    const Word right = p[i] >> by | p[i + 1] << (64 - by);
    q[i] = combine(p[i], combine(left, right));
  }
}

template <class Combine>
[[gnu::always_inline]] inline void combine_along(const Mask& from, Mask& to, int by,
                                                 Combine combine) {
  const std::ptrdiff_t step = static_cast<std::ptrdiff_t>(by) * from.stride;
  const Word* __restrict p = from.words.data();
  Word* __restrict q = to.words.data();
  const std::ptrdiff_t end = static_cast<std::ptrdiff_t>(from.stride) * from.rows() - step;
  for (std::ptrdiff_t i = step; i < end; ++i)
    q[i] = combine(p[i], combine(p[i - step], p[i + step]));
}

/// A window of 2 r + 1 pixels is three of 2 s + 1 that touch or overlap: few steps make a wide one.
template <class Combine>
[[gnu::always_inline]] inline void combine_square(Mask& mask, int radius, Mask& scratch,
                                                  Combine combine) {
  scratch.resize(mask.width, mask.height);
  for (int covered = 0; covered < radius;) {
    const int by = std::min(2 * covered + 1, radius - covered);
    combine_across(mask, scratch, by, combine);
    combine_along(scratch, mask, by, combine);
    covered += by;
  }
}

/// Calls `change` with each word that holds pixels u0 <= u < u1 of a row, and ones at these.
template <class Change>
void for_words(Word* row, int u0, int u1, Change change) {
  for (int u = u0; u < u1;) {
    const int end = std::min(u1, (u | 63) + 1), length = end - u;
    const Word ones = length == 64 ? ~Word{0} : (Word{1} << length) - 1;
    change(row[u >> 6], ones << (u & 63));
    u = end;
  }
}

}  // namespace

void Mask::reserve(int max_pixels, int max_side) {
  // Of the words of a row at most (kMargin + 63) / 64 hold no pixel, in the margin above and below
  // none does.
  words.resize(max_pixels / 64 + (kMargin + 63) * max_side / 64 + 1 +
               2 * kMargin * words_for(max_side));
}

void Mask::resize(int new_width, int new_height) noexcept {
  width = new_width;
  height = new_height;
  stride = words_for(width);
  std::fill_n(words.data(), static_cast<std::ptrdiff_t>(stride) * rows(), 0);
}

void Mask::copy(const Mask& other) noexcept {
  width = other.width;
  height = other.height;
  stride = other.stride;
  std::copy_n(other.words.data(), static_cast<std::ptrdiff_t>(stride) * rows(), words.data());
}

void Mask::set_row(int v, const std::uint8_t* flags) noexcept {
  static_assert(std::endian::native == std::endian::little);
  constexpr Word kGather = 0x0102040810204080;  // moves bit 0 of byte i to bit 56 + i
  Word* const to = row(v);
  for (int u = 0; u < width; u += 64) {
    Word word = 0;
    for (int i = 0; i < 8; ++i) {
      Word eight;
      std::memcpy(&eight, flags + u + 8 * i, 8);
      word |= eight * kGather >> 56 << (8 * i);
    }
    to[u >> 6] = word;
  }
  if ((width & 63) != 0) to[width >> 6] &= (Word{1} << (width & 63)) - 1;
}

void Mask::set_run(int v, int u0, int u1) noexcept {
  for_words(row(v), u0, u1, [](Word& word, Word run) { word |= run; });
}

void Mask::clear_run(int v, int u0, int u1) noexcept {
  for_words(row(v), u0, u1, [](Word& word, Word run) { word &= ~run; });
}

void Mask::pack(const std::uint8_t* from, int new_width, int new_height,
                std::ptrdiff_t stride_bytes) {
  reserve(new_width * new_height, std::max(new_width, new_height));
  resize(new_width, new_height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      if (from[v * stride_bytes + u] != 0) row(v)[u >> 6] |= Word{1} << (u & 63);
}

void Mask::unpack(std::uint8_t* to) const noexcept {
  for (int v = 0; v < height; ++v) {
    std::memset(to, 0, width);
    for (int u = next_set(v, 0); u < width;) {
      const int end = next_clear(v, u);
      std::memset(to + u, 255, end - u);
      u = next_set(v, end);
    }
    to += width;
  }
}

HANDYAR_VECTORISED void erode(Mask& mask, int radius, Mask& scratch) noexcept {
  combine_square(mask, radius, scratch, std::bit_and<Word>());
}

HANDYAR_VECTORISED void dilate(Mask& mask, int radius, Mask& scratch) noexcept {
  combine_square(mask, std::min(radius, kMaxDilation), scratch, std::bit_or<Word>());
}

HANDYAR_VECTORISED void majority(Mask& mask, Mask& scratch) noexcept {
  scratch.copy(mask);
  const Word* const p = scratch.words.data();
  const std::ptrdiff_t stride = mask.stride, end = stride * (mask.rows() - 1);
  const auto most = [](Word a, Word b, Word c) { return (a & b) | (c & (a | b)); };
  struct Count {  // of a pixel and its two neighbours in a row, 0 to 3
    Word one, two;
  };
  const auto count = [&](std::ptrdiff_t i) -> Count {
    const Word left = p[i] << 1 | p[i - 1] >> 63, right = p[i] >> 1 | p[i + 1] << 63;
    return {left ^ p[i] ^ right, most(left, p[i], right)};
  };
  for (std::ptrdiff_t i = stride + 1; i < end - 1; ++i) {
    if ((p[i] | p[i - stride] | p[i + stride]) == 0) {
      mask.words[i] = 0;  // a pixel beyond the word's ends sees at most three
      continue;
    }
    const Count a = count(i - stride), b = count(i), c = count(i + stride);
    const Word one = a.one ^ b.one ^ c.one, carry = most(a.one, b.one, c.one);
    const Word two = a.two ^ b.two ^ c.two, four = most(a.two, b.two, c.two);
    // The count is one + 2 (two + carry) + 4 four: five or more when the two fours are both there,
    // or one of them and any less.
    const Word two_sum = two ^ carry, four_sum = two & carry;
    mask.words[i] = (four & four_sum) | ((four ^ four_sum) & (two_sum | one));
  }
}

HANDYAR_VECTORISED void intersect(Mask& mask, const Mask& other) noexcept {
  const Word* __restrict from = other.words.data();
  Word* __restrict to = mask.words.data();
  const int count = mask.stride * mask.rows();
  for (int i = 0; i < count; ++i) to[i] &= from[i];
}

}  // namespace handyar
