// SPDX-License-Identifier: MIT
import { Group, Matrix4, Quaternion, Vector3 } from 'three';

import { FINGERS } from './memory.js';

const LOST_AFTER_s = 0.2;
const GLIDE_s = 0.5;
const REACH_m = 0.3;  // no place on a hand is farther from its origin

// At every place +y is out of the visible face and +z towards the wrist, so that a model with its
// feet at the origin stands on the hand and looks at who holds it.
const R_hand_place = new Matrix4().set(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);

export const PLACES = ['palm', ...FINGERS.map((finger) => `${finger}_tip`), 'wrist'];

/** Where a pixel's ray meets the plane of the fingertips, in the hand frame; null: nowhere near. */
function onFingertipPlane({ x_px, y_px }, { T_gl_hand, camera }) {
  const T_hand_gl = T_gl_hand.clone().invert();
  const eye = new Vector3().applyMatrix4(T_hand_gl);
  const ray = new Vector3((x_px - camera.cx_px) / camera.fx_px, -(y_px - camera.cy_px) / camera.fy_px, -1)
    .transformDirection(T_hand_gl);
  const point = eye.addScaledVector(ray, -eye.z / ray.z);
  return point.length() < REACH_m ? point : null;
}

/** A place in the hand frame, or null while it is not known. */
function locate(place, { result, camera }, T_gl_hand) {
  const palm = new Vector3(...result.palm_centre_m);
  if (place === 'palm') return palm;
  // Of the way from the thumb tip's height to the crease of the wrist the palm centre is a quarter.
  if (place === 'wrist') return palm.multiplyScalar(4);
  const tip = result.tips[PLACES.indexOf(place) - 1];
  return tip.seen || tip.inferred ? onFingertipPlane(tip, { T_gl_hand, camera }) : null;
}

/** A place on the hand. What is put into its group follows the hand. */
export class Anchor {
  group = new Group();
  onFound = null;
  onLost = null;
  onUpdate = null;
  #place;
  #target = null;    // where the hand has it, while it is seen
  #seen_s = -Infinity;
  #followed = false;
  #from = null;      // where a glide begins

  constructor(place) {
    if (!PLACES.includes(place)) throw new Error(`there is no ${place} on a hand, only ${PLACES.join(', ')}`);
    this.#place = place;
    this.group.visible = false;
  }

  get place() {
    return this.#place;
  }

  /** Whether it follows the hand now; else it stays where it was last. */
  get followed() {
    return this.#followed;
  }

  /** What a picture showed. A pose in doubt moves nothing. */
  take(tracked, now_s) {
    const { pose, doubtful } = tracked.result;
    this.#target = null;
    if (!pose || doubtful) return;
    const T_gl_hand = new Matrix4().fromArray(pose.T_gl_hand);
    const place = locate(this.#place, tracked, T_gl_hand);
    if (place === null) return;
    const position = place.applyMatrix4(T_gl_hand);
    const rotation = new Quaternion().setFromRotationMatrix(T_gl_hand.multiply(R_hand_place));
    this.#target = { position, rotation };
    this.#seen_s = now_s;
  }

  /** To be called before each drawing. */
  move(now_s) {
    if (this.#target) this.#follow(now_s);
    else if (this.#followed && now_s - this.#seen_s > LOST_AFTER_s) {
      this.#followed = false;
      this.onLost?.();
    }
  }

  /** Turns what stays while the hand is away, about the camera's upright and level axis. */
  turn(about_y_rad, about_x_rad) {
    if (this.#followed) return;
    const { quaternion } = this.group;
    quaternion.premultiply(new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), about_y_rad));
    quaternion.premultiply(new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), about_x_rad));
  }

  #follow(now_s) {
    const { position, quaternion } = this.group;
    const found = !this.#followed;
    if (found) {
      this.#followed = true;
      const shown = this.group.visible;
      this.#from = shown ? { position: position.clone(), rotation: quaternion.clone(), start_s: now_s } : null;
      this.group.visible = true;
    }
    const share = this.#from ? Math.min(1, (now_s - this.#from.start_s) / GLIDE_s) : 1;
    if (share === 1) {
      this.#from = null;
      position.copy(this.#target.position);
      quaternion.copy(this.#target.rotation);
    } else {
      const eased = share * share * (3 - 2 * share);
      position.lerpVectors(this.#from.position, this.#target.position, eased);
      quaternion.slerpQuaternions(this.#from.rotation, this.#target.rotation, eased);
    }
    if (found) this.onFound?.();
    this.onUpdate?.();
  }
}
