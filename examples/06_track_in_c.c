/* SPDX-License-Identifier: MIT */
/* The first example in C: tracks a hand in raw 640x480 RGB frames from standard input. */
#include <stdio.h>

#include "handyar.h"

static uint8_t rgb[480][640][3];

int main(void) {
  handyar_tracker* tracker;
  if (handyar_create(NULL, NULL, NULL, &tracker) != HANDYAR_OK) return 1;
  const handyar_frame frame = {.size = sizeof frame,
                               .format = HANDYAR_RGB,
                               .width_px = 640,
                               .height_px = 480,
                               .data = rgb[0][0],
                               .stride_bytes = sizeof rgb[0]};
  handyar_result result = {.size = sizeof result};
  for (int i = 0; fread(rgb, sizeof rgb, 1, stdin) == 1; ++i) {
    handyar_process(tracker, &frame, i / 30.0, &result);
    if (result.has_pose) printf("hand at %.3f m\n", result.pose.T_camera_hand[2][3]);
  }
  handyar_destroy(tracker);
}
