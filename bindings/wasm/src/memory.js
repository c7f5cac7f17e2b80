// SPDX-License-Identifier: MIT
// The C interface (bindings/c/handyar.h) and its structs in WebAssembly's memory.
import * as layouts from '../dist/layout.js';
import { toGl } from './pose.js';

const OK = 0, NO_HAND = 9, RGBA = 3;
const STATES = ['searching', 'acquiring', 'tracking', 'lost'];
const LAYOUTS = [null, 'thumb_right', 'thumb_left'];
const FACES = [null, 'palm', 'back'];
const SIDES = [null, 'left', 'right'];
const GESTURES = ['open', 'fist', 'four'];
const EVENTS = [null, 'grab', 'release', 'click'];
const SOURCES = ['checkerboard', 'default', 'self', 'truth'];
export const FINGERS = ['thumb', 'index', 'middle', 'ring', 'little'];

// Places of the hand, in the order of handyar.h.
export const PLACES = [
  'face', 'palm', 'back', 'wrist', ...FINGERS.map((finger) => `${finger}_base`),
  ...FINGERS.map((finger) => `${finger}_tip`)];

/** `wasm`: a compiled module, its bytes, or where it lies; by default what came with the package. */
async function compile(wasm = new URL('../dist/handyar.wasm', import.meta.url)) {
  if (wasm instanceof WebAssembly.Module) return wasm;
  if (!(wasm instanceof URL) && typeof wasm !== 'string') return WebAssembly.compile(wasm);
  const url = new URL(wasm, import.meta.url);
  if (url.protocol === 'file:') {
    const { readFile } = await import('node:fs/promises');
    return WebAssembly.compile(await readFile(url));
  }
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return WebAssembly.compile(await response.arrayBuffer());
}

/** A struct of handyar.h in memory, its numbers by the names of its fields. */
class Struct {
  constructor(library, layout, address) {
    this.library = library;
    this.layout = layout;
    this.address = address;
  }

  #view(field, index, bytes) {
    return [this.library.view(), this.address + this.layout[field] + index * bytes];
  }

  int(field) {
    const [view, at] = this.#view(field, 0, 4);
    return view.getInt32(at, true);
  }

  setInt(field, value) {
    const [view, at] = this.#view(field, 0, 4);
    view.setInt32(at, value, true);
  }

  double(field, index = 0) {
    const [view, at] = this.#view(field, index, 8);
    return view.getFloat64(at, true);
  }

  doubles(field, count) {
    return Array.from({ length: count }, (_, i) => this.double(field, i));
  }

  setDoubles(field, values) {
    values.forEach((x, i) => {
      const [view, at] = this.#view(field, i, 8);
      view.setFloat64(at, x, true);
    });
  }

  /** Element `index` of the structs in a field. */
  inner(field, layout, index = 0) {
    return new Struct(this.library, layout, this.address + this.layout[field] + index * layout.bytes);
  }
}

/** handyar.wasm with its memory. */
export class Library {
  #exports;
  #view;

  static async load(wasm) {
    const library = new Library();
    const { exports } = await WebAssembly.instantiate(await compile(wasm), {});
    exports._initialize();
    library.#exports = exports;
    library.#view = new DataView(exports.memory.buffer);
    return library;
  }

  /** All of memory; anew once it has grown. */
  view() {
    if (this.#view.buffer !== this.#exports.memory.buffer)
      this.#view = new DataView(this.#exports.memory.buffer);
    return this.#view;
  }

  bytes(address, length) {
    return new Uint8Array(this.#exports.memory.buffer, address, length);
  }

  allocate(bytes) {
    const address = this.#exports.malloc(bytes);
    if (address === 0) throw new Error('handyar: no memory');
    return address;
  }

  free(address) {
    this.#exports.free(address);
  }

  /** A struct of zeros that says its size, if it is of the kind that does. */
  make(name) {
    const layout = layouts[name];
    const address = this.allocate(layout.bytes);
    this.bytes(address, layout.bytes).fill(0);
    const struct = new Struct(this, layout, address);
    if ('size' in layout) struct.setInt('size', layout.bytes);
    return struct;
  }

  /** Calls a function that returns a status; false: there is no hand to answer with. */
  call(name, ...args) {
    const status = this.#exports[`handyar_${name}`](...args);
    if (status === NO_HAND) return false;
    if (status !== OK) throw new Error(`handyar: ${this.#text(this.#exports.handyar_describe(status))}`);
    return true;
  }

  destroy(tracker) {
    this.#exports.handyar_destroy(tracker);
  }

  reset(tracker) {
    this.#exports.handyar_reset(tracker);
  }

  shareView(first, second) {
    this.#exports.handyar_share_view(first, second);
  }

  #text(address) {
    const bytes = this.bytes(address, 200);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

export function writeCamera(struct, camera) {
  struct.setInt('width_px', camera.width_px);
  struct.setInt('height_px', camera.height_px);
  struct.setInt('assumed', camera.assumed ? 1 : 0);
  for (const field of ['fx_px', 'fy_px', 'cx_px', 'cy_px']) struct.setDoubles(field, [camera[field]]);
  // The struct has room for five; who states more of zero means the same.
  if (camera.distortion.slice(5).some((k) => k !== 0))
    throw new Error('handyar: distortion: k1, k2, p1, p2, k3 are taken, of more only zeros');
  struct.setDoubles('distortion', camera.distortion.slice(0, 5));
}

export function writeHand(struct, hand) {
  const byFinger = (points) => FINGERS.flatMap((finger) => points?.[finger] ?? [0, 0, 0]);
  struct.setInt('layout', LAYOUTS.indexOf(hand.layout));
  struct.setInt('source', SOURCES.indexOf(hand.source));
  struct.setInt('average_scale', hand.scale === 'average' ? 1 : 0);
  struct.setDoubles('tips_m', byFinger(hand.tips_m));
  struct.setDoubles('tips_sigma_m', byFinger(hand.tips_sigma_m));
  struct.setDoubles('thickness_m', [hand.thickness_m ?? 0.005]);
}

/** A hand as a hand file of version 2 holds it. */
export function readHandStruct(struct) {
  const byFinger = (field) => {
    const numbers = struct.doubles(field, 3 * FINGERS.length);
    return Object.fromEntries(FINGERS.map((finger, i) => [finger, numbers.slice(3 * i, 3 * i + 3)]));
  };
  return {
    format: 'handyar-hand',
    version: 2,
    tips_m: byFinger('tips_m'),
    tips_sigma_m: byFinger('tips_sigma_m'),
    layout: LAYOUTS[struct.int('layout')],
    source: SOURCES[struct.int('source')],
    scale: struct.int('average_scale') ? 'average' : 'measured',
    thickness_m: struct.double('thickness_m'),
  };
}

export function writeFrame(struct, width_px, height_px, data) {
  struct.setInt('format', RGBA);
  struct.setInt('width_px', width_px);
  struct.setInt('height_px', height_px);
  struct.setInt('data', data);
  struct.setInt('stride_bytes', 4 * width_px);
}

/** A column-major matrix from 16 numbers, row after row. */
function columnMajor(rows) {
  return Float64Array.from(rows, (_, i) => rows[4 * (i % 4) + (i >> 2)]);
}

export function readTransform(library, address) {
  return columnMajor(Array.from({ length: 16 }, (_, i) => library.view().getFloat64(address + 8 * i, true)));
}

export function readPose(struct) {
  const T_camera_hand = columnMajor(struct.doubles('T_camera_hand', 16));
  const covariance = Float64Array.from(struct.doubles('covariance', 36));
  const sigma = (first) =>
    Math.sqrt((covariance[7 * first] + covariance[7 * first + 7] + covariance[7 * first + 14]) / 3);
  return {
    time_s: struct.double('time_s'),
    T_gl_hand: toGl(T_camera_hand),
    T_camera_hand,
    covariance,
    sigma_rotation_rad: sigma(0),
    sigma_translation_m: sigma(3),
    velocity_m_s: struct.doubles('velocity_m_s', 3),
    angular_velocity_rad_s: struct.doubles('angular_velocity_rad_s', 3),
  };
}

export function readResult(struct, time_s) {
  const poseIn = (field) =>
    (struct.int(`has_${field}`) ? readPose(struct.inner(field, layouts.pose)) : null);
  const pose = poseIn('pose');
  const tips = FINGERS.map((_, i) => {
    const tip = struct.inner('tips', layouts.point, i);
    const [x_px, y_px] = tip.doubles('px', 2);
    return { x_px, y_px, seen: tip.int('seen') === 1, inferred: tip.int('inferred') === 1 };
  });
  return {
    time_s,
    state: STATES[struct.int('state')],
    layout: LAYOUTS[struct.int('layout')],
    face: FACES[struct.int('face')],
    side: SIDES[struct.int('side')],
    doubtful: struct.int('doubtful') === 1,
    scale_assumed: struct.int('scale_assumed') === 1,
    camera_assumed: struct.int('camera_assumed') === 1,
    tips,
    pose,
    rms_px: pose && struct.double('rms_px'),
    palm_centre_m: struct.doubles('palm_centre_m', 3),
    gesture: GESTURES[struct.int('gesture')],
    gesture_event: EVENTS[struct.int('gesture_event')],
    held_pose: poseIn('held_pose'),
  };
}

export function readMask(library, struct) {
  const width = struct.int('width'), height = struct.int('height');
  const address = struct.int('data'), stride = struct.int('stride_bytes');
  const data = new Uint8Array(width * height);
  for (let row = 0; row < height; ++row)
    data.set(library.bytes(address + row * stride, width), row * width);
  return { data, width, height };
}
