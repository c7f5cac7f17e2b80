// SPDX-License-Identifier: MIT
#include "decoder.hpp"

#include <cmath>
#include <limits>

#include "handyar/io/error.hpp"
#include "pixels.hpp"
#include "sources.hpp"

extern "C" {
#include <libavutil/display.h>
}

namespace handyar::io {
namespace {

constexpr int kMostFaults = 1000;  // in a row, of reading: what comes then is no longer the video

struct FormatCloser {
  void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
};
using Format = std::unique_ptr<AVFormatContext, FormatCloser>;

Format opened(const std::string& path) {
  AVFormatContext* format = nullptr;
  const std::string file = "file:" + path;  // a colon in its name makes no protocol
  if (avformat_open_input(&format, file.c_str(), nullptr, nullptr) < 0) return nullptr;
  return Format(format);
}

}  // namespace

struct Decoder::Impl {
  Format format;
  Libav<AVCodecContext> codec;
  Libav<AVPacket> packet{av_packet_alloc()};
  Libav<AVFrame> frame{av_frame_alloc()};
  PixelConverter converter{PixelConverter::Care::fast};
  AVStream* stream = nullptr;
  bool ended = false;
  int faults = 0;

  explicit Impl(const std::string& path) : format(opened(path)) {
    const auto fail = [&] { throw Error(path, "is not a video that can be read"); };
    if (!format || avformat_find_stream_info(format.get(), nullptr) < 0) fail();
    const AVCodec* decoder = nullptr;
    const int best = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
    if (best < 0 || decoder == nullptr) fail();
    for (unsigned i = 0; i < format->nb_streams; ++i)
      if (static_cast<int>(i) != best) format->streams[i]->discard = AVDISCARD_ALL;
    stream = format->streams[best];
    codec.reset(avcodec_alloc_context3(decoder));
    if (!codec || avcodec_parameters_to_context(codec.get(), stream->codecpar) < 0) fail();
    codec->thread_count = 1;  // frames decoded side by side hide their faults, now and then
    if (avcodec_open2(codec.get(), decoder, nullptr) < 0) fail();
  }

  /// The next packet of the video goes into the decoder; false on damage.
  bool feed() {
    const int read = av_read_frame(format.get(), packet.get());
    if (read < 0) {
      const bool damaged = read != AVERROR_EOF && ++faults < kMostFaults;
      if (damaged) return false;
      ended = true;
      avcodec_send_packet(codec.get(), nullptr);
      return true;
    }
    faults = 0;
    const bool ours = packet->stream_index == stream->index;
    bool sound = true;
    if (ours) {
      sound = (packet->flags & AV_PKT_FLAG_CORRUPT) == 0;
      const int sent = avcodec_send_packet(codec.get(), packet.get());
      sound = sound && (sent >= 0 || sent == AVERROR(EAGAIN));
    }
    av_packet_unref(packet.get());
    return sound;
  }
};

Decoder::Decoder(const std::string& path) {
  silence_libraries();
  impl_ = std::make_unique<Impl>(path);
}
Decoder::~Decoder() = default;

Decoder::Step Decoder::next(cv::Mat& bgr, double& time_s) {
  for (;;) {
    const int received = avcodec_receive_frame(impl_->codec.get(), impl_->frame.get());
    const AVFrame& frame = *impl_->frame;
    if (received == 0) {
      const bool sound =
          frame.decode_error_flags == 0 && (frame.flags & AV_FRAME_FLAG_CORRUPT) == 0;
      const std::int64_t stamp = frame.best_effort_timestamp;
      time_s = stamp == AV_NOPTS_VALUE
                   ? std::numeric_limits<double>::quiet_NaN()
                   : static_cast<double>(stamp) * av_q2d(impl_->stream->time_base);
      return sound && impl_->converter.to_mat(frame, AV_PIX_FMT_BGR24, bgr) ? Step::picture
                                                                            : Step::damage;
    }
    if (received == AVERROR_EOF) return Step::end;
    if (received != AVERROR(EAGAIN)) return Step::damage;
    if (impl_->ended) return Step::end;
    if (!impl_->feed()) return Step::damage;
  }
}

double Decoder::fps() const {
  const AVStream& s = *impl_->stream;
  for (const AVRational rate : {s.avg_frame_rate, s.r_frame_rate})
    if (rate.num > 0 && rate.den > 0) return av_q2d(rate);
  return 0;
}

std::int64_t Decoder::frame_count() const {
  const AVStream& s = *impl_->stream;
  if (s.nb_frames > 0) return s.nb_frames;
  const std::int64_t duration = impl_->format->duration;
  if (duration <= 0) return 0;
  return std::llround(static_cast<double>(duration) / AV_TIME_BASE * fps());
}

int Decoder::clockwise_deg() const {
  const auto* const matrix = reinterpret_cast<const std::int32_t*>(
      av_stream_get_side_data(impl_->stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr));
  if (matrix == nullptr) return 0;
  const double counter_clockwise_deg = av_display_rotation_get(matrix);
  if (!std::isfinite(counter_clockwise_deg)) return 0;
  return static_cast<int>((std::lround(-counter_clockwise_deg) % 360 + 360) % 360);
}

std::int64_t count_packets(const std::string& path) {
  const Format format = opened(path);
  if (!format || avformat_find_stream_info(format.get(), nullptr) < 0) return 0;
  const int best = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  const Libav<AVPacket> packet(av_packet_alloc());
  std::int64_t count = 0;
  while (av_read_frame(format.get(), packet.get()) >= 0) {
    count += packet->stream_index == best;
    av_packet_unref(packet.get());
  }
  return count;
}

}  // namespace handyar::io
