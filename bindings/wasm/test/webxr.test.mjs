// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { multiply, quaternionOf, rigid } from '../src/pose.js';
import { WebXrHand } from '../src/webxr.js';

let iwer = null;
try {
  iwer = await import('iwer');
} catch {
  // what the bridge leads to: who does not use it has no need of it
}
const skip = iwer ? false : 'iwer is not installed';

function emulated() {
  return new iwer.XRDevice(iwer.metaQuest3, { canvasContainer: { dataset: {}, style: {} } });
}

/** A hand, fingers up, 0.4 m before the camera and 0.1 m to the right in its picture. */
const seen = (face, side) => ({ result: {
  pose: { T_gl_hand: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.1, 0, -0.4, 1] }, doubtful: false, face, side } });

function near(actual, expected) {
  assert.ok(Math.hypot(...expected.map((x, i) => x - actual[i])) < 1e-6, `${actual} is not ${expected}`);
}

/** A direction of the device's hand, in the world. */
function direction({ quaternion }, axis) {
  return rigid({ x: 0, y: 0, z: 0 }, quaternion).slice(4 * axis, 4 * axis + 3);
}

test('rotations become quaternions and back', () => {
  for (const q of [[0, 0, 0, 1], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0.5, -0.5, 0.5, 0.5], [0.6, 0, 0, -0.8]]) {
    const [x, y, z, w] = q;
    const again = quaternionOf(rigid({ x: 1, y: 2, z: 3 }, { x, y, z, w }));
    assert.ok(Math.abs(again.reduce((sum, v, i) => sum + v * q[i], 0)) > 1 - 1e-12, `${again} is not ${q}`);
  }
});

test('matrices are multiplied as they are applied', () => {
  const quarter = rigid({ x: 1, y: 0, z: 0 }, { x: 0, y: 0, z: Math.SQRT1_2, w: Math.SQRT1_2 });
  near(multiply(quarter, quarter).slice(12, 15), [1, 1, 0]);
});

test('a palm shown to a webcam is a hand before the eyes', { skip }, () => {
  const device = emulated();
  device.position.set(0, 1.6, 0);
  const bridge = new WebXrHand(device);
  assert.equal(device.primaryInputMode, 'hand');
  assert.equal(device.hands.right.connected, false);
  bridge.take(seen('palm', 'right'));
  const { position } = device.hands.right;
  near([position.x, position.y, position.z], [-0.1, 1.6, -0.2]);
  near(direction(device.hands.right, 2), [0, -1, 0]);  // points up
  near(direction(device.hands.right, 1), [0, 0, 1]);   // the person sees the hand's back
  assert.deepEqual([device.hands.left.connected, device.hands.right.connected], [false, true]);
  bridge.take({ result: { pose: null } });
  assert.equal(device.hands.right.connected, false);
});

test('a hand that closes stays connected where its palm is', { skip }, () => {
  const device = emulated();
  const bridge = new WebXrHand(device, { facing: 'environment' });
  bridge.take(seen('back', 'left'));
  const { result } = seen('back', 'left');
  const held_pose = { T_gl_hand: result.pose.T_gl_hand.map((x, i) => (i === 12 ? 0.2 : x)) };
  const before_m = device.hands.left.position.x;
  bridge.take({ result: { ...result, pose: null, held_pose } });
  assert.equal(device.hands.left.connected, true);
  assert.ok(Math.abs(device.hands.left.position.x - before_m - 0.1) < 1e-6);
});

test('a hand seen over the shoulder, in doubt no more', { skip }, () => {
  const device = emulated();
  device.position.set(0, 1.6, 0);
  device.quaternion.set(0, Math.SQRT1_2, 0, Math.SQRT1_2);  // looks to the left, along -x
  const bridge = new WebXrHand(device, { facing: 'environment' });
  bridge.take(seen('back', 'left'));
  const { position } = device.hands.left;
  near([position.x, position.y, position.z], [-0.4, 1.6, -0.1]);
  near(direction(device.hands.left, 1), [1, 0, 0]);  // its back towards the eyes
  const doubtful = seen('back', 'left');
  doubtful.result.doubtful = true;
  bridge.take(doubtful);
  assert.equal(device.hands.left.connected, false);
});
