// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { test } from 'node:test';

let Anchor, Vector3;
try {
  ({ Vector3 } = await import('three'));
  ({ Anchor } = await import('../src/anchor.js'));
} catch {
  // three is a peer: without it there is no adapter to test
}
const skip = Anchor ? false : 'three is not installed';

/** A hand that faces the camera from `x_m`, `z_m` before it; its palm, upright on it. */
function seen(x_m, z_m, doubtful = false) {
  const T_gl_hand = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x_m, 0, -z_m, 1];
  const T_hand_object = [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, -0.025, 0, 1];
  return { result: { pose: { T_gl_hand }, doubtful }, places: { palm: T_hand_object } };
}
const away = { result: { pose: null, doubtful: false }, places: {} };

function near(vector, expected) {
  assert.ok(vector.distanceTo(new Vector3(...expected)) < 1e-9, `${vector.toArray()} is not ${expected}`);
}

function look(anchor, tracked, now_s) {
  anchor.take(tracked, now_s);
  anchor.move(now_s);
}

test('a group follows the palm, upright on it', { skip }, () => {
  const anchor = new Anchor('palm');
  look(anchor, away, 0);
  assert.equal(anchor.group.visible, false);
  look(anchor, seen(0.1, 0.4), 0.1);
  assert.ok(anchor.group.visible && anchor.followed);
  near(anchor.group.position, [0.1, -0.025, -0.4]);
  near(new Vector3(0, 1, 0).applyQuaternion(anchor.group.quaternion), [0, 0, 1]);   // out of the palm
  near(new Vector3(0, 0, 1).applyQuaternion(anchor.group.quaternion), [0, -1, 0]);  // to the wrist
});

test('it stays when the hand is lost, and is told of once', { skip }, () => {
  const anchor = new Anchor('palm');
  const told = [];
  anchor.onFound = () => told.push('found');
  anchor.onLost = () => told.push('lost');
  look(anchor, seen(0.1, 0.4), 0);
  look(anchor, away, 0.1);
  assert.deepEqual(told, ['found']);
  for (const now_s of [0.3, 0.5, 5]) look(anchor, away, now_s);
  assert.deepEqual(told, ['found', 'lost']);
  assert.ok(anchor.group.visible);
  near(anchor.group.position, [0.1, -0.025, -0.4]);
});

test('a pose in doubt moves nothing', { skip }, () => {
  const anchor = new Anchor('palm');
  look(anchor, seen(0.1, 0.4), 0);
  look(anchor, seen(0.3, 0.9, true), 0.1);
  near(anchor.group.position, [0.1, -0.025, -0.4]);
});

test('on a hand that closes it stays on the palm, and is not lost', { skip }, () => {
  const anchor = new Anchor('palm');
  const told = [];
  anchor.onLost = () => told.push('lost');
  look(anchor, seen(0.1, 0.4), 0);
  for (const now_s of [0.1, 0.5, 1]) {
    const open = seen(0.1 + 0.1 * now_s, 0.4);
    const { pose: held_pose } = open.result;
    look(anchor, { ...open, result: { pose: null, held_pose, doubtful: false } }, now_s);
    near(anchor.group.position, [0.1 + 0.1 * now_s, -0.025, -0.4]);
  }
  assert.ok(anchor.followed);
  assert.deepEqual(told, []);
});

test('it is turned only while the hand is away, and glides back in half a second', { skip }, () => {
  const anchor = new Anchor('palm');
  look(anchor, seen(0, 0.4), 0);
  const standing = anchor.group.quaternion.clone();
  anchor.turn(1, 0);
  assert.ok(anchor.group.quaternion.angleTo(standing) < 1e-9);
  look(anchor, away, 1);
  anchor.turn(1, 0);
  assert.ok(Math.abs(anchor.group.quaternion.angleTo(standing) - 1) < 1e-9);
  look(anchor, seen(0.2, 0.4), 2);
  near(anchor.group.position, [0, -0.025, -0.4]);
  look(anchor, seen(0.2, 0.4), 2.25);
  near(anchor.group.position, [0.1, -0.025, -0.4]);
  assert.ok(Math.abs(anchor.group.quaternion.angleTo(standing) - 0.5) < 1e-6);
  look(anchor, seen(0.2, 0.4), 2.5);
  near(anchor.group.position, [0.2, -0.025, -0.4]);
  assert.ok(anchor.group.quaternion.angleTo(standing) < 1e-9);
});

test('what was hidden appears at the hand without a glide', { skip }, () => {
  const anchor = new Anchor('palm');
  anchor.onLost = () => { anchor.group.visible = false; };
  look(anchor, seen(0, 0.4), 0);
  look(anchor, away, 1);
  look(anchor, seen(0.2, 0.4), 2);
  near(anchor.group.position, [0.2, -0.025, -0.4]);
});

test('there is no other place on a hand', { skip }, () => {
  assert.throws(() => new Anchor('elbow'), /no elbow on a hand/);
});
