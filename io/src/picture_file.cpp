// SPDX-License-Identifier: MIT
#include "handyar/io/picture_file.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "exif.hpp"
#include "handyar/io/error.hpp"
#include "handyar/io/pending_file.hpp"
#include "pixels.hpp"
#include "sources.hpp"
#include "still_decoder.hpp"

extern "C" {
#include <libavutil/opt.h>
}

namespace handyar::io {
namespace {

using namespace std::string_view_literals;

constexpr std::int64_t kMostBytes = 1 << 30;

std::string_view text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

AVCodecID codec_of(std::string_view file) {
  static constexpr struct {
    std::string_view head;
    AVCodecID codec;
  } kFormats[] = {
      {"\xff\xd8\xff", AV_CODEC_ID_MJPEG},
      {"\x89PNG\r\n\x1a\n", AV_CODEC_ID_PNG},
      {"BM", AV_CODEC_ID_BMP},
      {"P4", AV_CODEC_ID_PBM},
      {"P1", AV_CODEC_ID_PBM},
      {"P5", AV_CODEC_ID_PGM},
      {"P2", AV_CODEC_ID_PGM},
      {"P6", AV_CODEC_ID_PPM},
      {"P3", AV_CODEC_ID_PPM},
      {"II*\0"sv, AV_CODEC_ID_TIFF},
      {"MM\0*"sv, AV_CODEC_ID_TIFF},
      {"RIFF", AV_CODEC_ID_WEBP},
      {"\0\0\0\x0cjP  "sv, AV_CODEC_ID_JPEG2000},
      {"\xff\x4f\xff\x51", AV_CODEC_ID_JPEG2000},
  };
  for (const auto& [head, codec] : kFormats)
    if (file.starts_with(head)) return codec;
  return AV_CODEC_ID_NONE;
}

// libavcodec gives a black picture of it.
bool is_jpeg_in_tiff(std::span<const std::uint8_t> bytes) {
  const int compression = exif_number(bytes, kCompressionTag);
  return codec_of(text(bytes)) == AV_CODEC_ID_TIFF && (compression == 6 || compression == 7);
}

// EXIF counts the eight ways in which a picture may lie.
void set_upright(cv::Mat& picture, int orientation) {
  if (orientation < 1 || orientation > 8) return;
  const auto is_one_of = [&](std::string_view numbers) {
    return numbers.find(static_cast<char>(orientation + '0')) != numbers.npos;
  };
  constexpr int kLeftRight = 1, kUpDown = 0;  // as cv::flip has them
  if (is_one_of("5678")) cv::transpose(picture, picture);
  if (is_one_of("2367")) cv::flip(picture, picture, kLeftRight);
  if (is_one_of("3478")) cv::flip(picture, picture, kUpDown);
}

// ITU T.81: segments with their length behind two bytes of marker, up to the picture's data, in
// which the end's marker does not occur. A smaller picture may lie whole in a segment before.
bool is_jpeg_cut_short(std::string_view file) {
  const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(file[at]); };
  for (std::size_t at = 2; at + 4 <= file.size();) {
    if (byte(at) != 0xff) return false;
    if (byte(at + 1) == 0xda) return file.find("\xff\xd9", at) == file.npos;
    at += byte(at + 1) == 0xff ? 1 : 2u + (byte(at + 2) << 8 | byte(at + 3));
  }
  return true;
}

std::vector<std::uint8_t> read_bytes(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw Error(path, "is not a file");  // a pipe would be waited for
  errno = 0;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file ? std::streamoff(file.tellg()) : -1;
  if (size > kMostBytes) throw Error(path, "is not a picture that can be read");
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::max<std::streamoff>(size, 0)));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), size))
    throw Error(path, std::string("cannot be read: ") +
                          (errno != 0 ? std::strerror(errno) : "unknown reason"));
  return bytes;
}

AVPixelFormat libav_format(PictureOptions::Pixels pixels) {
  switch (pixels) {
    case PictureOptions::Pixels::bgr:
      return AV_PIX_FMT_BGR24;
    case PictureOptions::Pixels::grey:
      return AV_PIX_FMT_GRAY8;
    case PictureOptions::Pixels::rgba:
      return AV_PIX_FMT_RGBA;
  }
  return AV_PIX_FMT_NONE;
}

// What libavcodec counts a JPEG's divisors in, so that the size and the error of a picture are
// about those that libjpeg gives it.
int jpeg_divisor(int quality) {
  const int libjpeg_percent = quality < 50 ? 5000 / std::max(quality, 1) : 200 - 2 * quality;
  return std::clamp((libjpeg_percent + 4) / 9, 1, 31);
}

}  // namespace

cv::Mat decode_picture(std::span<const std::uint8_t> bytes, std::string_view name,
                       const PictureOptions& options) {
  const std::string_view file = text(bytes);
  const bool cut_short = file.starts_with("\xff\xd8\xff") && is_jpeg_cut_short(file);
  if (cut_short) throw Error(name, "breaks off");  // what is missing would be grey
  StillDecoder decoder(codec_of(file));
  const AVFrame* const frame = is_jpeg_in_tiff(bytes) ? nullptr : decoder.decode(bytes);
  PixelConverter converter(PixelConverter::Care::exact);
  cv::Mat picture;
  if (frame == nullptr || !converter.to_mat(*frame, libav_format(options.pixels), picture))
    throw Error(name, "is not a picture that can be read");
  if (options.upright) set_upright(picture, exif_number(bytes, kOrientationTag));
  return picture;
}

cv::Mat read_picture(const std::string& path, const PictureOptions& options) {
  return decode_picture(read_bytes(path), path, options);
}

std::vector<std::uint8_t> encode_picture(const cv::Mat& picture, std::string_view extension,
                                         std::string_view name, int jpeg_quality) {
  const auto require = [&](bool good) {
    if (!good) throw Error(name, "cannot be encoded");
  };
  const bool png = extension == ".png", grey = picture.type() == CV_8UC1;
  if (!png && extension != ".jpg" && extension != ".jpeg")
    throw Error(name, "its name must end in .png, .jpg or .jpeg");
  const AVCodec* const encoder = avcodec_find_encoder(png ? AV_CODEC_ID_PNG : AV_CODEC_ID_MJPEG);
  silence_libraries();
  const Libav<AVCodecContext> codec(encoder == nullptr ? nullptr : avcodec_alloc_context3(encoder));
  const Libav<AVFrame> frame(av_frame_alloc());
  const Libav<AVPacket> packet(av_packet_alloc());
  const bool known = picture.type() == CV_8UC1 || picture.type() == CV_8UC3;
  require(codec && frame && packet && !picture.empty() && known);
  codec->width = frame->width = picture.cols;
  codec->height = frame->height = picture.rows;
  codec->pix_fmt = !png ? AV_PIX_FMT_YUVJ420P : grey ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_RGB24;
  frame->format = codec->pix_fmt;
  codec->time_base = {1, 1};
  codec->flags |= AV_CODEC_FLAG_QSCALE;
  codec->qmin = 1;
  codec->global_quality = frame->quality = jpeg_divisor(jpeg_quality) * FF_QP2LAMBDA;
  codec->compression_level = 1;  // of PNG: quick; what it saves is the filter's doing
  if (png) av_opt_set(codec->priv_data, "pred", "up", 0);
  PixelConverter converter(PixelConverter::Care::exact);
  require(avcodec_open2(codec.get(), encoder, nullptr) >= 0 &&
          av_frame_get_buffer(frame.get(), 0) >= 0 &&
          converter.to_frame(picture, grey ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_BGR24, *frame) &&
          avcodec_send_frame(codec.get(), frame.get()) >= 0 &&
          avcodec_send_frame(codec.get(), nullptr) >= 0 &&
          avcodec_receive_packet(codec.get(), packet.get()) >= 0);
  return {packet->data, packet->data + packet->size};
}

void write_picture(const std::string& path, const cv::Mat& picture) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const std::vector<std::uint8_t> bytes = encode_picture(picture, extension, path);
  write_text(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace handyar::io
