// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "handyar.h"

namespace {

/// The data's bytes, one after the other; zeros when they are used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : next_(data), left_(size) {}

  bool empty() const { return left_ == 0; }
  template <class T>
  T take() {
    T value{};
    const std::size_t count = std::min(sizeof value, left_);
    std::memcpy(&value, next_, count);
    next_ += count;
    left_ -= count;
    return value;
  }
  bool coin() { return (take<std::uint8_t>() & 1) != 0; }

 private:
  const std::uint8_t* next_;
  std::size_t left_;
};

/// A struct as a good caller sets it, with some of its words, `size` among them, overwritten. It
/// lies in memory of just the size that it claims: what is read or written beyond is found.
template <class T>
struct Passed {
  std::unique_ptr<void, decltype(&std::free)> memory{nullptr, &std::free};

  Passed(Bytes& bytes, T good) {
    good.size = sizeof(T);
    for (int count = bytes.take<std::uint8_t>() % 4; count > 0; --count) {
      const std::size_t at = bytes.take<std::uint16_t>() % (sizeof(T) - 7) / 4 * 4;
      const bool wide = bytes.coin();
      const auto word = bytes.take<std::uint64_t>();
      std::memcpy(reinterpret_cast<char*>(&good) + at, &word, wide ? 8 : 4);
    }
    good.size %= 2 * sizeof(T);
    memory.reset(std::calloc(1, std::max<std::size_t>(good.size, sizeof(std::uint32_t))));
    std::memcpy(memory.get(), &good,
                std::clamp<std::size_t>(good.size, sizeof(std::uint32_t), sizeof(T)));
  }
  T* get() const { return static_cast<T*>(memory.get()); }
};

handyar_frame frame_of(Bytes& bytes, const std::vector<std::uint8_t>& pixels) {
  handyar_frame frame{};
  frame.format = bytes.take<std::uint8_t>() % 9 - 1;
  frame.width_px = 160 + bytes.take<std::uint8_t>() % 4;
  frame.height_px = 120;
  frame.data = bytes.coin() ? nullptr : pixels.data();
  frame.chroma = frame.data;
  frame.stride_bytes = frame.chroma_stride_bytes = 4L * 163;
  return frame;
}

}  // namespace

// Any calls in any order, with structs of any size and any numbers in them. Of frames, only what
// the library can judge is fuzzed here: that a pointer leads to as much as is said is for the
// caller.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<std::uint8_t> pixels(4 * 163 * 120 * 2, 127);
  Bytes bytes(data, size);
  handyar_camera camera{};
  camera.size = sizeof camera;
  handyar_camera_from_field_of_view(160, 120, HANDYAR_FIELD_OF_VIEW_RAD, &camera);
  handyar_hand hand{};
  hand.size = sizeof hand;
  handyar_average_hand(&hand);
  handyar_options options{};
  options.size = sizeof options;
  handyar_default_options(&options);

  const Passed given_camera(bytes, camera);
  const Passed given_hand(bytes, hand);
  const Passed given_options(bytes, options);
  handyar_tracker* tracker = nullptr;
  handyar_create(bytes.coin() ? given_camera.get() : nullptr,
                 bytes.coin() ? given_hand.get() : nullptr,
                 bytes.coin() ? given_options.get() : nullptr, &tracker);
  for (int calls = 0; calls < 12 && !bytes.empty(); ++calls) {
    switch (bytes.take<std::uint8_t>() % 9) {
      case 0:
        handyar_reset(tracker);
        handyar_share_view(tracker, bytes.coin() ? tracker : nullptr);
        break;
      case 1: {
        const handyar_frame frame = frame_of(bytes, pixels);
        const Passed result(bytes, handyar_result{});
        handyar_process(tracker, &frame, bytes.coin() ? calls : bytes.take<double>(), result.get());
        break;
      }
      case 2: {
        handyar_pose pose;
        handyar_predict(tracker, bytes.take<double>(), &pose);
        break;
      }
      case 3:
        handyar_get_mask(tracker, Passed(bytes, handyar_mask{}).get());
        break;
      case 4: {
        std::vector<float> xy_px(bytes.take<std::uint8_t>());
        handyar_get_outline(tracker, xy_px.data(), xy_px.size() / 2);
        break;
      }
      case 5:
        handyar_get_hand(tracker, Passed(bytes, handyar_hand{}).get());
        break;
      case 6: {
        double T_hand_object[4][4];
        handyar_get_attachment(tracker, bytes.take<std::int32_t>(), T_hand_object);
        break;
      }
      case 7: {
        const double point_camera_m[] = {bytes.take<double>(), bytes.take<double>(),
                                         bytes.take<double>()};
        double px[2];
        handyar_project(given_camera.get(), point_camera_m, px);
        break;
      }
      default:
        if (handyar_describe(bytes.take<std::int32_t>())[0] == '\0') std::abort();
        if (handyar_state_name(bytes.take<std::int32_t>())[0] == '\0') std::abort();
        handyar_camera_from_field_of_view(bytes.take<std::int32_t>(), bytes.take<std::int32_t>(),
                                          bytes.take<double>(), given_camera.get());
    }
  }
  handyar_destroy(tracker);
  return 0;
}
