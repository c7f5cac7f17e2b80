// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace handyar::io {

struct PictureOptions {
  enum class Pixels { bgr, grey, rgba } pixels = Pixels::bgr;  ///< 8 bit each
  /// Turned and mirrored as its EXIF says; or the pixels as they are stored.
  bool upright = true;
};

/// Reads a PNG, JPEG, BMP, PNM, TIFF, WebP or JPEG 2000, whatever its name. Throws Error, also when
/// the picture breaks off.
cv::Mat read_picture(const std::string& path, const PictureOptions& options = {});

/// The same from a file's bytes; `name` stands for the file in messages.
cv::Mat decode_picture(std::span<const std::uint8_t> bytes, std::string_view name,
                       const PictureOptions& options = {});

/// A file's bytes of a picture (8-bit grey or BGR): `extension` is .png, .jpg or .jpeg. The quality
/// of a JPEG is what libjpeg calls so, about: 1 to 100. Throws Error, which begins with `name`.
std::vector<std::uint8_t> encode_picture(const cv::Mat& picture, std::string_view extension,
                                         std::string_view name, int jpeg_quality = 95);

/// Writes a picture whole or not at all, in the format of its name's extension; throws Error.
void write_picture(const std::string& path, const cv::Mat& picture);

}  // namespace handyar::io
