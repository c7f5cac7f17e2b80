// SPDX-License-Identifier: MIT
// What tests of the interface for C pass to it.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "hand_film.hpp"
#include "handyar.h"

namespace handyar {

using test::Film;
using test::Picture;

template <class T>
T sized() {
  T s{};
  s.size = sizeof s;
  return s;
}

inline handyar_camera camera_of(int width_px, int height_px) {
  auto camera = sized<handyar_camera>();
  EXPECT_EQ(
      handyar_camera_from_field_of_view(width_px, height_px, HANDYAR_FIELD_OF_VIEW_RAD, &camera),
      HANDYAR_OK);
  return camera;
}

struct Destroy {
  void operator()(handyar_tracker* tracker) const { handyar_destroy(tracker); }
};
using TrackerPointer = std::unique_ptr<handyar_tracker, Destroy>;

inline TrackerPointer tracker_with(const handyar_hand* hand, const handyar_options* options) {
  handyar_tracker* tracker = nullptr;
  EXPECT_EQ(handyar_create(nullptr, hand, options, &tracker), HANDYAR_OK);
  return TrackerPointer(tracker);
}

inline handyar_frame frame_of(const Picture& picture) {
  auto frame = sized<handyar_frame>();
  const ImageView view = picture.view();
  frame.format = static_cast<handyar_format>(view.format);
  frame.width_px = view.width_px;
  frame.height_px = view.height_px;
  frame.data = view.data;
  frame.stride_bytes = view.stride_bytes;
  return frame;
}

inline handyar_hand average_hand() {
  auto hand = sized<handyar_hand>();
  EXPECT_EQ(handyar_average_hand(&hand), HANDYAR_OK);
  return hand;
}

/// The same film, seen by the tracker in C++ and by the one in C.
struct BothFilm {
  BothFilm() : tracker(tracker_with(nullptr, nullptr)) {
    film.tracker = HandTracker(film.camera, average_adult_hand());
  }
  void play(int frames) {
    for (int i = 0; i < frames; ++i) {
      film.next();
      status = handyar_process(
          tracker.get(),
          [&] {
            picture = film.picture();
            frame = frame_of(picture);
            return &frame;
          }(),
          film.time_s, &result);
    }
  }
  Film film;
  TrackerPointer tracker;
  Picture picture{640, 480};
  handyar_frame frame = sized<handyar_frame>();
  handyar_result result = sized<handyar_result>();
  handyar_status status = HANDYAR_OK;
};

}  // namespace handyar
