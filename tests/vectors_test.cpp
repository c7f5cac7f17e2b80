// SPDX-License-Identifier: MIT
//
// What is compiled for vectors gives the same bits as the plain instruction set.
#include <gtest/gtest.h>

#include "frame_path.hpp"
#include "hand_film.hpp"

namespace handyar_plain {
FramePath read_colors(const FrameBytes& frame, int step_px);
FramePath look_for_hand(const FrameBytes& frame);
}  // namespace handyar_plain

namespace handyar {
namespace {

TEST(Vectors, ReadTheSameColors) {
  constexpr int kWidth = 310, kHeight = 62, kStride = 4 * kWidth;  // room for any format
  std::mt19937 rng = test::random_for("Vectors.ReadTheSameColors");
  std::vector<std::uint8_t> bytes(kStride * kHeight * 2);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(rng() % 256);
  for (int format = 0; format < static_cast<int>(PixelFormat::gray); ++format)
    for (const int step_px : {1, 2, 3, 4}) {
      const FrameBytes frame{bytes.data(), kWidth, kHeight, kStride, format};
      const FramePath plain = handyar_plain::read_colors(frame, step_px);
      EXPECT_EQ(read_colors(frame, step_px), plain) << format << " step " << step_px;
      EXPECT_EQ(plain.size(), 1 + 2 * std::size_t(300 / step_px) * (57 / step_px));
    }
}

TEST(Vectors, FindTheSameHand) {
  test::Film film;
  film.textured = true;
  film.noise = 3;
  film.T_camera_hand = film.pose_at(0);
  const test::Picture picture = film.picture();
  const ImageView view = picture.view();
  const FrameBytes frame{view.data, view.width_px, view.height_px, view.stride_bytes, 0};
  const FramePath plain = handyar_plain::look_for_hand(frame);
  EXPECT_EQ(look_for_hand(frame), plain);
  EXPECT_GT(plain.size(), 5 * std::size_t(320 * 240)) << "no hand was found";
}

}  // namespace
}  // namespace handyar
