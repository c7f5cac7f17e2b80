// SPDX-License-Identifier: MIT
#include "encoder.hpp"

#include <algorithm>

#include "handyar/io/error.hpp"
#include "sources.hpp"

namespace handyar::io {

void Encoder::FormatCloser::operator()(AVFormatContext* format) const {
  avio_closep(&format->pb);
  avformat_free_context(format);
}

Encoder::Encoder(const std::string& path, int width_px, int height_px,
                 const std::vector<VideoCoding>& codings)
    : file_(path) {
  silence_libraries();
  AVFormatContext* format = nullptr;
  avformat_alloc_output_context2(&format, nullptr, nullptr, path.c_str());
  if (format == nullptr) throw Error(path, "cannot be written: there is no writer for its kind");
  format_.reset(format);
  if (std::none_of(codings.begin(), codings.end(),
                   [&](const VideoCoding& c) { return open(c, width_px, height_px); }))
    throw Error(path, "no video encoder for " + std::to_string(width_px) + "x" +
                          std::to_string(height_px) + " pixels was found");
  AVStream* const stream = avformat_new_stream(format, nullptr);
  stream->time_base = codec_->time_base;
  stream->avg_frame_rate = codec_->framerate;
  avcodec_parameters_from_context(stream->codecpar, codec_.get());
  const std::string url = "file:" + file_.path();  // a colon in its name makes no protocol
  require_written(avio_open(&format->pb, url.c_str(), AVIO_FLAG_WRITE));
  require_written(avformat_write_header(format, nullptr));
}

bool Encoder::open(const VideoCoding& coding, int width_px, int height_px) {
  const AVCodec* const encoder = avcodec_find_encoder(coding.codec);
  codec_.reset(encoder == nullptr ? nullptr : avcodec_alloc_context3(encoder));
  if (!codec_) return false;
  codec_->width = frame_->width = width_px;
  codec_->height = frame_->height = height_px;
  codec_->pix_fmt = coding.pixels;
  frame_->format = coding.pixels;
  codec_->time_base = coding.time_base;
  coding.set_up(*codec_);
  if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0)
    codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  return avcodec_open2(codec_.get(), encoder, nullptr) >= 0 &&
         av_frame_get_buffer(frame_.get(), 0) >= 0;
}

void Encoder::require_written(int code) const {
  if (code >= 0 && (format_->pb == nullptr || format_->pb->error >= 0)) return;
  char reason[AV_ERROR_MAX_STRING_SIZE] = "";
  av_strerror(code < 0 ? code : format_->pb->error, reason, sizeof reason);
  throw Error(file_.target(), std::string("cannot be written: ") + reason);
}

AVFrame& Encoder::picture() {
  if (av_frame_make_writable(frame_.get()) < 0) throw Error(file_.target(), "out of memory");
  return *frame_;
}

void Encoder::encode(const AVFrame* picture) {
  if (avcodec_send_frame(codec_.get(), picture) < 0)
    throw Error(file_.target(), "cannot be encoded");
  int received = 0;
  while ((received = avcodec_receive_packet(codec_.get(), packet_.get())) >= 0) {
    av_packet_rescale_ts(packet_.get(), codec_->time_base, format_->streams[0]->time_base);
    const int written = av_write_frame(format_.get(), packet_.get());
    av_packet_unref(packet_.get());
    require_written(written);
  }
  if (received != AVERROR(EAGAIN) && received != AVERROR_EOF)
    throw Error(file_.target(), "cannot be encoded");
}

void Encoder::write(std::int64_t time) {
  frame_->pts = time;
  encode(frame_.get());
}

void Encoder::finish() {
  encode(nullptr);
  require_written(av_write_trailer(format_.get()));
  require_written(avio_closep(&format_->pb));
  file_.commit();
}

}  // namespace handyar::io
