// SPDX-License-Identifier: MIT
#include "handyar/io/picture_file.hpp"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"

namespace handyar::io {

// cv::imwrite does not notice when the disk is full.
void write_picture(const std::string& path, const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(std::filesystem::path(path).extension().string(), picture, bytes))
    throw Error(path, "cannot be encoded");
  write_text(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace handyar::io
