// SPDX-License-Identifier: MIT
#include "still_decoder.hpp"

#include <cstring>

#include "sources.hpp"

namespace handyar::io {

constexpr std::int64_t kMostPixels = 1 << 28;  // the largest of telephones have 200 million
constexpr std::ptrdiff_t kMostBytes = 1 << 30;

StillDecoder::StillDecoder(AVCodecID codec) {
  silence_libraries();
  const AVCodec* const decoder = avcodec_find_decoder(codec);
  codec_.reset(decoder == nullptr ? nullptr : avcodec_alloc_context3(decoder));
  if (!codec_) return;
  codec_->thread_count = 1;  // others would wait for the pictures that follow
  codec_->max_pixels = kMostPixels;
  // Of a TIFF it would refuse what it does not know, sound or not.
  if (codec != AV_CODEC_ID_TIFF) codec_->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
  if (avcodec_open2(codec_.get(), decoder, nullptr) < 0) codec_.reset();
}

const AVFrame* StillDecoder::decode(std::span<const std::uint8_t> bytes) {
  if (!codec_ || bytes.empty() || std::ssize(bytes) > kMostBytes ||
      av_new_packet(packet_.get(), static_cast<int>(bytes.size())) < 0)
    return nullptr;
  std::memcpy(packet_->data, bytes.data(), bytes.size());
  const bool decoded = avcodec_send_packet(codec_.get(), packet_.get()) >= 0 &&
                       avcodec_receive_frame(codec_.get(), frame_.get()) >= 0;
  av_packet_unref(packet_.get());
  if (!decoded) avcodec_flush_buffers(codec_.get());
  const bool sound =
      decoded && frame_->decode_error_flags == 0 && (frame_->flags & AV_FRAME_FLAG_CORRUPT) == 0;
  return sound ? frame_.get() : nullptr;
}

}  // namespace handyar::io
