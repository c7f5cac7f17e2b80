// SPDX-License-Identifier: MIT
#include "handyar/io/recording.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"
#include "libav.hpp"

namespace handyar::io {
namespace {

constexpr AVRational kMillisecond{1, 1000};  // Matroska counts in these
constexpr int kSlices = 4;                   // coded at the same time

}  // namespace

struct Recording::Impl {
  PendingFile file;
  AVFormatContext* format = nullptr;
  Libav<AVCodecContext> codec;
  Libav<AVPacket> packet{av_packet_alloc()};
  Libav<AVFrame> frame{av_frame_alloc()};
  std::int64_t last_ms = -1;

  explicit Impl(const std::string& path) : file(path) {}
  ~Impl() {
    if (format != nullptr) avio_closep(&format->pb);
    avformat_free_context(format);
  }

  void require(bool good, const char* what) const {
    if (!good) throw Error(file.target(), what);
  }

  void open(int width_px, int height_px) {
    const AVCodec* const encoder = avcodec_find_encoder(AV_CODEC_ID_FFV1);
    require(encoder != nullptr, "cannot be written: there is no encoder for FFV1");
    codec.reset(avcodec_alloc_context3(encoder));
    codec->width = width_px;
    codec->height = height_px;
    codec->pix_fmt = AV_PIX_FMT_BGR0;
    codec->time_base = kMillisecond;
    codec->level = 3;  // with slices
    codec->slices = kSlices;
    codec->thread_count = kSlices;
    codec->thread_type = FF_THREAD_SLICE;
    codec->gop_size = 1;  // every picture stands alone
    avformat_alloc_output_context2(&format, nullptr, "matroska", nullptr);
    require(format != nullptr, "cannot be written: there is no writer for Matroska");
    codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    require(avcodec_open2(codec.get(), encoder, nullptr) >= 0, "cannot be encoded in this size");
    AVStream* const stream = avformat_new_stream(format, nullptr);
    stream->time_base = kMillisecond;
    avcodec_parameters_from_context(stream->codecpar, codec.get());
    const std::string url = "file:" + file.path();
    require(avio_open(&format->pb, url.c_str(), AVIO_FLAG_WRITE) >= 0 &&
                avformat_write_header(format, nullptr) >= 0,
            "cannot be written");
    frame->format = codec->pix_fmt;
    frame->width = width_px;
    frame->height = height_px;
    require(av_frame_get_buffer(frame.get(), 0) >= 0, "out of memory");
  }

  /// Null: the end.
  void encode(const AVFrame* picture) {
    require(avcodec_send_frame(codec.get(), picture) >= 0, "cannot be encoded");
    while (avcodec_receive_packet(codec.get(), packet.get()) >= 0) {
      av_packet_rescale_ts(packet.get(), kMillisecond, format->streams[0]->time_base);
      require(av_write_frame(format, packet.get()) >= 0 && format->pb->error >= 0,
              "cannot be written");
      av_packet_unref(packet.get());
    }
  }
};

Recording::Recording(const std::string& path, int width_px, int height_px) {
  if (std::filesystem::path(path).extension() != ".mkv")
    throw Error(path, "its name must end in .mkv");
  av_log_set_level(AV_LOG_QUIET);
  impl_ = std::make_unique<Impl>(path);
  impl_->open(width_px, height_px);
}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;

void Recording::write(const cv::Mat& bgr, double time_s) {
  AVFrame& frame = *impl_->frame;
  impl_->require(av_frame_make_writable(&frame) >= 0, "out of memory");
  cv::Mat to(frame.height, frame.width, CV_8UC4, frame.data[0],
             static_cast<std::size_t>(frame.linesize[0]));
  cv::cvtColor(bgr, to, cv::COLOR_BGR2BGRA);
  impl_->last_ms = std::max<std::int64_t>(std::llround(time_s * 1000), impl_->last_ms + 1);
  frame.pts = impl_->last_ms;
  impl_->encode(&frame);
}

void Recording::finish() {
  Impl& r = *impl_;
  r.encode(nullptr);
  r.require(av_write_trailer(r.format) >= 0 && avio_closep(&r.format->pb) >= 0,
            "cannot be written whole");
  r.file.commit();
}

}  // namespace handyar::io
