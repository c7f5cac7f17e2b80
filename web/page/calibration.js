// SPDX-License-Identifier: MIT
// A person's own hand: its shape is learned while it turns, its size is typed.

import { readHand } from 'handyar';

const LEAST_TURN_rad = Math.PI / 6;
const LEAST_VIEWS = 20;
const KEPT = 'handyar-hand';

let kept = null;
try {
  kept = readHand(localStorage.getItem(KEPT));
} catch {
  // There is none, or this browser keeps nothing.
}

/** The hand kept in this browser, or while the page is open where it keeps nothing; or null. */
export function keptHand() {
  return kept;
}

export function keepHand(hand) {
  kept = hand;
  try {
    if (hand) localStorage.setItem(KEPT, JSON.stringify(hand));
    else localStorage.removeItem(KEPT);
  } catch {
    // It is forgotten with the page.
  }
}

export const span_m = ({ tips_m: { thumb, little } }) => Math.hypot(...thumb.map((x, i) => x - little[i]));

/** The learned shape at the size that the ruler gives it. */
export function measuredHand(learned, known_span_m) {
  const factor = known_span_m / span_m(learned);
  const scaled = (points) => Object.fromEntries(
    Object.entries(points).map(([finger, p]) => [finger, p.map((x) => factor * x)]));
  return {
    ...learned, tips_m: scaled(learned.tips_m), tips_sigma_m: scaled(learned.tips_sigma_m),
    source: 'self', scale: 'measured' };
}

/** From how many sides the hand has been seen. */
export class Turning {
  #directions = [];  // to the camera, in the hand's frame
  #views = 0;

  take({ pose, doubtful }) {
    if (!pose || doubtful) return;
    ++this.#views;
    const T = pose.T_camera_hand, t = T.slice(12, 15);
    const distance_m = Math.hypot(...t);
    const direction = [0, 1, 2].map((axis) =>
      -(T[4 * axis] * t[0] + T[4 * axis + 1] * t[1] + T[4 * axis + 2] * t[2]) / distance_m);
    const isNew = this.#directions.every((d) => angle_rad(d, direction) > LEAST_TURN_rad / 20);
    if (isNew) this.#directions.push(direction);
  }

  /** 0 to 1. */
  get done() {
    let turned_rad = 0;
    for (const a of this.#directions)
      for (const b of this.#directions) turned_rad = Math.max(turned_rad, angle_rad(a, b));
    return Math.min(1, turned_rad / LEAST_TURN_rad, this.#views / LEAST_VIEWS);
  }
}

function angle_rad(a, b) {
  return Math.acos(Math.min(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]));
}
