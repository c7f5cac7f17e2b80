/* SPDX-License-Identifier: MIT */
/* The binary interface that programs in other languages are built against, as numbers: C99, against
 * the shared library. What fails here breaks them, and needs another major version. */
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "handyar.h"

static int failures = 0;

static void expect(const char* what, size_t is, size_t should_be) {
  if (is == should_be) return;
  fprintf(stderr, "%s is %lu, was %lu\n", what, (unsigned long)is, (unsigned long)should_be);
  ++failures;
}

#define EXPECT_SIZE(type, bytes) expect("size of " #type, sizeof(type), bytes)
#define EXPECT_OFFSET(type, field, bytes) \
  expect("offset of " #type "." #field, offsetof(type, field), bytes)

int main(void) {
  const size_t pointer = sizeof(void*); /* the structs that hold none are the same everywhere */

  EXPECT_SIZE(handyar_camera, 88);
  EXPECT_OFFSET(handyar_camera, width_px, 4);
  EXPECT_OFFSET(handyar_camera, height_px, 8);
  EXPECT_OFFSET(handyar_camera, assumed, 12);
  EXPECT_OFFSET(handyar_camera, fx_px, 16);
  EXPECT_OFFSET(handyar_camera, fy_px, 24);
  EXPECT_OFFSET(handyar_camera, cx_px, 32);
  EXPECT_OFFSET(handyar_camera, cy_px, 40);
  EXPECT_OFFSET(handyar_camera, distortion, 48);

  EXPECT_SIZE(handyar_hand, 264);
  EXPECT_OFFSET(handyar_hand, layout, 4);
  EXPECT_OFFSET(handyar_hand, source, 8);
  EXPECT_OFFSET(handyar_hand, average_scale, 12);
  EXPECT_OFFSET(handyar_hand, tips_m, 16);
  EXPECT_OFFSET(handyar_hand, tips_sigma_m, 136);
  EXPECT_OFFSET(handyar_hand, thickness_m, 256);

  EXPECT_SIZE(handyar_options, 16);
  EXPECT_OFFSET(handyar_options, side, 4);
  EXPECT_OFFSET(handyar_options, smoothing, 8);

  EXPECT_SIZE(handyar_frame, 16 + 4 * pointer);
  EXPECT_OFFSET(handyar_frame, format, 4);
  EXPECT_OFFSET(handyar_frame, width_px, 8);
  EXPECT_OFFSET(handyar_frame, height_px, 12);
  EXPECT_OFFSET(handyar_frame, data, 16);
  EXPECT_OFFSET(handyar_frame, stride_bytes, 16 + pointer);
  EXPECT_OFFSET(handyar_frame, chroma, 16 + 2 * pointer);
  EXPECT_OFFSET(handyar_frame, chroma_stride_bytes, 16 + 3 * pointer);

  EXPECT_SIZE(handyar_pose, 472);
  EXPECT_OFFSET(handyar_pose, time_s, 0);
  EXPECT_OFFSET(handyar_pose, T_camera_hand, 8);
  EXPECT_OFFSET(handyar_pose, covariance, 136);
  EXPECT_OFFSET(handyar_pose, velocity_m_s, 424);
  EXPECT_OFFSET(handyar_pose, angular_velocity_rad_s, 448);

  EXPECT_SIZE(handyar_point, 24);
  EXPECT_OFFSET(handyar_point, px, 0);
  EXPECT_OFFSET(handyar_point, seen, 16);
  EXPECT_OFFSET(handyar_point, inferred, 20);

  EXPECT_SIZE(handyar_finger, 32);
  EXPECT_OFFSET(handyar_finger, abduction_rad, 0);
  EXPECT_OFFSET(handyar_finger, abduction_sigma_rad, 8);
  EXPECT_OFFSET(handyar_finger, flexion_rad, 16);
  EXPECT_OFFSET(handyar_finger, flexion_sigma_rad, 24);

  EXPECT_SIZE(handyar_result, 1880); /* at first 1392 */
  EXPECT_OFFSET(handyar_result, state, 4);
  EXPECT_OFFSET(handyar_result, layout, 8);
  EXPECT_OFFSET(handyar_result, face, 12);
  EXPECT_OFFSET(handyar_result, side, 16);
  EXPECT_OFFSET(handyar_result, doubtful, 20);
  EXPECT_OFFSET(handyar_result, scale_assumed, 24);
  EXPECT_OFFSET(handyar_result, camera_assumed, 28);
  EXPECT_OFFSET(handyar_result, has_pose, 32);
  EXPECT_OFFSET(handyar_result, has_raw_pose, 36);
  EXPECT_OFFSET(handyar_result, pose, 40);
  EXPECT_OFFSET(handyar_result, raw_pose, 512);
  EXPECT_OFFSET(handyar_result, rms_px, 984);
  EXPECT_OFFSET(handyar_result, palm_centre_m, 992);
  EXPECT_OFFSET(handyar_result, tips, 1016);
  EXPECT_OFFSET(handyar_result, webs, 1136);
  EXPECT_OFFSET(handyar_result, fingers, 1232);
  EXPECT_OFFSET(handyar_result, gesture, 1392);
  EXPECT_OFFSET(handyar_result, gesture_event, 1396);
  EXPECT_OFFSET(handyar_result, has_held_pose, 1400);
  EXPECT_OFFSET(handyar_result, held_pose, 1408);

  EXPECT_SIZE(handyar_mask, 24 + 2 * pointer);
  EXPECT_OFFSET(handyar_mask, width, 4);
  EXPECT_OFFSET(handyar_mask, height, 8);
  EXPECT_OFFSET(handyar_mask, x0_px, 12);
  EXPECT_OFFSET(handyar_mask, y0_px, 16);
  EXPECT_OFFSET(handyar_mask, step_px, 20);
  EXPECT_OFFSET(handyar_mask, data, 24);
  EXPECT_OFFSET(handyar_mask, stride_bytes, 24 + pointer);

  if (strcmp(handyar_version(), HANDYAR_VERSION) != 0) {
    fprintf(stderr, "the header is of %s, the library of %s\n", HANDYAR_VERSION, handyar_version());
    ++failures;
  }
  return failures == 0 ? 0 : 1;
}
