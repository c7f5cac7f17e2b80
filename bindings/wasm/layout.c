/* SPDX-License-Identifier: MIT */
/* Writes where the fields of handyar.h's structs lie in WebAssembly's memory, as the JavaScript
 * module that src/memory.js reads them by:   layout > layout.js */
#include <stddef.h>
#include <stdio.h>

#include "handyar.h"

#define BEGIN(type) printf("export const %s = {\n  bytes: %zu,\n", #type, sizeof(handyar_##type))
#define FIELD(type, field) printf("  %s: %zu,\n", #field, offsetof(handyar_##type, field))
#define END() puts("};")

int main(void) {
  puts("// Written by bindings/wasm/layout.c: bytes of each struct of handyar.h, offsets of its fields.");

  BEGIN(camera);
  FIELD(camera, size);
  FIELD(camera, width_px);
  FIELD(camera, height_px);
  FIELD(camera, assumed);
  FIELD(camera, fx_px);
  FIELD(camera, fy_px);
  FIELD(camera, cx_px);
  FIELD(camera, cy_px);
  FIELD(camera, distortion);
  END();

  BEGIN(hand);
  FIELD(hand, size);
  FIELD(hand, layout);
  FIELD(hand, source);
  FIELD(hand, average_scale);
  FIELD(hand, tips_m);
  FIELD(hand, tips_sigma_m);
  FIELD(hand, thickness_m);
  END();

  BEGIN(frame);
  FIELD(frame, size);
  FIELD(frame, format);
  FIELD(frame, width_px);
  FIELD(frame, height_px);
  FIELD(frame, data);
  FIELD(frame, stride_bytes);
  END();

  BEGIN(pose);
  FIELD(pose, time_s);
  FIELD(pose, T_camera_hand);
  FIELD(pose, covariance);
  FIELD(pose, velocity_m_s);
  FIELD(pose, angular_velocity_rad_s);
  END();

  BEGIN(point);
  FIELD(point, px);
  FIELD(point, seen);
  FIELD(point, inferred);
  END();

  BEGIN(result);
  FIELD(result, size);
  FIELD(result, state);
  FIELD(result, layout);
  FIELD(result, face);
  FIELD(result, side);
  FIELD(result, doubtful);
  FIELD(result, scale_assumed);
  FIELD(result, camera_assumed);
  FIELD(result, has_pose);
  FIELD(result, pose);
  FIELD(result, rms_px);
  FIELD(result, palm_centre_m);
  FIELD(result, tips);
  FIELD(result, gesture);
  FIELD(result, gesture_event);
  FIELD(result, has_held_pose);
  FIELD(result, held_pose);
  END();

  BEGIN(mask);
  FIELD(mask, size);
  FIELD(mask, width);
  FIELD(mask, height);
  FIELD(mask, data);
  FIELD(mask, stride_bytes);
  END();
  return 0;
}
