// SPDX-License-Identifier: MIT
#include "handyar/image_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "image/pixel_reader.hpp"

namespace handyar {
namespace {

constexpr std::uint8_t kByte = 0;  // check() never reads a pixel

int bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::bgr:
    case PixelFormat::rgb:
      return 3;
    case PixelFormat::bgra:
    case PixelFormat::rgba:
      return 4;
    case PixelFormat::yuyv:
      return 2;
    default:
      return 1;
  }
}

ImageView view(int width, int height, PixelFormat format = PixelFormat::bgr) {
  ImageView v{&kByte, width, height, std::ptrdiff_t(width) * bytes_per_pixel(format), format};
  if (format == PixelFormat::nv12) {
    v.chroma = &kByte;
    v.chroma_stride_bytes = width;
  }
  return v;
}

constexpr PixelFormat kColorFormats[] = {PixelFormat::bgr,  PixelFormat::rgb,  PixelFormat::bgra,
                                         PixelFormat::rgba, PixelFormat::yuyv, PixelFormat::nv12};

TEST(ImageView, EveryColourFormatIsAccepted) {
  for (const PixelFormat format : kColorFormats)
    EXPECT_EQ(check(view(640, 480, format)), FrameStatus::ok) << int(format);
}

TEST(PixelReader, LumaOfAGreyIsTheSameInEveryFormat) {
  for (const int grey : {0, 60, 128, 255})
    for (const PixelFormat format : kColorFormats) {
      const bool packed = format == PixelFormat::yuyv, planar = format == PixelFormat::nv12;
      const auto y = static_cast<std::uint8_t>(std::lround(16 + 219 * grey / 255.0));
      std::vector<std::uint8_t> bytes(640 * 480 * 4, packed || planar ? y : std::uint8_t(grey));
      for (std::size_t i = 1; packed && i < bytes.size(); i += 2) bytes[i] = 128;
      const std::vector<std::uint8_t> chroma(640 * 240, 128);
      ImageView v = view(640, 480, format);
      v.data = bytes.data();
      if (planar) v.chroma = chroma.data();
      const PixelReader reader(v);
      EXPECT_NEAR(reader.luma(20.5f, 31.25f), grey, 1.1) << int(format);
      PixelGroup group;
      std::array<ColorBin, PixelGroup::kMost> bins;
      PixelGroup::Numbers luma;
      reader.read(20, 31, 0, group);
      reader.tell(group, bins, luma);
      EXPECT_NEAR(luma[0], grey, 1.1) << int(format);
    }
}

TEST(ImageView, GreyIsRefused) {
  EXPECT_EQ(check(view(640, 480, PixelFormat::gray)), FrameStatus::gray_unsupported);
}

TEST(ImageView, MissingDataIsRefused) {
  ImageView v = view(640, 480);
  v.data = nullptr;
  EXPECT_EQ(check(v), FrameStatus::no_data);
  EXPECT_EQ(check(ImageView{}), FrameStatus::no_data);
  v = view(640, 480, PixelFormat::nv12);
  v.chroma = nullptr;
  EXPECT_EQ(check(v), FrameStatus::no_data);
}

TEST(ImageView, SizesFrom160x120To4096x2160EitherWayRound) {
  for (const auto& [w, h] : {std::pair{160, 120}, {641, 479}, {4096, 2160}}) {
    EXPECT_EQ(check(view(w, h)), FrameStatus::ok) << w << "x" << h;
    EXPECT_EQ(check(view(h, w)), FrameStatus::ok) << h << "x" << w;
  }
  constexpr int kMax = std::numeric_limits<int>::max();
  for (const auto& [w, h] : {std::pair{159, 120},
                             {160, 119},
                             {4097, 2160},
                             {4096, 2161},
                             {2161, 2161},
                             {1, 1},
                             {0, 0},
                             {-640, 480},
                             {640, -480},
                             {kMax, kMax}}) {
    EXPECT_EQ(check(view(w, h)), FrameStatus::size_unsupported) << w << "x" << h;
    EXPECT_EQ(check(view(h, w)), FrameStatus::size_unsupported) << h << "x" << w;
  }
}

TEST(ImageView, SharedChromaNeedsEvenSizes) {
  EXPECT_EQ(check(view(641, 480, PixelFormat::yuyv)), FrameStatus::size_unsupported);
  EXPECT_EQ(check(view(640, 479, PixelFormat::yuyv)), FrameStatus::ok);
  EXPECT_EQ(check(view(641, 480, PixelFormat::nv12)), FrameStatus::size_unsupported);
  EXPECT_EQ(check(view(640, 479, PixelFormat::nv12)), FrameStatus::size_unsupported);
}

TEST(ImageView, RowsMayBePaddedOrStoredBottomUpButNotOverlap) {
  for (const PixelFormat format : kColorFormats) {
    ImageView v = view(640, 480, format);
    const std::ptrdiff_t row = v.stride_bytes;
    for (const std::ptrdiff_t stride : {row, row + 13, -row, -row - 13}) {
      v.stride_bytes = stride;
      EXPECT_EQ(check(v), FrameStatus::ok) << int(format) << " " << stride;
    }
    for (const std::ptrdiff_t stride : {row - 1, 1 - row, std::ptrdiff_t(0)}) {
      v.stride_bytes = stride;
      EXPECT_EQ(check(v), FrameStatus::stride_too_small) << int(format) << " " << stride;
    }
  }
  ImageView v = view(640, 480, PixelFormat::nv12);
  v.chroma_stride_bytes = -640;
  EXPECT_EQ(check(v), FrameStatus::ok);
  v.chroma_stride_bytes = 639;
  EXPECT_EQ(check(v), FrameStatus::stride_too_small);
}

TEST(ImageView, EveryStatusHasItsOwnLine) {
  std::string seen;
  for (int i = 0; i <= static_cast<int>(FrameStatus::time_not_increasing); ++i) {
    const std::string line = describe(static_cast<FrameStatus>(i));
    EXPECT_FALSE(line.empty());
    EXPECT_NE(line, "unknown");
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(seen.find("|" + line + "|"), std::string::npos) << line;
    seen += "|" + line + "|";
  }
}

}  // namespace
}  // namespace handyar
