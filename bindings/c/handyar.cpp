// SPDX-License-Identifier: MIT
#include "handyar.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <new>
#include <numbers>

#include "handyar/attachment.hpp"
#include "handyar/stages/evidence.hpp"
#include "handyar/tracker.hpp"

using handyar::FrameStatus;

struct handyar_tracker {
  handyar::HandTracker tracker;
  handyar::TrackResult last = {};  // of the last frame that was not refused
};

namespace {

// The size that each struct had at first, which is the least that a program passes: a number, once
// the struct has grown.
template <class T>
constexpr std::size_t kFirstSize = sizeof(T);

template <>
constexpr std::size_t kFirstSize<handyar_result> = 1392;

template <class T>
bool sized(const T* s) {
  return s->size >= kFirstSize<T>;
}

/// What a program passed in, as far as this version knows it.
template <class T>
T taken(const T& in) {
  T known{};
  std::memcpy(&known, &in, std::min<std::size_t>(in.size, sizeof(T)));
  return known;
}

/// Hands `known` to a program whose struct may be smaller or larger.
template <class T>
void give(const T& known, T* out) {
  const std::uint32_t size = out->size;
  std::memset(static_cast<void*>(out), 0, size);
  std::memcpy(static_cast<void*>(out), &known, std::min<std::size_t>(size, sizeof(T)));
  out->size = size;
}

bool finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool is_valid(const handyar_camera& c) {
  return c.width_px > 0 && c.height_px > 0 && c.fx_px > 0 && c.fy_px > 0 &&
         finite({c.fx_px, c.fy_px, c.cx_px, c.cy_px}) &&
         finite(
             {c.distortion[0], c.distortion[1], c.distortion[2], c.distortion[3], c.distortion[4]});
}

double span_m(const handyar_hand& h) {
  return std::hypot(h.tips_m[0][0] - h.tips_m[4][0], h.tips_m[0][1] - h.tips_m[4][1],
                    h.tips_m[0][2] - h.tips_m[4][2]);
}

bool is_valid(const handyar_hand& h) {
  if (h.layout != HANDYAR_THUMB_RIGHT && h.layout != HANDYAR_THUMB_LEFT) return false;
  if (h.source < HANDYAR_FROM_CHECKERBOARD || h.source > HANDYAR_FROM_TRUTH) return false;
  if (!std::isfinite(h.thickness_m)) return false;
  for (int f = 0; f < HANDYAR_FINGERS; ++f)
    for (int axis = 0; axis < 3; ++axis)
      if (!std::isfinite(h.tips_m[f][axis]) || !std::isfinite(h.tips_sigma_m[f][axis]) ||
          h.tips_sigma_m[f][axis] < 0)
        return false;
  return span_m(h) > 0;
}

bool is_valid(const handyar_options& o) {
  return o.side >= HANDYAR_UNKNOWN && o.side <= HANDYAR_RIGHT_HAND && std::isfinite(o.smoothing) &&
         o.smoothing >= 0;
}

handyar::Camera to_cpp(const handyar_camera& c) {
  handyar::Camera camera{.width_px = c.width_px,
                         .height_px = c.height_px,
                         .fx_px = c.fx_px,
                         .fy_px = c.fy_px,
                         .cx_px = c.cx_px,
                         .cy_px = c.cy_px,
                         .assumed = c.assumed != 0};
  std::copy_n(c.distortion, camera.distortion.size(), camera.distortion.begin());
  return camera;
}

handyar_camera to_c(const handyar::Camera& camera) {
  handyar_camera c{};
  c.width_px = camera.width_px;
  c.height_px = camera.height_px;
  c.assumed = camera.assumed;
  c.fx_px = camera.fx_px;
  c.fy_px = camera.fy_px;
  c.cx_px = camera.cx_px;
  c.cy_px = camera.cy_px;
  std::copy(camera.distortion.begin(), camera.distortion.end(), c.distortion);
  return c;
}

// The enumerators without an "unknown" count from 0, their names in C from 1.
handyar_layout to_c(handyar::Layout layout) {
  return layout == handyar::Layout::thumb_right ? HANDYAR_THUMB_RIGHT : HANDYAR_THUMB_LEFT;
}
handyar_face to_c(handyar::Face face) {
  return face == handyar::Face::palm ? HANDYAR_PALM : HANDYAR_BACK;
}
handyar_side to_c(handyar::Side side) {
  return side == handyar::Side::left ? HANDYAR_LEFT_HAND : HANDYAR_RIGHT_HAND;
}

handyar_gesture_event to_c(handyar::GestureEvent event) {
  switch (event) {
    case handyar::GestureEvent::grab:
      return HANDYAR_GRAB;
    case handyar::GestureEvent::release:
      return HANDYAR_RELEASE;
    case handyar::GestureEvent::click:
      break;
  }
  return HANDYAR_CLICK;
}

static_assert(int{HANDYAR_FROM_CHECKERBOARD} == int(handyar::HandSource::checkerboard));
static_assert(int{HANDYAR_FROM_AVERAGE_ADULT} == int(handyar::HandSource::average_adult));
static_assert(int{HANDYAR_FROM_TRACKING} == int(handyar::HandSource::self));
static_assert(int{HANDYAR_FROM_TRUTH} == int(handyar::HandSource::truth));
static_assert(int{HANDYAR_SEARCHING} == int(handyar::State::searching));
static_assert(int{HANDYAR_ACQUIRING} == int(handyar::State::acquiring));
static_assert(int{HANDYAR_TRACKING} == int(handyar::State::tracking));
static_assert(int{HANDYAR_LOST} == int(handyar::State::lost));
static_assert(int{HANDYAR_OPEN} == int(handyar::Gesture::open));
static_assert(int{HANDYAR_FIST} == int(handyar::Gesture::fist));
static_assert(int{HANDYAR_FOUR} == int(handyar::Gesture::four));
static_assert(int{HANDYAR_BGR} == int(handyar::PixelFormat::bgr));
static_assert(int{HANDYAR_RGB} == int(handyar::PixelFormat::rgb));
static_assert(int{HANDYAR_BGRA} == int(handyar::PixelFormat::bgra));
static_assert(int{HANDYAR_RGBA} == int(handyar::PixelFormat::rgba));
static_assert(int{HANDYAR_YUYV} == int(handyar::PixelFormat::yuyv));
static_assert(int{HANDYAR_NV12} == int(handyar::PixelFormat::nv12));
static_assert(int{HANDYAR_GRAY} == int(handyar::PixelFormat::gray));
static_assert(int{HANDYAR_NO_DATA} == int(FrameStatus::no_data));
static_assert(int{HANDYAR_GRAY_UNSUPPORTED} == int(FrameStatus::gray_unsupported));
static_assert(int{HANDYAR_SIZE_UNSUPPORTED} == int(FrameStatus::size_unsupported));
static_assert(int{HANDYAR_STRIDE_TOO_SMALL} == int(FrameStatus::stride_too_small));
static_assert(int{HANDYAR_TIME_NOT_INCREASING} == int(FrameStatus::time_not_increasing));
static_assert(int{HANDYAR_AT_FACE} == int(handyar::Attachment::face));
static_assert(int{HANDYAR_AT_PALM} == int(handyar::Attachment::palm));
static_assert(int{HANDYAR_AT_BACK} == int(handyar::Attachment::back));
static_assert(int{HANDYAR_AT_WRIST} == int(handyar::Attachment::wrist));
static_assert(int{HANDYAR_AT_BASE} == int(handyar::Attachment::thumb_base));
static_assert(int{HANDYAR_AT_TIP} == int(handyar::Attachment::thumb_tip));
static_assert(HANDYAR_FINGERS == handyar::kFingerCount && HANDYAR_WEBS == handyar::kValleyCount);

handyar::HandModel to_cpp(const handyar_hand& h) {
  handyar::HandModel hand;
  hand.layout =
      h.layout == HANDYAR_THUMB_RIGHT ? handyar::Layout::thumb_right : handyar::Layout::thumb_left;
  hand.source = static_cast<handyar::HandSource>(h.source);
  hand.average_scale = h.average_scale != 0;
  hand.thickness_m = h.thickness_m;
  for (int f = 0; f < HANDYAR_FINGERS; ++f)
    for (int axis = 0; axis < 3; ++axis) {
      hand.tips_m(axis, f) = h.tips_m[f][axis];
      hand.tips_sigma_m(axis, f) = h.tips_sigma_m[f][axis];
    }
  return hand;
}

handyar_hand to_c(const handyar::HandModel& hand) {
  handyar_hand h{};
  h.layout = to_c(hand.layout);
  h.source = static_cast<handyar_source>(hand.source);
  h.average_scale = hand.average_scale;
  h.thickness_m = hand.thickness_m;
  for (int f = 0; f < HANDYAR_FINGERS; ++f)
    for (int axis = 0; axis < 3; ++axis) {
      h.tips_m[f][axis] = hand.tips_m(axis, f);
      h.tips_sigma_m[f][axis] = hand.tips_sigma_m(axis, f);
    }
  return h;
}

handyar::Config to_cpp(const handyar_options& o) {
  handyar::Config config;
  if (o.side == HANDYAR_LEFT_HAND) config.side = handyar::Side::left;
  if (o.side == HANDYAR_RIGHT_HAND) config.side = handyar::Side::right;
  config.smoothing = o.smoothing;
  return config;
}

handyar::ImageView to_cpp(const handyar_frame& f) {
  return {.data = f.data,
          .width_px = f.width_px,
          .height_px = f.height_px,
          .stride_bytes = f.stride_bytes,
          .format = static_cast<handyar::PixelFormat>(f.format),
          .chroma = f.chroma,
          .chroma_stride_bytes = f.chroma_stride_bytes};
}

void write(const Eigen::Isometry3d& T, double (*rows)[4]) {
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) rows[row][column] = T.matrix()(row, column);
}

template <class Pose>
handyar_pose to_c(const Pose& pose) {
  handyar_pose p{};
  write(pose.T_camera_hand, p.T_camera_hand);
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column)
      p.covariance[row][column] = pose.covariance(row, column);
  return p;
}

handyar_pose to_c(const handyar::FilteredPose& pose) {
  handyar_pose p = to_c<>(pose);
  p.time_s = pose.time_s;
  for (int axis = 0; axis < 3; ++axis) {
    p.velocity_m_s[axis] = pose.velocity_m_s[axis];
    p.angular_velocity_rad_s[axis] = pose.angular_velocity_rad_s[axis];
  }
  return p;
}

handyar_point to_c(const handyar::Tip& tip) {
  return {{tip.px.x(), tip.px.y()}, tip.seen, tip.inferred};
}

handyar_result to_c(const handyar::TrackResult& result, const handyar::HandModel& hand) {
  handyar_result r{};
  r.state = static_cast<handyar_state>(result.state);
  if (result.layout) r.layout = to_c(*result.layout);
  if (result.face) r.face = to_c(*result.face);
  if (result.layout && result.face) r.side = to_c(side_of(*result.face, *result.layout));
  r.doubtful = result.doubtful;
  r.scale_assumed = result.scale_assumed;
  r.camera_assumed = result.camera_assumed;
  r.has_pose = result.pose.has_value();
  r.has_raw_pose = result.raw_pose.has_value();
  if (result.pose) r.pose = to_c(*result.pose);
  if (result.raw_pose) {
    r.raw_pose = to_c(*result.raw_pose);
    r.raw_pose.time_s = result.time_s;
    r.rms_px = result.raw_pose->rms_px;
  }
  const Eigen::Vector3d palm_centre_m = hand.palm_centre_m();
  std::copy_n(palm_centre_m.data(), 3, r.palm_centre_m);
  for (int f = 0; f < HANDYAR_FINGERS; ++f) {
    r.tips[f] = to_c(result.tips[f]);
    const handyar::FingerState& finger = result.fingers[f];
    r.fingers[f] = {finger.abduction_rad, finger.abduction_sigma_rad, finger.flexion_rad,
                    finger.flexion_sigma_rad};
  }
  for (int w = 0; w < HANDYAR_WEBS; ++w) r.webs[w] = to_c(result.webs[w]);
  r.gesture = static_cast<handyar_gesture>(result.gesture);
  if (result.gesture_event) r.gesture_event = to_c(*result.gesture_event);
  r.has_held_pose = result.held_pose.has_value();
  if (result.held_pose) r.held_pose = to_c(*result.held_pose);
  return r;
}

handyar_tracker* make_tracker(const handyar::Camera& camera, const handyar::HandModel& hand,
                              const handyar::Config& config) noexcept {
#ifdef __cpp_exceptions
  try {
    return new handyar_tracker{handyar::HandTracker(camera, hand, config)};
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
#else
  return new handyar_tracker{handyar::HandTracker(camera, hand, config)};
#endif
}

}  // namespace

extern "C" {

const char* handyar_version(void) { return HANDYAR_VERSION; }

const char* handyar_describe(handyar_status status) {
  switch (status) {
    case HANDYAR_BAD_ARGUMENT:
      return "a null pointer, or a value that means nothing";
    case HANDYAR_BAD_SIZE:
      return "a struct's `size` is not set to its sizeof";
    case HANDYAR_NO_MEMORY:
      return "no memory";
    case HANDYAR_NO_HAND:
      return "no hand is tracked";
    default:
      return status >= HANDYAR_OK && status <= HANDYAR_TIME_NOT_INCREASING
                 ? handyar::describe(static_cast<FrameStatus>(status))
                 : "unknown";
  }
}

const char* handyar_state_name(handyar_state state) {
  return state >= HANDYAR_SEARCHING && state <= HANDYAR_LOST
             ? handyar::name(static_cast<handyar::State>(state)).data()
             : "unknown";
}

handyar_status handyar_camera_from_field_of_view(int32_t width_px, int32_t height_px,
                                                 double fov_rad, handyar_camera* camera) {
  if (camera == nullptr || width_px <= 0 || height_px <= 0 || !(fov_rad > 0) ||
      !(fov_rad < std::numbers::pi))
    return HANDYAR_BAD_ARGUMENT;
  if (!sized(camera)) return HANDYAR_BAD_SIZE;
  const handyar_camera made =
      to_c(handyar::Camera::from_field_of_view(width_px, height_px, fov_rad));
  if (!is_valid(made)) return HANDYAR_BAD_ARGUMENT;  // so narrow that its focal length is infinite
  give(made, camera);
  return HANDYAR_OK;
}

handyar_status handyar_project(const handyar_camera* camera, const double point_camera_m[3],
                               double px[2]) {
  if (camera == nullptr || point_camera_m == nullptr || px == nullptr) return HANDYAR_BAD_ARGUMENT;
  if (!sized(camera)) return HANDYAR_BAD_SIZE;
  const handyar_camera known = taken(*camera);
  const Eigen::Vector3d point_m(point_camera_m[0], point_camera_m[1], point_camera_m[2]);
  if (!is_valid(known) || !point_m.allFinite() || !(point_m.z() > 0)) return HANDYAR_BAD_ARGUMENT;
  const Eigen::Vector2d at = to_cpp(known).project(point_m);
  if (!at.allFinite()) return HANDYAR_BAD_ARGUMENT;  // as good as beside the camera
  px[0] = at.x();
  px[1] = at.y();
  return HANDYAR_OK;
}

handyar_status handyar_average_hand(handyar_hand* hand) {
  if (hand == nullptr) return HANDYAR_BAD_ARGUMENT;
  if (!sized(hand)) return HANDYAR_BAD_SIZE;
  give(to_c(handyar::average_adult_hand()), hand);
  return HANDYAR_OK;
}

handyar_status handyar_default_options(handyar_options* options) {
  if (options == nullptr) return HANDYAR_BAD_ARGUMENT;
  if (!sized(options)) return HANDYAR_BAD_SIZE;
  handyar_options usual{};
  usual.smoothing = 1;
  give(usual, options);
  return HANDYAR_OK;
}

handyar_status handyar_create(const handyar_camera* camera, const handyar_hand* hand,
                              const handyar_options* options, handyar_tracker** tracker) {
  if (tracker == nullptr) return HANDYAR_BAD_ARGUMENT;
  *tracker = nullptr;
  if ((camera != nullptr && !sized(camera)) || (hand != nullptr && !sized(hand)) ||
      (options != nullptr && !sized(options)))
    return HANDYAR_BAD_SIZE;
  if ((camera != nullptr && !is_valid(taken(*camera))) ||
      (hand != nullptr && !is_valid(taken(*hand))) ||
      (options != nullptr && !is_valid(taken(*options))))
    return HANDYAR_BAD_ARGUMENT;
  *tracker = make_tracker(
      camera != nullptr ? to_cpp(taken(*camera)) : handyar::Camera::from_field_of_view(640, 480),
      hand != nullptr ? to_cpp(taken(*hand)) : handyar::average_adult_hand(),
      options != nullptr ? to_cpp(taken(*options)) : handyar::Config{});
  return *tracker != nullptr ? HANDYAR_OK : HANDYAR_NO_MEMORY;
}

void handyar_destroy(handyar_tracker* tracker) { delete tracker; }

void handyar_reset(handyar_tracker* tracker) {
  if (tracker == nullptr) return;
  tracker->tracker.reset();
  tracker->last = {};
}

void handyar_share_view(handyar_tracker* first, handyar_tracker* second) {
  if (first != nullptr && second != nullptr) share_view(first->tracker, second->tracker);
}

handyar_status handyar_process(handyar_tracker* tracker, const handyar_frame* frame, double time_s,
                               handyar_result* result) {
  if (tracker == nullptr || frame == nullptr || result == nullptr) return HANDYAR_BAD_ARGUMENT;
  if (!sized(frame) || !sized(result)) return HANDYAR_BAD_SIZE;
  const handyar_frame known = taken(*frame);
  if (known.format < HANDYAR_BGR || known.format > HANDYAR_GRAY) {
    give(handyar_result{}, result);
    return HANDYAR_BAD_ARGUMENT;
  }
  const handyar::TrackResult tracked = tracker->tracker.process(to_cpp(known), time_s);
  if (tracked.status == FrameStatus::ok) tracker->last = tracked;
  give(to_c(tracked, tracker->tracker.hand()), result);
  return static_cast<handyar_status>(tracked.status);
}

handyar_status handyar_predict(const handyar_tracker* tracker, double time_s, handyar_pose* pose) {
  if (tracker == nullptr || pose == nullptr || !std::isfinite(time_s)) return HANDYAR_BAD_ARGUMENT;
  const auto predicted = tracker->tracker.predict(time_s);
  if (!predicted) return HANDYAR_NO_HAND;
  *pose = to_c(*predicted);
  return HANDYAR_OK;
}

handyar_status handyar_get_mask(handyar_tracker* tracker, handyar_mask* mask) {
  if (tracker == nullptr || mask == nullptr) return HANDYAR_BAD_ARGUMENT;
  if (!sized(mask)) return HANDYAR_BAD_SIZE;
  const handyar::HandMask drawn = tracker->tracker.mask();
  if (drawn.data == nullptr || drawn.width == 0) return HANDYAR_NO_HAND;
  handyar_mask m{};
  m.width = drawn.width;
  m.height = drawn.height;
  m.x0_px = drawn.x0_px;
  m.y0_px = drawn.y0_px;
  m.step_px = drawn.step_px;
  m.data = drawn.data;
  m.stride_bytes = drawn.stride_bytes;
  give(m, mask);
  return HANDYAR_OK;
}

size_t handyar_get_outline(const handyar_tracker* tracker, float* xy_px, size_t capacity) {
  if (tracker == nullptr) return 0;
  const auto outline = tracker->tracker.evidence().outline;
  if (xy_px == nullptr) return outline.size();
  for (std::size_t i = 0; i < std::min(capacity, outline.size()); ++i) {
    xy_px[2 * i] = outline[i].px.x();
    xy_px[2 * i + 1] = outline[i].px.y();
  }
  return outline.size();
}

handyar_status handyar_get_hand(const handyar_tracker* tracker, handyar_hand* hand) {
  if (tracker == nullptr || hand == nullptr) return HANDYAR_BAD_ARGUMENT;
  if (!sized(hand)) return HANDYAR_BAD_SIZE;
  give(to_c(tracker->tracker.hand()), hand);
  return HANDYAR_OK;
}

handyar_status handyar_get_attachment(const handyar_tracker* tracker, handyar_attachment where,
                                      double T_hand_object[4][4]) {
  if (tracker == nullptr || T_hand_object == nullptr || where < HANDYAR_AT_FACE ||
      where >= handyar::kAttachmentCount)
    return HANDYAR_BAD_ARGUMENT;
  if (!tracker->last.pose && !tracker->last.held_pose) return HANDYAR_NO_HAND;
  write(T_hand_attachment(static_cast<handyar::Attachment>(where), tracker->tracker.hand(),
                          tracker->last),
        T_hand_object);
  return HANDYAR_OK;
}

}  // extern "C"
