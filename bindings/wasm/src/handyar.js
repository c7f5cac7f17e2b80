// SPDX-License-Identifier: MIT
// A bare outstretched hand, used like a printed AR marker. What everything means is said in
// handyar.d.ts.
import {
  Library, PLACES, readHandStruct, readMask, readPose, readResult, readTransform, writeCamera,
  writeFrame, writeHand,
} from './memory.js';

export { readCamera, readHand } from './files.js';
export { LiveTracker } from './live.js';
export { predictPose, projectionMatrix } from './pose.js';
export { FINGERS, PLACES } from './memory.js';

export function cameraFromFieldOfView(width_px, height_px, fov_rad = Math.PI / 3) {
  const f_px = 0.5 * Math.max(width_px, height_px) / Math.tan(0.5 * fov_rad);
  return {
    width_px, height_px, fx_px: f_px, fy_px: f_px,
    cx_px: 0.5 * (width_px - 1), cy_px: 0.5 * (height_px - 1),
    distortion: [0, 0, 0, 0, 0], assumed: true };
}

function requireShape(camera, width_px, height_px) {
  if (camera.assumed || Math.abs(camera.height_px * width_px / camera.width_px - height_px) <= 1) return;
  throw new Error(`the camera was calibrated for pictures of ${camera.width_px}x` +
    `${camera.height_px}, these are ${width_px}x${height_px}`);
}

/** The same camera read out at another size of the same shape; an assumed one: of any shape. */
function scaledTo(camera, width_px, height_px) {
  const sx = width_px / camera.width_px, sy = height_px / camera.height_px;
  // What is assumed is the field of view across the longer side.
  const longer = Math.max(width_px, height_px) / Math.max(camera.width_px, camera.height_px);
  return {
    ...camera, width_px, height_px,
    fx_px: (camera.assumed ? longer : sx) * camera.fx_px, fy_px: (camera.assumed ? longer : sy) * camera.fy_px,
    cx_px: sx * (camera.cx_px + 0.5) - 0.5, cy_px: sy * (camera.cy_px + 0.5) - 0.5 };
}

/** The pixels of a picture that lies elsewhere than in memory. */
class PictureReader {
  #context = null;

  read(picture) {
    if (picture.data) return picture;
    // Elements of a page call their width what they have there.
    const width = picture.displayWidth ?? picture.videoWidth ?? picture.naturalWidth ?? picture.width;
    const height = picture.displayHeight ?? picture.videoHeight ?? picture.naturalHeight ?? picture.height;
    if (this.#context === null)
      this.#context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    const { canvas } = this.#context;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    this.#context.drawImage(picture, 0, 0, width, height);
    return this.#context.getImageData(0, 0, width, height);
  }
}

export class HandTracker {
  #library;
  #given;             // camera, or null: a field of view is assumed of pictures of any size; hand
  #camera = null;     // of pictures of the last size
  #tracker = 0;       // made for the first picture
  #answer;            // where functions write what is no struct
  #structs;
  #pixels = { address: 0, length: 0 };
  #pictures = new PictureReader();
  #pair = [this];     // those that share its view, the first one first

  static async create({ camera = null, hand = null, wasm } = {}) {
    return HandTracker.#within(await Library.load(wasm), camera, hand);
  }

  static async createPair({ camera = null, hand = null, wasm } = {}) {
    const library = await Library.load(wasm);
    const pair = [1, 2].map(() => HandTracker.#within(library, camera, hand));
    for (const tracker of pair) tracker.#pair = pair;
    return pair;
  }

  static #within(library, camera, hand) {
    const tracker = new HandTracker();
    tracker.#library = library;
    tracker.#given = { camera, hand };
    tracker.#answer = library.allocate(16 * 8);
    tracker.#structs = Object.fromEntries(
      ['camera', 'hand', 'frame', 'result', 'pose', 'mask'].map((name) => [name, library.make(name)]));
    return tracker;
  }

  /** The camera of the last picture; null before the first. */
  get camera() {
    return this.#camera;
  }

  process(picture, time_s) {
    const { data, width, height } = this.#pictures.read(picture);
    if (data.length !== 4 * width * height)
      throw new Error(`a picture of ${width}x${height} has ${4 * width * height} bytes of RGBA, not ${data.length}`);
    this.#prepare(width, height, data.length);
    const { frame, result } = this.#structs;
    this.#library.bytes(this.#pixels.address, data.length).set(data);
    writeFrame(frame, width, height, this.#pixels.address);
    this.#library.call('process', this.#tracker, frame.address, time_s, result.address);
    return readResult(result, time_s);
  }

  predict(time_s) {
    const { pose } = this.#structs;
    const known = this.#tracker !== 0 &&
      this.#library.call('predict', this.#tracker, time_s, pose.address);
    return known ? readPose(pose) : null;
  }

  mask() {
    const { mask } = this.#structs;
    const known = this.#tracker !== 0 &&
      this.#library.call('get_mask', this.#tracker, mask.address);
    return known ? readMask(this.#library, mask) : null;
  }

  T_hand_object(place) {
    const where = PLACES.indexOf(place);
    if (where < 0) throw new Error(`there is no ${place} on a hand, only ${PLACES.join(', ')}`);
    const known = this.#tracker !== 0 &&
      this.#library.call('get_attachment', this.#tracker, where, this.#answer);
    return known ? readTransform(this.#library, this.#answer) : null;
  }

  hand() {
    if (this.#tracker === 0) return this.#given.hand;
    const { hand } = this.#structs;
    this.#library.call('get_hand', this.#tracker, hand.address);
    return readHandStruct(hand);
  }

  setHand(hand) {
    this.#given.hand = hand;
    this.#forget();
  }

  setCamera(camera) {
    if (camera && this.#camera) requireShape(camera, this.#camera.width_px, this.#camera.height_px);
    this.#given.camera = camera;
    this.#forget();
  }

  reset() {
    if (this.#tracker !== 0) this.#library.reset(this.#tracker);
  }

  /** A tracker and memory for pictures of this size. */
  #prepare(width_px, height_px, length) {
    if (this.#pixels.length !== length) {
      this.#library.free(this.#pixels.address);
      this.#pixels = { address: this.#library.allocate(length), length };
    }
    const same = this.#camera?.width_px === width_px && this.#camera.height_px === height_px;
    if (this.#tracker !== 0 && same) return;
    const { camera: given, hand } = this.#given;
    if (given) requireShape(given, width_px, height_px);
    this.#camera = given ? scaledTo(given, width_px, height_px)
      : cameraFromFieldOfView(width_px, height_px);
    this.#forget();
    const { camera, hand: hand_struct } = this.#structs;
    writeCamera(camera, this.#camera);
    if (hand) writeHand(hand_struct, hand);
    this.#library.call('create', camera.address, hand ? hand_struct.address : 0, 0, this.#answer);
    this.#tracker = this.#library.view().getInt32(this.#answer, true);
    const pair = this.#pair.map((tracker) => tracker.#tracker);
    if (pair.length === 2 && !pair.includes(0)) this.#library.shareView(...pair);
  }

  #forget() {
    this.#library.destroy(this.#tracker);
    this.#tracker = 0;
  }
}
