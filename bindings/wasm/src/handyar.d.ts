// SPDX-License-Identifier: MIT
// A bare outstretched hand, used like a printed AR marker. Metres, radians, seconds; pixels whose
// (0, 0) is the centre of the top-left one. The camera's frame: x right, y down, z forward; WebGL's:
// x right, y up, z backward. `T_a_b` takes points of frame b to frame a. Matrices are column-major.
// The hand's frame: origin at the x of the middle fingertip and the y of the thumb tip, +y along the
// middle finger, +z out of the visible face.

export type FingerName = 'thumb' | 'index' | 'middle' | 'ring' | 'little';
/** The order of `Result.tips`. */
export const FINGERS: readonly FingerName[];

/**
 * Where an object can stand. `face`: the middle of the visible face; `palm` and `back`: of that face,
 * behind the hand when the other one is seen; bases: where the fingers leave the palm.
 */
export type Place = 'face' | 'palm' | 'back' | 'wrist' | `${FingerName}_base` | `${FingerName}_tip`;
export const PLACES: readonly Place[];

/** `searching`: no hand. `acquiring`: fingertips, not yet confirmed. `lost`: was tracking, trying to recover. */
export type State = 'searching' | 'acquiring' | 'tracking' | 'lost';
/** On which side the thumb is when the visible face is looked at with the fingers up. */
export type Layout = 'thumb_right' | 'thumb_left';

/** `open`: outstretched, or not known to do anything else. `four`: the thumb folded into the palm. */
export type Gesture = 'open' | 'fist' | 'four';
/** `grab`: an open hand has closed. `release`: it has opened, or is no longer seen. `click`: the thumb has been folded in. */
export type GestureEvent = 'grab' | 'release' | 'click';

/** A pinhole camera with OpenCV's distortion. */
export interface Camera {
  width_px: number;
  height_px: number;
  fx_px: number;
  fy_px: number;
  cx_px: number;
  cy_px: number;
  /** k1, k2, p1, p2, k3 */
  distortion: number[];
  /** Not calibrated: a field of view was taken for granted, for pictures of any shape. */
  assumed: boolean;
}

/** A person's hand, as a hand file (docs/formats.md of the project) holds it. */
export interface Hand {
  format: 'handyar-hand';
  version: number;
  tips_m: Record<FingerName, number[]>;
  /** Standard deviations; 0: unknown. */
  tips_sigma_m?: Record<FingerName, number[]>;
  layout: Layout;
  source: 'checkerboard' | 'default' | 'self' | 'truth';
  /** `average`: the shape was measured, the size is the average adult's. */
  scale?: 'measured' | 'average';
  rms_px?: number;
  thickness_m?: number;
}

export interface Pose {
  time_s: number;
  /** For WebGL and three.js: `object.matrix.fromArray(pose.T_gl_hand)`. 16 numbers. */
  T_gl_hand: Float64Array;
  T_camera_hand: Float64Array;
  /** 6x6 of rotation (rad), then translation (m), in camera axes: R_true = exp([w]x) R, t_true = t + d. */
  covariance: Float64Array;
  /** Root mean square standard deviations over the three axes. */
  sigma_rotation_rad: number;
  sigma_translation_m: number;
  velocity_m_s: number[];
  /** In camera axes. */
  angular_velocity_rad_s: number[];
}

/** Neither seen nor inferred: the pixel means nothing. */
export interface Tip {
  x_px: number;
  y_px: number;
  seen: boolean;
  /** Outside the picture: this is where the rest of the hand puts it. */
  inferred: boolean;
}

/** What is known of the hand in one picture; plain data, which may be sent between threads. */
export interface Result {
  time_s: number;
  state: State;
  /** Tracking, but the pose is not to be relied on. */
  doubtful: boolean;
  layout: Layout | null;
  face: 'palm' | 'back' | null;
  side: 'left' | 'right' | null;
  /** In the order of FINGERS; while acquiring the best so far. */
  tips: Tip[];
  /** Filtered, at this picture's time. */
  pose: Pose | null;
  /** Between the hand and the picture. */
  rms_px: number | null;
  /** In the hand's frame: where an object stands. */
  palm_centre_m: number[];
  /** Held for a tenth of a second at least. */
  gesture: Gesture;
  /** That this picture completed. */
  gesture_event: GestureEvent | null;
  /**
   * While fingers are folded there is no `pose`; this is where the palm is, so that an object stays
   * on it. Less sure than a pose; there is none of a hand that was not seen open before.
   */
  held_pose: Pose | null;
  /** Lengths are an average adult's. */
  scale_assumed: boolean;
  /** The camera was not calibrated. */
  camera_assumed: boolean;
}

/** The hand in the last picture, row by row, 255 hand, 0 not. */
export interface Mask {
  data: Uint8Array;
  width: number;
  height: number;
}

/** RGBA from memory, or anything that an OffscreenCanvas can draw. */
export type Picture = ImageData | ImageBitmap | VideoFrame | HTMLVideoElement | HTMLImageElement |
  HTMLCanvasElement | OffscreenCanvas | { data: Uint8ClampedArray; width: number; height: number };

export interface Options {
  /** Without one, 60 degrees across the longer side are assumed. */
  camera?: Camera | null;
  /** Without one, the average adult's: the pose has the right shape and an assumed scale. */
  hand?: Hand | null;
  /** A compiled handyar.wasm, its bytes, or where it lies, if not beside this module. */
  wasm?: WebAssembly.Module | BufferSource | URL | string;
}

/** Picture and time in, state and pose out; on the page, in a worker or in Node. */
export class HandTracker {
  private constructor();
  static create(options?: Options): Promise<HandTracker>;

  /**
   * Two trackers for two hands before one camera: each leaves the hand that the other follows alone,
   * so that they do not change hands when these pass each other. Every picture is for both, for the
   * first one first.
   */
  static createPair(options?: Options): Promise<[HandTracker, HandTracker]>;

  /** The camera of the last picture; null before the first. */
  readonly camera: Camera | null;

  /**
   * Times must increase from picture to picture. A picture without a hand gives a state, never an
   * old pose. Throws an Error of one line when the picture cannot be processed: smaller than 160x120
   * or larger than 4096x2160, not of the calibrated camera's shape, or not later than the last.
   * A VideoFrame or ImageBitmap stays the caller's, to be closed.
   */
  process(picture: Picture, time_s: number): Result;

  /** The pose expected at a later time, for display; null when not tracking, or too long after. */
  predict(time_s: number): Pose | null;

  /** The hand's silhouette in the last picture; null without a hand. */
  mask(): Mask | null;

  /**
   * The frame of an object that stands there, in the hand's frame, as of the last picture; moves with
   * the finger. +z is up: away from the hand, for a fingertip along the finger; +x towards the wrist,
   * for a fingertip out of the visible face. null without a pose or held pose.
   */
  T_hand_object(place: Place): Float64Array | null;

  /** The person's hand as far as it was learned, in the layout last tracked. */
  hand(): Hand | null;

  /** Begins anew with another hand. */
  setHand(hand: Hand | null): void;

  /**
   * Begins anew with another camera; null: an assumed one. Throws an Error when it was calibrated
   * for pictures of another shape than the last.
   */
  setCamera(camera: Camera | null): void;

  /** Forgets hand and colours, as newly made. */
  reset(): void;
}

/** What a LiveTracker made of a picture. */
export interface Tracked {
  /** The picture that the result belongs to; valid during the call. */
  frame: VideoFrame;
  result: Result;
  mask: Mask | null;
  /** T_hand_object of the wanted places; empty without a pose or held pose. */
  places: Partial<Record<Place, Float64Array>>;
  /** Of pictures of this size. */
  camera: Camera;
}

export interface LiveOptions extends Options {
  /** Places to be told of with every picture. */
  places?: Place[];
  onFrame?: (tracked: Tracked) => void;
  /** A picture could not be processed. */
  onError?: (error: Error) => void;
}

/**
 * Tracks the hand in a playing video, in a worker. Always the newest picture, never a queue: of
 * those that come in while the worker is busy only the last is kept.
 */
export class LiveTracker {
  private constructor();
  static start(video: HTMLVideoElement, options?: LiveOptions): Promise<LiveTracker>;
  /** Ends the worker; the video goes on. */
  stop(): void;
  /** The pose expected at `time_s` (performance.now() / 1000), or null without a hand. */
  predict(time_s: number): Pose | null;
  /** Places to be told of from the next picture on. */
  places: Place[];
  /** As HandTracker. */
  hand(): Promise<Hand | null>;
  setHand(hand: Hand | null): Promise<void>;
  setCamera(camera: Camera | null): Promise<void>;
}

/** A camera without distortion that sees `fov_rad` (60 degrees) across the longer side. */
export function cameraFromFieldOfView(width_px: number, height_px: number, fov_rad?: number): Camera;

/** A camera from the text of a YAML file as OpenCV and ROS write it; throws an Error that names `name`. */
export function readCamera(text: string, name?: string): Camera;

/** A hand from the text of a JSON file; throws an Error that names `name`. JSON.stringify() writes it. */
export function readHand(text: string, name?: string): Hand;

/** The pose carried to `time_s` with the velocities that it has. */
export function predictPose(pose: Pose, time_s: number): Pose;

/** WebGL's projection of a camera, 16 numbers, column-major; distortion is left out. */
export function projectionMatrix(camera: Camera, near_m?: number, far_m?: number): number[];
