/* SPDX-License-Identifier: MIT */
/* handyar for C and for whatever calls C: a bare outstretched hand, used like a printed AR marker.
 *
 *     handyar_tracker* tracker;
 *     if (handyar_create(NULL, NULL, NULL, &tracker) != HANDYAR_OK) return 1;
 *     handyar_result result = {.size = sizeof result};
 *     while (next_frame(&frame, &time_s)) {
 *       handyar_process(tracker, &frame, time_s, &result);
 *       if (result.has_pose) draw(result.pose.T_camera_hand);
 *     }
 *     handyar_destroy(tracker);
 *
 * Ownership. The caller owns every struct and every picture; nothing of them is kept beyond the
 * call that they are passed to. A tracker belongs to the caller from handyar_create() until
 * handyar_destroy(). Text that is returned is constant and never freed. What a handyar_mask points
 * to belongs to its tracker and is valid until the next call with that tracker.
 *
 * Threads. A tracker is used by one thread at a time, whichever; different trackers by different
 * threads at once. Functions without a tracker may be called from anywhere.
 *
 * Errors. Functions return a handyar_status; on anything but HANDYAR_OK they have written nothing,
 * except where it is said. No exception leaves them. handyar_create() and the first frame of a new
 * size take memory; after that a frame takes none.
 *
 * Versions. A struct whose first field is `size` grows at its end in later versions: set `size` to
 * its sizeof before passing it, in and out. The library reads and writes no more than that; what a
 * newer program's struct has beyond the library's is set to zero. Structs without `size`, and
 * numbers given to names below, never change while the major version stays.
 *
 * Frames and units are those of docs/conventions.md: metres, radians, seconds, pixels whose (0, 0)
 * is the centre of the top-left one; camera frame x right, y down, z forward. T_a_b takes points of
 * frame b to frame a. Matrices are stored row after row. Files are not read here: the structs are
 * plain, so that any program can keep them in its own way. */
#ifndef HANDYAR_H
#define HANDYAR_H

#include <stddef.h>
#include <stdint.h>

#include "handyar/api.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HANDYAR_FINGERS = 5 }; /* thumb, index, middle, ring, little: always in this order */
enum { HANDYAR_WEBS = 4 };    /* web i lies between finger i and finger i + 1 */

/* The field of view that is assumed of a camera that was not calibrated: 60 degrees. */
#define HANDYAR_FIELD_OF_VIEW_RAD 1.0471975511965976

typedef int32_t handyar_status;
enum {
  HANDYAR_OK = 0,
  HANDYAR_NO_DATA = 1,             /* the frame's `data` (nv12: or `chroma`) is null */
  HANDYAR_GRAY_UNSUPPORTED = 2,    /* one channel: a hand is told by its colour */
  HANDYAR_SIZE_UNSUPPORTED = 3,    /* not 160x120 to 4096x2160, or odd for yuyv, nv12 */
  HANDYAR_STRIDE_TOO_SMALL = 4,    /* rows would overlap */
  HANDYAR_TIME_NOT_INCREASING = 5, /* or not finite */
  HANDYAR_BAD_ARGUMENT = 6,        /* a null pointer, or a value that means nothing */
  HANDYAR_BAD_SIZE = 7,            /* a struct's `size` was not set */
  HANDYAR_NO_MEMORY = 8,
  HANDYAR_NO_HAND = 9 /* there is nothing to answer with now */
};

typedef int32_t handyar_format;
enum {
  HANDYAR_BGR = 0,
  HANDYAR_RGB = 1,
  HANDYAR_BGRA = 2,
  HANDYAR_RGBA = 3,
  HANDYAR_YUYV = 4,
  HANDYAR_NV12 = 5,
  HANDYAR_GRAY = 6 /* so that it can be named, and refused */
};

typedef int32_t handyar_state;
enum {
  HANDYAR_SEARCHING = 0, /* no hand */
  HANDYAR_ACQUIRING = 1, /* fingertips seen, not yet confirmed */
  HANDYAR_TRACKING = 2,
  HANDYAR_LOST = 3 /* was tracking, trying to recover */
};

/* On which side the thumb is when the visible face is looked at with the fingers up. */
typedef int32_t handyar_layout;
enum { HANDYAR_THUMB_RIGHT = 1, HANDYAR_THUMB_LEFT = 2 };

typedef int32_t handyar_face;
enum { HANDYAR_PALM = 1, HANDYAR_BACK = 2 };

typedef int32_t handyar_side;
enum { HANDYAR_LEFT_HAND = 1, HANDYAR_RIGHT_HAND = 2 };

/* What the fingers do. */
typedef int32_t handyar_gesture;
enum {
  HANDYAR_OPEN = 0, /* outstretched, or not known to do anything else */
  HANDYAR_FIST = 1, /* all closed */
  HANDYAR_FOUR = 2  /* the thumb folded into the palm, the others outstretched */
};

/* What the hand has just done. */
typedef int32_t handyar_gesture_event;
enum {
  HANDYAR_NO_EVENT = 0,
  HANDYAR_GRAB = 1,    /* an open hand has closed */
  HANDYAR_RELEASE = 2, /* the closed hand has opened, or is no longer seen */
  HANDYAR_CLICK = 3    /* the thumb has been folded in */
};

/* Of a layout, face or side: it is not known. */
enum { HANDYAR_UNKNOWN = 0 };

/* Where a hand's figures come from. */
typedef int32_t handyar_source;
enum {
  HANDYAR_FROM_CHECKERBOARD = 0,
  HANDYAR_FROM_AVERAGE_ADULT = 1, /* nobody's: the scale is assumed */
  HANDYAR_FROM_TRACKING = 2,
  HANDYAR_FROM_TRUTH = 3 /* of a rendered hand */
};

/* A pinhole camera with OpenCV's distortion, all rows read at once: a camera file's readout_s has
 * no place here. */
typedef struct handyar_camera {
  uint32_t size;
  int32_t width_px, height_px;
  int32_t assumed; /* not calibrated: a field of view was taken for granted */
  double fx_px, fy_px, cx_px, cy_px;
  double distortion[5]; /* k1, k2, p1, p2, k3 */
} handyar_camera;

/* A person's hand: fingertips in the hand frame (origin: x of the middle fingertip, y of the thumb
 * tip, mean height of the tips; +y along the middle finger, +z out of the visible face). A
 * hand file's figure has no place here; it is learned anew. */
typedef struct handyar_hand {
  uint32_t size;
  handyar_layout layout; /* in which the fingertips are given */
  handyar_source source;
  int32_t average_scale; /* the shape was measured, the size is the average adult's */
  double tips_m[HANDYAR_FINGERS][3];
  double tips_sigma_m[HANDYAR_FINGERS][3]; /* standard deviations; 0: unknown */
  double thickness_m; /* height of a fingertip's visible face above what it lies on */
} handyar_hand;

/* What a person would turn; handyar_default_options() gives the usual. */
typedef struct handyar_options {
  uint32_t size;
  handyar_side side; /* the hand that will be shown, where it is known: tells palm from back */
  double smoothing;  /* 1: as designed; more: smoother and later; 0: poses are not filtered */
} handyar_options;

/* A picture, stored anywhere with any stride. */
typedef struct handyar_frame {
  uint32_t size;
  handyar_format format;
  int32_t width_px, height_px;
  const uint8_t* data;    /* first byte of the top row (of the luma plane for nv12) */
  ptrdiff_t stride_bytes; /* from one row to the next; negative: stored bottom-up */
  const uint8_t* chroma;  /* nv12 only: first byte of the interleaved UV plane */
  ptrdiff_t chroma_stride_bytes;
} handyar_frame;

typedef struct handyar_pose {
  double time_s;
  double T_camera_hand[4][4];
  /* Of rotation (rad), then translation (m), in camera axes: R_true = exp([w]x) R, t_true = t + d.
   */
  double covariance[6][6];
  double velocity_m_s[3];
  double angular_velocity_rad_s[3]; /* in camera axes */
} handyar_pose;

/* A fingertip or web in the frame. Neither seen nor inferred: `px` means nothing. */
typedef struct handyar_point {
  double px[2];
  int32_t seen;
  int32_t inferred; /* outside the frame: `px` is where the rest of the hand puts it */
} handyar_point;

/* How a finger stands against the person's rest posture; standard deviations beside. */
typedef struct handyar_finger {
  double abduction_rad, abduction_sigma_rad; /* in the palm plane, towards the thumb */
  double flexion_rad, flexion_sigma_rad;     /* towards the palm */
} handyar_finger;

/* Everything known of the hand in one frame. */
typedef struct handyar_result {
  uint32_t size;
  handyar_state state;
  handyar_layout layout; /* while a hand is followed, open or folded */
  handyar_face face;
  handyar_side side;       /* left or right hand, as face and layout tell */
  int32_t doubtful;        /* tracking, but the pose is not to be relied on */
  int32_t scale_assumed;   /* the hand was not measured: lengths are an average adult's */
  int32_t camera_assumed;  /* the camera was not calibrated */
  int32_t has_pose;        /* 0: `pose` means nothing */
  int32_t has_raw_pose;    /* 0: `raw_pose` means nothing */
  handyar_pose pose;       /* filtered, at this frame's time */
  handyar_pose raw_pose;   /* of this frame alone, before the filter; without velocities */
  double rms_px;           /* between hand and picture in `raw_pose` */
  double palm_centre_m[3]; /* in the hand frame: where an object stands */
  handyar_point tips[HANDYAR_FINGERS];
  handyar_point webs[HANDYAR_WEBS];
  handyar_finger fingers[HANDYAR_FINGERS]; /* while an open hand is followed */
  /* What follows came later: programs built before it have a smaller `size`. */
  handyar_gesture gesture;             /* held for a tenth of a second at least */
  handyar_gesture_event gesture_event; /* that this frame completed */
  int32_t has_held_pose;               /* 0: `held_pose` means nothing */
  /* While fingers are folded there is no `pose`; this is where the palm is, so that an object stays
   * on it. Less sure than a pose; there is none of a hand that was not seen open before. */
  handyar_pose held_pose;
} handyar_result;

/* The hand in the last frame as a binary picture, 255 hand, 0 not. Its pixel (u, v) covers the
 * frame's from (x0_px + u * step_px, y0_px + v * step_px), step_px each way. */
typedef struct handyar_mask {
  uint32_t size;
  int32_t width, height;
  int32_t x0_px, y0_px, step_px;
  const uint8_t* data;
  ptrdiff_t stride_bytes;
} handyar_mask;

/* The library's version, as HANDYAR_VERSION is the header's. */
HANDYAR_API const char* handyar_version(void);

/* One line for a person, e.g. "grey image: handyar needs colour". Never null. */
HANDYAR_API const char* handyar_describe(handyar_status status);

/* "searching", "acquiring", "tracking", "lost"; "unknown" for any other number. */
HANDYAR_API const char* handyar_state_name(handyar_state state);

/* A camera without distortion that sees `fov_rad` (0 to pi) across the longer side. */
HANDYAR_API handyar_status handyar_camera_from_field_of_view(int32_t width_px, int32_t height_px,
                                                             double fov_rad,
                                                             handyar_camera* camera);

/* The pixel of a point in the camera frame, which lies before the camera (z > 0). Of what is no
 * finite number, in the camera or in the point, there is none: HANDYAR_BAD_ARGUMENT. */
HANDYAR_API handyar_status handyar_project(const handyar_camera* camera,
                                           const double point_camera_m[3], double px[2]);

HANDYAR_API handyar_status handyar_average_hand(handyar_hand* hand);
HANDYAR_API handyar_status handyar_default_options(handyar_options* options);

/* Places of the hand on which an object can stand: docs/conventions.md. */
typedef int32_t handyar_attachment;
enum {
  HANDYAR_AT_FACE = 0, /* the middle of the visible face, be it palm or back */
  HANDYAR_AT_PALM = 1, /* behind the hand when its back is seen */
  HANDYAR_AT_BACK = 2, /* behind the hand when its palm is seen */
  HANDYAR_AT_WRIST = 3,
  HANDYAR_AT_BASE = 4, /* + finger: where the finger leaves the palm */
  HANDYAR_AT_TIP = 9   /* + finger */
};

typedef struct handyar_tracker handyar_tracker;

/* `camera` null: a field of view of 60 degrees is assumed. `hand` null: the average adult's, and
 * the scale is assumed. `options` null: the usual. The camera is rescaled when frames of another
 * size arrive. Anything but HANDYAR_OK sets *tracker to null. */
HANDYAR_API handyar_status handyar_create(const handyar_camera* camera, const handyar_hand* hand,
                                          const handyar_options* options,
                                          handyar_tracker** tracker);

/* Null is allowed, and nothing happens. */
HANDYAR_API void handyar_destroy(handyar_tracker* tracker);

/* Forgets hand and colours, as newly made. */
HANDYAR_API void handyar_reset(handyar_tracker* tracker);

/* Two trackers of one camera for two hands: from now on each leaves the hand that the other follows
 * alone, so that they do not change hands when these pass each other. Every frame is for both,
 * `first` first, in one thread. It ends when one of them is destroyed. */
HANDYAR_API void handyar_share_view(handyar_tracker* first, handyar_tracker* second);

/* Times must increase from frame to frame. A frame without a hand is HANDYAR_OK and gives a state,
 * never an old pose. A frame that is refused changes nothing in the tracker, and its result has no
 * pose. */
HANDYAR_API handyar_status handyar_process(handyar_tracker* tracker, const handyar_frame* frame,
                                           double time_s, handyar_result* result);

/* The pose expected at a later time: when what is drawn will be seen. HANDYAR_NO_HAND when not
 * tracking, or too long after the last frame. */
HANDYAR_API handyar_status handyar_predict(const handyar_tracker* tracker, double time_s,
                                           handyar_pose* pose);

/* The hand's silhouette in the last frame; HANDYAR_NO_HAND without one. */
HANDYAR_API handyar_status handyar_get_mask(handyar_tracker* tracker, handyar_mask* mask);

/* Places on the hand's outline in the last frame, in no order, as x, y in pixels: at most
 * `capacity` of them. Returns how many there are; `xy_px` may be null when capacity is 0. */
HANDYAR_API size_t handyar_get_outline(const handyar_tracker* tracker, float* xy_px,
                                       size_t capacity);

/* The person's hand as far as it was learned, in the layout last tracked. */
HANDYAR_API handyar_status handyar_get_hand(const handyar_tracker* tracker, handyar_hand* hand);

/* The frame of an object that stands there, in the hand frame of the last frame's pose or held pose:
 * +z up, away from the hand, for a fingertip along the finger; +x, which models look along, towards
 * the wrist, for a fingertip out of the visible face. HANDYAR_NO_HAND when the last frame has
 * neither. */
HANDYAR_API handyar_status handyar_get_attachment(const handyar_tracker* tracker,
                                                  handyar_attachment where,
                                                  double T_hand_object[4][4]);

#ifdef __cplusplus
}
#endif

#endif
