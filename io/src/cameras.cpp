// SPDX-License-Identifier: MIT
#include "handyar/io/cameras.hpp"

#ifdef __linux__
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#else
#include "handyar/io/error.hpp"
#include "sources.hpp"
#endif

namespace handyar::io {

#ifdef __linux__
namespace {

// All sizes of all pixel formats.
std::vector<std::pair<int, int>> frame_sizes(int device) {
  std::set<std::pair<int, int>> sizes;
  v4l2_fmtdesc format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; ::ioctl(device, VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
    v4l2_frmsizeenum size{};
    size.pixel_format = format.pixelformat;
    for (; ::ioctl(device, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
        sizes.emplace(size.discrete.width, size.discrete.height);
        continue;
      }
      sizes.emplace(size.stepwise.min_width, size.stepwise.min_height);
      sizes.emplace(size.stepwise.max_width, size.stepwise.max_height);
      break;
    }
  }
  return {sizes.begin(), sizes.end()};
}

// False for what is no camera: an output, a decoder, the second node that carries only metadata.
bool describe(CameraInfo& camera) {
  const int device = ::open(camera.path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (device < 0) {
    camera.fault = std::strerror(errno);
    return true;
  }
  v4l2_capability capability{};
  bool captures = false;
  if (::ioctl(device, VIDIOC_QUERYCAP, &capability) == 0) {
    const auto flags = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                           ? capability.device_caps
                           : capability.capabilities;
    captures = (flags & V4L2_CAP_VIDEO_CAPTURE) != 0;
    const char* card = reinterpret_cast<const char*>(capability.card);
    camera.name.assign(card, ::strnlen(card, sizeof capability.card));
    if (captures) camera.sizes_px = frame_sizes(device);
  }
  ::close(device);
  return captures;
}

}  // namespace

std::vector<CameraInfo> list_cameras() {
  std::vector<std::pair<int, std::string>> nodes;
  std::error_code fault;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", fault)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("video") || name.size() < 6 || name.size() > 9) continue;
    const std::string number = name.substr(5);
    if (!std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); }))
      continue;
    nodes.emplace_back(std::stoi(number), entry.path().string());
  }
  std::sort(nodes.begin(), nodes.end());
  std::vector<CameraInfo> cameras;
  for (const auto& [number, path] : nodes) {
    CameraInfo camera;
    camera.path = path;
    if (describe(camera)) cameras.push_back(std::move(camera));
  }
  return cameras;
}
#else
std::vector<CameraInfo> list_cameras() { return {}; }

std::unique_ptr<FrameSource> open_camera(const std::string& device, const CameraSettings&) {
  throw Error(device, "cameras are opened on Linux only");
}
#endif

}  // namespace handyar::io
