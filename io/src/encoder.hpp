// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "handyar/io/pending_file.hpp"
#include "libav.hpp"

namespace handyar::io {

/// How pictures become a video.
struct VideoCoding {
  AVCodecID codec;
  AVPixelFormat pixels;
  AVRational time_base;                         ///< what the pictures' times are counted in
  std::function<void(AVCodecContext&)> set_up;  ///< what else the encoder is to be told
};

/// A file with one video in it, as libavcodec encodes and libavformat writes it; which container,
/// its name's extension says. The file takes its name on finish(). Throws Error.
class Encoder {
 public:
  /// The first of the codings for which there is an encoder here is taken.
  Encoder(const std::string& path, int width_px, int height_px,
          const std::vector<VideoCoding>& codings);

  /// The next picture, to be filled.
  AVFrame& picture();
  void write(std::int64_t time);
  void finish();

  const std::string& target() const { return file_.target(); }

 private:
  struct FormatCloser {
    void operator()(AVFormatContext* format) const;
  };

  bool open(const VideoCoding& coding, int width_px, int height_px);
  void encode(const AVFrame* picture);
  void require_written(int code) const;

  PendingFile file_;
  std::unique_ptr<AVFormatContext, FormatCloser> format_;
  Libav<AVCodecContext> codec_;
  Libav<AVPacket> packet_{av_packet_alloc()};
  Libav<AVFrame> frame_{av_frame_alloc()};
};

}  // namespace handyar::io
