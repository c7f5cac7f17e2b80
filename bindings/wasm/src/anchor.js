// SPDX-License-Identifier: MIT
import { Group, Matrix4, Quaternion, Vector3 } from 'three';

import { PLACES } from './memory.js';
import { steadyPose } from './pose.js';

const LOST_AFTER_s = 0.2;
const GLIDE_s = 0.5;

// The tracker's objects have +z up and look along +x, those of three.js +y up and look along +z.
const R_object_model = new Matrix4().set(0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1);

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

  /** What a picture showed. A pose in doubt moves nothing; on a hand that closes the palm leads. */
  take(tracked, now_s) {
    const pose = steadyPose(tracked.result);
    const T_hand_object = tracked.places[this.#place];
    this.#target = null;
    if (!T_hand_object || !pose) return;
    const T_gl_model = new Matrix4().fromArray(pose.T_gl_hand)
      .multiply(new Matrix4().fromArray(T_hand_object)).multiply(R_object_model);
    this.#target = {
      position: new Vector3().setFromMatrixPosition(T_gl_model),
      rotation: new Quaternion().setFromRotationMatrix(T_gl_model) };
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
