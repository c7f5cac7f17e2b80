// SPDX-License-Identifier: MIT
#include "pixels.hpp"

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

namespace handyar::io {

bool make_room(AVFrame& picture, AVPixelFormat format, int width_px, int height_px) {
  if (picture.data[0] != nullptr && picture.format == format && picture.width == width_px &&
      picture.height == height_px)
    return true;
  av_frame_unref(&picture);
  picture.format = format;
  picture.width = width_px;
  picture.height = height_px;
  return av_frame_get_buffer(&picture, 0) >= 0;
}

bool PixelConverter::prepare(int width_px, int height_px, AVPixelFormat from, AVPixelFormat to) {
  constexpr int kExact = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP;
  scaler_.reset(sws_getCachedContext(scaler_.release(), width_px, height_px, from, width_px,
                                     height_px, to, care_ == Care::exact ? kExact : SWS_BICUBIC,
                                     nullptr, nullptr, nullptr));
  return scaler_ != nullptr;
}

bool PixelConverter::to_mat(const AVFrame& from, AVPixelFormat format, cv::Mat& to) {
  const AVPixelFormat stored = static_cast<AVPixelFormat>(from.format);
  if (care_ == Care::fast || av_pix_fmt_desc_get(stored)->comp[0].depth <= 8)
    return fill(from, format, CV_8U, to);
  // Of 16 bit it would give a 256th, rounded, where a 257th is meant.
  const AVPixelFormat wide = format == AV_PIX_FMT_GRAY8  ? AV_PIX_FMT_GRAY16
                             : format == AV_PIX_FMT_RGBA ? AV_PIX_FMT_RGBA64
                                                         : AV_PIX_FMT_BGR48;
  cv::Mat deep;
  if (!fill(from, wide, CV_16U, deep)) return false;
  deep.convertTo(to, CV_8U, 1.0 / 257);
  return true;
}

bool PixelConverter::fill(const AVFrame& from, AVPixelFormat format, int depth, cv::Mat& to) {
  if (!prepare(from.width, from.height, static_cast<AVPixelFormat>(from.format), format))
    return false;
  // It writes whole blocks of pixels, and leaves the last ones out where a row has no room.
  constexpr int kBlock = 32;
  const int room = (from.width + kBlock - 1) / kBlock * kBlock;
  cv::Mat& rows = room == from.width ? to : wide_;
  rows.create(from.height, room, CV_MAKETYPE(depth, av_pix_fmt_desc_get(format)->nb_components));
  std::uint8_t* const data[] = {rows.data, nullptr, nullptr, nullptr};
  const int strides[] = {static_cast<int>(rows.step[0]), 0, 0, 0};
  if (sws_scale(scaler_.get(), from.data, from.linesize, 0, from.height, data, strides) !=
      from.height)
    return false;
  if (room != from.width) wide_.colRange(0, from.width).copyTo(to);
  return true;
}

bool PixelConverter::to_frame(const cv::Mat& from, AVPixelFormat format, AVFrame& to) {
  if (!prepare(to.width, to.height, format, static_cast<AVPixelFormat>(to.format)) ||
      !make_room(*padded_, format, to.width, to.height))
    return false;
  const std::uint8_t* data[] = {from.data, nullptr, nullptr, nullptr};
  const int strides[] = {static_cast<int>(from.step[0]), 0, 0, 0};
  av_image_copy(padded_->data, padded_->linesize, data, strides, format, to.width, to.height);
  return sws_scale(scaler_.get(), padded_->data, padded_->linesize, 0, to.height, to.data,
                   to.linesize) == to.height;
}

}  // namespace handyar::io
