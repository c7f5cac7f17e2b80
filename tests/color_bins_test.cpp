// SPDX-License-Identifier: MIT
#include "handyar/color_bins.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "synthetic_hand.hpp"

namespace handyar {
namespace {

using test::random_for;

/// Three channels, R, G, B or Y, Cb, Cr; chroma the same in each 2x2 block where `blocks`.
struct Colors {
  int width, height;
  std::vector<std::array<int, 3>> at;
  const std::array<int, 3>& operator()(int x, int y) const { return at[y * width + x]; }
};

Colors random_colors(int width, int height, const std::string& name, bool blocks = false) {
  std::mt19937 rng = random_for(name);
  Colors c{width, height, std::vector<std::array<int, 3>>(width * height)};
  for (auto& p : c.at)
    for (int& channel : p) channel = static_cast<int>(rng() % 256);
  if (blocks)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (const int k : {1, 2}) c.at[y * width + x][k] = c(x & ~1, y & ~1)[k];
  return c;
}

/// A frame in memory that has no byte to spare: the sanitizers see any read beside it.
struct Stored {
  std::vector<std::uint8_t> luma, chroma;
  ImageView view;
};

Stored store(const Colors& c, PixelFormat format, int padding, bool bottom_up) {
  Stored s;
  const bool four = format == PixelFormat::bgra || format == PixelFormat::rgba;
  const bool nv12 = format == PixelFormat::nv12, yuyv = format == PixelFormat::yuyv;
  const int bytes = nv12 ? 1 : yuyv ? 2 : four ? 4 : 3;
  const int row = c.width * bytes, stride = row + padding;
  const auto allocate = [&](std::vector<std::uint8_t>& to, int rows) {
    to.assign(static_cast<std::size_t>(stride) * (rows - 1) + row, 99);
  };
  const auto place = [&](std::vector<std::uint8_t>& in, int y, int rows) {
    return in.data() + static_cast<std::ptrdiff_t>(stride) * (bottom_up ? rows - 1 - y : y);
  };
  allocate(s.luma, c.height);
  if (nv12) allocate(s.chroma, c.height / 2);
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const auto& [a, b, d] = c(x, y);
      std::uint8_t* p = place(s.luma, y, c.height) + x * bytes;
      if (nv12) {
        p[0] = static_cast<std::uint8_t>(a);
        std::uint8_t* q = place(s.chroma, y / 2, c.height / 2) + (x & ~1);
        q[0] = static_cast<std::uint8_t>(b);
        q[1] = static_cast<std::uint8_t>(d);
      } else if (yuyv) {
        p[0] = static_cast<std::uint8_t>(a);
        p[1] = static_cast<std::uint8_t>(x % 2 == 0 ? b : d);
      } else {
        const bool bgr = format == PixelFormat::bgr || format == PixelFormat::bgra;
        p[0] = static_cast<std::uint8_t>(bgr ? d : a);
        p[1] = static_cast<std::uint8_t>(b);
        p[2] = static_cast<std::uint8_t>(bgr ? a : d);
      }
    }
  const std::ptrdiff_t step = bottom_up ? -stride : stride;
  s.view = {place(s.luma, 0, c.height), c.width, c.height, step, format};
  if (nv12) {
    s.view.chroma = place(s.chroma, 0, c.height / 2);
    s.view.chroma_stride_bytes = step;
  }
  return s;
}

BinImage read(const ImageView& view, const PixelRect& roi, int step) {
  BinImage out;
  out.bins.resize(static_cast<std::size_t>(view.width_px) * view.height_px);
  read_bins(view, roi, step, out);
  return out;
}
BinImage read(const ImageView& view, int step) {
  return read(view, {0, 0, view.width_px, view.height_px}, step);
}

bool is_ycbcr(PixelFormat format) {
  return format == PixelFormat::yuyv || format == PixelFormat::nv12;
}

ColorBin bin_of(const std::array<int, 3>& c, PixelFormat format) {
  return is_ycbcr(format) ? bin_of_ycbcr(c[0], c[1], c[2]) : bin_of_rgb(c[0], c[1], c[2]);
}

/// Bin of the mean colour of the 2x2 pixels from (x, y).
ColorBin mean_bin(const Colors& c, int x, int y, PixelFormat format) {
  std::array<int, 3> mean{};
  for (const int k : {0, 1, 2})
    mean[k] = (c(x, y)[k] + c(x + 1, y)[k] + c(x, y + 1)[k] + c(x + 1, y + 1)[k]) / 4;
  return bin_of(mean, format);
}

class ColorBinsOfFormat : public testing::TestWithParam<PixelFormat> {
 protected:
  Colors colors() const { return random_colors(38, 26, "ColorBins", is_ycbcr(GetParam())); }
};

TEST_P(ColorBinsOfFormat, EveryPixelItsColourWhateverTheStride) {
  const Colors c = colors();
  for (const int padding : {0, 1, 10})
    for (const bool bottom_up : {false, true}) {
      const Stored s = store(c, GetParam(), padding, bottom_up);
      const BinImage image = read(s.view, 1);
      ASSERT_EQ(image.width, c.width);
      ASSERT_EQ(image.height, c.height);
      for (int y = 0; y < c.height; ++y)
        for (int x = 0; x < c.width; ++x) {
          ASSERT_EQ(image.bins[y * c.width + x], bin_of(c(x, y), GetParam()))
              << x << " " << y << " padding " << padding << " bottom_up " << bottom_up;
        }
    }
}

TEST_P(ColorBinsOfFormat, HalfSizeIsTheMeanOfFourPixels) {
  const Colors c = colors();
  const Stored s = store(c, GetParam(), 4, false);
  const BinImage image = read(s.view, {6, 4, 20, 10}, 2);
  ASSERT_EQ(image.width, 10);
  ASSERT_EQ(image.height, 5);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u)
      ASSERT_EQ(image.bins[v * image.width + u], mean_bin(c, 6 + 2 * u, 4 + 2 * v, GetParam()));
}

TEST_P(ColorBinsOfFormat, AThirdOfTheSizeStaysWithinTheBlocks) {
  Colors c = colors();
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x)
      c.at[y * c.width + x] = {x / 6 * 40 % 256, y / 6 * 50 % 256, 128};  // blocks of 6x6
  const Stored s = store(c, GetParam(), 0, true);
  const BinImage image = read(s.view, 3);
  ASSERT_EQ(image.width, 12);
  ASSERT_EQ(image.height, 8);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u) {
      ASSERT_EQ(image.bins[v * image.width + u], bin_of(c(3 * u, 3 * v), GetParam()))
          << u << " " << v;
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, ColorBinsOfFormat,
                         testing::Values(PixelFormat::bgr, PixelFormat::rgb, PixelFormat::bgra,
                                         PixelFormat::rgba, PixelFormat::yuyv, PixelFormat::nv12));

TEST(ColorBins, TheSamePictureInAnyOrderOfChannels) {
  const Colors c = random_colors(40, 30, "SamePicture");
  const BinImage rgb = read(store(c, PixelFormat::rgb, 0, false).view, 2);
  for (const PixelFormat format : {PixelFormat::bgr, PixelFormat::bgra, PixelFormat::rgba}) {
    const Stored s = store(c, format, 3, false);
    EXPECT_TRUE(std::ranges::equal(read(s.view, 2).used(), rgb.used())) << int(format);
  }
}

TEST(ColorBins, RegionsAreCutAtTheBorders) {
  const Colors c = random_colors(41, 31, "Cut");
  const Stored s = store(c, PixelFormat::rgb, 0, false);
  for (const int step : {1, 2, 3}) {
    const BinImage corner = read(s.view, {-7, -5, 20, 16}, step);
    EXPECT_EQ(corner.x0_px, 0);
    EXPECT_EQ(corner.y0_px, 0);
    EXPECT_EQ(corner.width, 13 / step);
    EXPECT_EQ(corner.height, 11 / step);
    const BinImage other = read(s.view, {30, 25, 100, 100}, step);
    EXPECT_EQ(other.x0_px, 30);
    EXPECT_EQ(other.width, 11 / step);
    EXPECT_EQ(other.height, 6 / step);
    for (const PixelRect& outside : {PixelRect{50, 5, 10, 10}, {5, -20, 10, 10}, {5, 5, 0, 10}})
      EXPECT_TRUE(read(s.view, outside, step).used().empty());
  }
}

TEST(ColorBins, CentresOfBinsInInputPixels) {
  BinImage image;
  image.x0_px = 10;
  image.y0_px = 20;
  EXPECT_EQ(image.x_px(3), 13);
  image.step_px = 2;  // the mean of pixels 10 and 11 lies between them
  EXPECT_EQ(image.x_px(0), 10.5);
  EXPECT_EQ(image.y_px(2), 24.5);
}

TEST(ColorBins, APictureTurnedByHalfATurnHasItsBinsTurned) {
  const Colors c = random_colors(60, 60, "Turned");
  Colors turned = c;
  std::ranges::reverse(turned.at);
  const Stored s = store(c, PixelFormat::rgb, 0, false),
               t = store(turned, PixelFormat::rgb, 0, false);
  for (const int step : {1, 2, 3, 4, 5, 6}) {  // else a bin would not lie where BinGrid says
    BinImage bins = read(s.view, step);
    bins.bins.resize(bins.used().size());
    std::ranges::reverse(bins.bins);
    EXPECT_TRUE(std::ranges::equal(bins.used(), read(t.view, step).used())) << step;
  }
}

TEST(ColorBins, ABinsCentreIsNearItsColours) {
  std::mt19937 rng = random_for("ColorBins.ABinsCentreIsNearItsColours");
  int fine = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3i c(rng() % 256, rng() % 256, rng() % 256);
    const ColorBin bin = bin_of_rgb(c[0], c[1], c[2]);
    const Eigen::Vector3d away = rgb_of(bin) - c.cast<double>();
    const auto is_fine = [](int level) { return level >= 4 && level < 28; };
    const bool both = is_fine(bin >> 5 & 31) && is_fine(bin & 31);
    fine += both;
    // Half a step of luma, and of the chromas by what they weigh in R, G and B.
    const double chroma = both ? 1.1 : 16.1;
    const Eigen::Vector3d limit(4.1 + 1.402 * chroma, 4.1 + 1.06 * chroma, 4.1 + 1.772 * chroma);
    ASSERT_TRUE((away.array().abs() <= limit.array()).all()) << c.transpose();
  }
  EXPECT_GT(fine, 2000);
  EXPECT_EQ(bin_of_rgb(0, 0, 0), 0 << 10 | 8 << 5 | 8);
  EXPECT_EQ(bin_of_rgb(255, 255, 255), 31 << 10 | 8 << 5 | 8);
}

TEST(ColorBins, ShadesOfSkinThatDifferByLittleAreTold) {
  // Redness of 18 and of 23, at the same luma: a hand before a wall of its colour.
  EXPECT_NE(bin_of_rgb(170, 140, 120), bin_of_rgb(176, 137, 120));
}

TEST(ColorBins, AColourHasTheSameBinHoweverTheCameraCodesIt) {
  const struct {
    int y, cb, cr;
    Eigen::Vector3i rgb;
  } cases[] = {{235, 128, 128, {255, 255, 255}}, {16, 128, 128, {0, 0, 0}},
               {81, 90, 240, {255, 0, 0}},       {145, 54, 34, {0, 255, 0}},
               {41, 240, 110, {0, 0, 255}},      {170, 108, 148, {211, 171, 139}},
               {86, 116, 141, {102, 74, 58}}};
  for (const auto& c : cases) {
    const int a = bin_of_ycbcr(c.y, c.cb, c.cr), b = bin_of_rgb(c.rgb[0], c.rgb[1], c.rgb[2]);
    for (const int shift : {0, 5, 10})
      EXPECT_LE(std::abs((a >> shift & 31) - (b >> shift & 31)), 1) << c.rgb.transpose();
  }
}

TEST(ColorBins, GreyHasNone) {
  const Colors c = random_colors(40, 30, "Grey");
  Stored s = store(c, PixelFormat::rgb, 0, false);
  s.view.format = PixelFormat::gray;
  EXPECT_TRUE(read(s.view, 1).used().empty());
}

}  // namespace
}  // namespace handyar
