// SPDX-License-Identifier: MIT
#include "v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "handyar/io/error.hpp"

extern "C" {
#include <libavutil/imgutils.h>
}

namespace handyar::io {
namespace {

constexpr int kTimeout_ms = 10'000, kPoll_ms = 100;
constexpr int kMostFaults = 100;  // pictures in a row that cannot be decoded
constexpr unsigned kBuffers = 4;
constexpr unsigned kWidth_px = 640, kHeight_px = 480, kFps = 30;  // where nothing else is asked for

struct Format {
  std::uint32_t fourcc;
  AVPixelFormat pixels;  // none: a JPEG
};
// Those first that cost least to read.
constexpr Format kFormats[] = {
    {V4L2_PIX_FMT_YUYV, AV_PIX_FMT_YUYV422}, {V4L2_PIX_FMT_UYVY, AV_PIX_FMT_UYVY422},
    {V4L2_PIX_FMT_NV12, AV_PIX_FMT_NV12},    {V4L2_PIX_FMT_YUV420, AV_PIX_FMT_YUV420P},
    {V4L2_PIX_FMT_BGR24, AV_PIX_FMT_BGR24},  {V4L2_PIX_FMT_RGB24, AV_PIX_FMT_RGB24},
    {V4L2_PIX_FMT_MJPEG, AV_PIX_FMT_NONE},   {V4L2_PIX_FMT_JPEG, AV_PIX_FMT_NONE},
    {V4L2_PIX_FMT_GREY, AV_PIX_FMT_GRAY8},
};

const Format* known(std::uint32_t fourcc) {
  const auto* const found =
      std::find_if(std::begin(kFormats), std::end(kFormats),
                   [&](const Format& format) { return format.fourcc == fourcc; });
  return found == std::end(kFormats) ? nullptr : found;
}

v4l2_buffer buffer_of(unsigned index) {
  v4l2_buffer buffer{};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  return buffer;
}

bool captures(const v4l2_capability& capability) {
  const auto flags = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                         ? capability.device_caps
                         : capability.capabilities;
  return (flags & V4L2_CAP_VIDEO_CAPTURE) != 0 && (flags & V4L2_CAP_STREAMING) != 0;
}

}  // namespace

V4l2Camera::V4l2Camera(const std::string& path, const CameraSettings& settings, DriverCalls& calls)
    : calls_(calls), device_(calls.open(path.c_str())) {
  if (device_ < 0)
    throw Error(path,
                std::string("no such camera, or it cannot be opened: ") + std::strerror(errno));
  v4l2_capability capability{};
  if (control(VIDIOC_QUERYCAP, &capability) && captures(capability) && set_format(settings)) {
    set_rate(settings.fps > 0 ? settings.fps : kFps);
    if (start()) return;
  }
  close();
  throw Error(path, "is not a camera, or another program uses it");
}

V4l2Camera::~V4l2Camera() { close(); }

void V4l2Camera::close() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  control(VIDIOC_STREAMOFF, &type);
  for (const Buffer& buffer : buffers_) calls_.unmap(buffer.at, buffer.bytes);
  calls_.close(device_);
}

bool V4l2Camera::control(unsigned long request, void* argument) {
  return calls_.control(device_, request, argument) >= 0;
}

bool V4l2Camera::set_format(const CameraSettings& settings) {
  std::vector<std::uint32_t> offered;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; control(VIDIOC_ENUM_FMT, &description); ++description.index)
    offered.push_back(description.pixelformat);
  const auto is_offered = [&](const Format& format) {
    return std::find(offered.begin(), offered.end(), format.fourcc) != offered.end();
  };
  const Format* chosen = std::find_if(std::begin(kFormats), std::end(kFormats), is_offered);
  // Large pictures come fast enough only when the camera compresses them.
  const Format* const jpeg = known(V4L2_PIX_FMT_MJPEG);
  if (settings.width_px > static_cast<int>(kWidth_px) && is_offered(*jpeg)) chosen = jpeg;
  if (chosen == std::end(kFormats)) return false;

  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format& pixels = format.fmt.pix;
  pixels.pixelformat = chosen->fourcc;
  pixels.field = V4L2_FIELD_ANY;
  const bool asked = settings.width_px > 0;
  pixels.width = asked ? static_cast<unsigned>(settings.width_px) : kWidth_px;
  pixels.height = asked ? static_cast<unsigned>(settings.height_px) : kHeight_px;
  if (!control(VIDIOC_S_FMT, &format)) return false;
  chosen = known(pixels.pixelformat);  // what the driver made of it
  if (chosen == nullptr || av_image_check_size(pixels.width, pixels.height, 0, nullptr) < 0)
    return false;
  stride_bytes_ = static_cast<int>(pixels.bytesperline);
  if (chosen->pixels == AV_PIX_FMT_NONE) {
    decoder_.emplace(AV_CODEC_ID_MJPEG);
    return true;
  }
  return make_room(*raw_, chosen->pixels, static_cast<int>(pixels.width),
                   static_cast<int>(pixels.height));
}

void V4l2Camera::set_rate(double fps) {
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_fract& step_s = rate.parm.capture.timeperframe;
  constexpr unsigned kParts = 1000;
  step_s = {kParts, static_cast<unsigned>(std::lround(fps * kParts))};
  control(VIDIOC_S_PARM, &rate);
  if (control(VIDIOC_G_PARM, &rate) && step_s.numerator > 0)
    fps_ = static_cast<double>(step_s.denominator) / step_s.numerator;
}

bool V4l2Camera::start() {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (!control(VIDIOC_REQBUFS, &request) || request.count == 0) return false;
  for (unsigned i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = buffer_of(i);
    if (!control(VIDIOC_QUERYBUF, &buffer)) return false;
    void* const at = calls_.map(device_, buffer.length, buffer.m.offset);
    if (at == nullptr) return false;
    buffers_.push_back({at, buffer.length});
    if (!control(VIDIOC_QBUF, &buffer)) return false;
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  return control(VIDIOC_STREAMON, &type);
}

// Whether there is a picture; in short waits, so that a stop is seen soon.
bool V4l2Camera::wait(const std::stop_token& stop) {
  for (int waited_ms = 0; waited_ms < kTimeout_ms; waited_ms += kPoll_ms) {
    if (stop.stop_requested()) return false;
    if (const int ready = calls_.poll(device_, kPoll_ms); ready != 0) return ready > 0;
  }
  return false;
}

bool V4l2Camera::read(cv::Mat& bgr, double& taken_s, const std::stop_token& stop) {
  for (int faults = 0; faults < kMostFaults; ++faults) {
    if (!wait(stop)) return false;
    v4l2_buffer buffer = buffer_of(0);
    if (!control(VIDIOC_DQBUF, &buffer)) {
      if (errno == EAGAIN) continue;
      return false;
    }
    if (buffer.index >= buffers_.size()) return false;
    const Buffer& filled = buffers_[buffer.index];
    const std::span bytes(static_cast<const std::uint8_t*>(filled.at),
                          std::min<std::size_t>(buffer.bytesused, filled.bytes));
    const bool sound = (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && convert(bytes, bgr);
    taken_s = static_cast<double>(buffer.timestamp.tv_sec) +
              static_cast<double>(buffer.timestamp.tv_usec) * 1e-6;
    if (!control(VIDIOC_QBUF, &buffer)) return false;
    if (sound) return true;
  }
  return false;
}

bool V4l2Camera::convert(std::span<const std::uint8_t> bytes, cv::Mat& bgr) {
  if (decoder_) {
    const AVFrame* const picture = decoder_->decode(bytes);
    return picture != nullptr && converter_.to_mat(*picture, AV_PIX_FMT_BGR24, bgr);
  }
  // Where each plane begins: a driver's rows may be longer than the picture's.
  const auto format = static_cast<AVPixelFormat>(raw_->format);
  std::uint8_t* planes[4];
  int strides[4];
  if (av_image_fill_linesizes(strides, format, raw_->width) < 0) return false;
  const int narrow = strides[0];
  for (int& stride : strides)
    if (stride_bytes_ > narrow)
      stride = static_cast<int>(std::int64_t{stride} * stride_bytes_ / narrow);
  const int needed = av_image_fill_pointers(planes, format, raw_->height,
                                            const_cast<std::uint8_t*>(bytes.data()), strides);
  if (needed < 0 || needed > std::ssize(bytes)) return false;
  av_image_copy(raw_->data, raw_->linesize, const_cast<const std::uint8_t**>(planes), strides,
                format, raw_->width, raw_->height);
  return converter_.to_mat(*raw_, AV_PIX_FMT_BGR24, bgr);
}

void V4l2Camera::lock() {
  for (auto [id, value] : {std::pair<unsigned, int>{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
                           {V4L2_CID_AUTO_WHITE_BALANCE, 0},
                           {V4L2_CID_FOCUS_AUTO, 0}}) {
    v4l2_control setting{id, value};
    control(VIDIOC_S_CTRL, &setting);  // a camera without it has nothing to lock
  }
}

}  // namespace handyar::io
