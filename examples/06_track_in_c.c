/* SPDX-License-Identifier: MIT */
/* The first example in C: tracks a hand in raw 640x480 RGB frames from standard input. */
#include <stdio.h>

#include "handyar.h"

static uint8_t rgb[480][640][3];

int main(void) {
  handyar_camera camera = {.size = sizeof camera}; /* or a calibrated one */
  handyar_camera_from_field_of_view(640, 480, HANDYAR_FIELD_OF_VIEW_RAD, &camera);
  handyar_tracker* tracker;
  const handyar_status status = handyar_create(&camera, NULL, NULL, &tracker);
  if (status != HANDYAR_OK) return fprintf(stderr, "%s\n", handyar_describe(status)), 1;

  const handyar_frame frame = {.size = sizeof frame,
                               .format = HANDYAR_RGB,
                               .width_px = 640,
                               .height_px = 480,
                               .data = rgb[0][0],
                               .stride_bytes = sizeof rgb[0]};
  handyar_result result = {.size = sizeof result};
  for (int i = 0; fread(rgb, sizeof rgb, 1, stdin) == 1; ++i) {
    handyar_process(tracker, &frame, i / 30.0, &result);
    if (!result.has_pose) continue;
    double(*T)[4] = result.pose.T_camera_hand;
    printf("%.2f s  hand at %.3f %.3f %.3f m\n", i / 30.0, T[0][3], T[1][3], T[2][3]);
  }
  handyar_destroy(tracker);
  return 0;
}
