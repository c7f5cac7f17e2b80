// SPDX-License-Identifier: MIT
// The hand before the camera as the hand of an emulated WebXR device. What everything means is said
// in webxr.d.ts.
import { multiply, quaternionOf, rigid, steadyPose } from './pose.js';

// The device points along -z with +y up; a hand along +y with its visible face along +z. The back of
// the hand is up, whichever face is seen.
const T_hand_ray = {
  back: [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1],
  palm: [-1, 0, 0, 0, 0, 0, -1, 0, 0, -1, 0, 0, 0, 0, 0, 1],
};

export class WebXrHand {
  #device;
  #T_eyes_camera;

  constructor(device, { facing = 'user', eyes_to_camera_m = facing === 'user' ? 0.6 : 0 } = {}) {
    this.#device = device;
    device.primaryInputMode = 'hand';
    const turn = facing === 'user' ? -1 : 1;  // looks at the eyes, or where they look
    this.#T_eyes_camera = [turn, 0, 0, 0, 0, 1, 0, 0, 0, 0, turn, 0, 0, 0, -eyes_to_camera_m, 1];
    this.take({ result: { pose: null } });
  }

  take({ result }) {
    const { side, face } = result, pose = steadyPose(result);
    for (const name of ['left', 'right'])
      this.#device.hands[name].connected = pose !== null && name === side;
    if (!pose || !side) return;
    const { position, quaternion } = this.#device;
    const T_world_camera = multiply(rigid(position, quaternion), this.#T_eyes_camera);
    const T_world_ray = multiply(multiply(T_world_camera, pose.T_gl_hand), T_hand_ray[face]);
    const hand = this.#device.hands[side];
    hand.position.set(...T_world_ray.slice(12, 15));
    hand.quaternion.set(...quaternionOf(T_world_ray));
  }
}
