// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "libav.hpp"

namespace handyar::io {

/// Decodes pictures of which each stands alone.
class StillDecoder {
 public:
  explicit StillDecoder(AVCodecID codec);

  /// The picture in these bytes, there until the next; null: none that is sound.
  const AVFrame* decode(std::span<const std::uint8_t> bytes);

 private:
  Libav<AVCodecContext> codec_;
  Libav<AVPacket> packet_{av_packet_alloc()};
  Libav<AVFrame> frame_{av_frame_alloc()};
};

}  // namespace handyar::io
