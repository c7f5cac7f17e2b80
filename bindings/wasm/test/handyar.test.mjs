// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import {
  HandTracker, cameraFromFieldOfView, predictPose, projectionMatrix, readCamera, readHand,
} from '../src/handyar.js';
import { data } from './clip.mjs';

const picture = (width, height) => ({ data: new Uint8ClampedArray(4 * width * height), width, height });
const camera_text = readFileSync(data('sample/camera.yml'), 'utf8');
const hand_text = readFileSync(data('sample/hand.json'), 'utf8');

const near = (actual, expected, bound = 1e-12) =>
  actual.forEach((x, i) => assert.ok(Math.abs(x - expected[i]) <= bound, `${actual} is not ${expected}`));

test('an empty picture has no hand', async () => {
  const tracker = await HandTracker.create();
  const result = tracker.process(picture(640, 480), 0);
  assert.equal(result.state, 'searching');
  assert.equal(result.pose, null);
  assert.equal(tracker.predict(0.1), null);
  assert.equal(tracker.mask(), null);
  assert.ok(result.camera_assumed && result.scale_assumed);
});

test('pictures that cannot be processed are refused in words', async () => {
  const tracker = await HandTracker.create();
  assert.throws(() => tracker.process(picture(64, 48), 0), /160x120/);
  const rgb = { ...picture(320, 240), data: new Uint8Array(3 * 320 * 240) };
  assert.throws(() => tracker.process(rgb, 0), /320x240 has 307200 bytes of RGBA, not 230400/);
  tracker.process(picture(320, 240), 1);
  assert.throws(() => tracker.process(picture(320, 240), 1), /time/);
  assert.throws(() => tracker.process(picture(320, 240), NaN), /time/);
});

test('elements of a page are drawn at the size of their picture', async (t) => {
  globalThis.OffscreenCanvas = class {
    constructor(width, height) {
      Object.assign(this, { width, height });
    }

    getContext() {
      return {
        canvas: this, drawImage() {}, getImageData: (x, y, width, height) => picture(width, height) };
    }
  };
  t.after(() => { delete globalThis.OffscreenCanvas; });
  const tracker = await HandTracker.create();
  const elements = [
    { width: 0, height: 0, videoWidth: 640, videoHeight: 480 },
    { width: 100, height: 50, naturalWidth: 320, naturalHeight: 240 },
    { width: 640, height: 360 }];
  for (const [time_s, element] of elements.entries()) {
    tracker.process(element, time_s);
    const width_px = element.videoWidth ?? element.naturalWidth ?? element.width;
    assert.equal(tracker.camera.width_px, width_px);
  }
});

test('an assumed camera follows the pictures, a calibrated one keeps its shape', async () => {
  const assumed = await HandTracker.create();
  assumed.process(picture(640, 480), 0);
  assumed.process(picture(480, 640), 1);
  assert.deepEqual(assumed.camera, cameraFromFieldOfView(480, 640));
  const wide = await HandTracker.create({ camera: cameraFromFieldOfView(640, 480, 1.4) });
  wide.process(picture(240, 320), 0);
  const { distortion, ...expected } = cameraFromFieldOfView(240, 320, 1.4);
  near(Object.values(expected).map(Number), Object.keys(expected).map((key) => Number(wide.camera[key])), 1e-9);
  wide.setCamera(cameraFromFieldOfView(640, 480));
  assert.ok(wide.process(picture(240, 320), 1).camera_assumed);
  const calibrated = await HandTracker.create({ camera: readCamera(camera_text) });
  calibrated.process(picture(320, 240), 0);
  assert.equal(calibrated.camera.fx_px, 309);
  assert.throws(() => calibrated.process(picture(480, 640), 1), /640x480.*480x640/);
});

test('another camera begins anew, unless its pictures have another shape', async () => {
  const tracker = await HandTracker.create();
  tracker.process(picture(640, 480), 0);
  tracker.setCamera(readCamera(camera_text));
  assert.ok(!tracker.process(picture(640, 480), 1).camera_assumed);
  assert.equal(tracker.camera.fx_px, 618);
  assert.throws(() => tracker.setCamera({ ...readCamera(camera_text), width_px: 700 }), /700x480.*640x480/);
  tracker.setCamera(null);
  assert.ok(tracker.process(picture(640, 480), 2).camera_assumed);
});

test('a camera has five numbers of distortion, and more only of zero', async () => {
  const camera = readCamera(camera_text);
  const bent = async (...more) => {
    const distortion = [-0.2, 0.05, 0, 0, 0.01, ...more];
    return (await HandTracker.create({ camera: { ...camera, distortion } })).process(picture(640, 480), 0);
  };
  await assert.rejects(bent(0.1, 0, 0), /k1, k2, p1, p2, k3/);
  assert.equal((await bent(0, 0, 0)).camera_assumed, false);
});

test('a camera file is read, and its faults are named', () => {
  const camera = readCamera(camera_text);
  assert.deepEqual([camera.width_px, camera.fx_px, camera.cy_px, camera.assumed], [640, 618, 236.94, false]);
  assert.deepEqual(readCamera(`distortion_model: "plumb_bob"\n${camera_text}`), camera);
  assert.deepEqual(readCamera(`${camera_text}assumed: 1\n`), { ...camera, assumed: true });
  for (const [from, to, fault] of [
    ['image_width: 640', '', /^c\.yml: image_width is missing$/],
    ['image_width: 640', 'image_width: 640.5', /^c\.yml: image_width is not a whole number above 0$/],
    ['image_width', 'assumed: 2\nimage_width', /^c\.yml: assumed must be 0 or 1$/],
    ['image_width', 'distortion_model: equidistant\nimage_width', /^c\.yml: distortion_model equidistant is not supported/],
    ['618.0, 0.0, 322.38', '618.0, 322.38', /^c\.yml: camera_matrix has 8 numbers$/],
    ['618.0', 'x', /^c\.yml: camera_matrix holds something that is not a number$/],
    ['322.38', '1000', /^c\.yml: the principal point lies outside the picture$/],
  ])
    assert.throws(() => readCamera(camera_text.replace(from, to), 'c.yml'),
      (error) => fault.test(error.message));
});

test('a hand file is read, and its faults are named', () => {
  assert.equal(readHand(hand_text).source, 'truth');
  assert.throws(() => readHand('{', 'h.json'), /^Error: h\.json: is not JSON$/);
  const faulty = (change) => {
    const hand = JSON.parse(hand_text);
    change(hand);
    return () => readHand(JSON.stringify(hand), 'h.json');
  };
  assert.throws(faulty((h) => delete h.tips_m.ring), /h\.json: tips_m: ring is not/);
  assert.throws(faulty((h) => { h.layout = 'thumb_left'; }), /h\.json: layout is thumb_left, but/);
  assert.throws(faulty((h) => { h.version = 9; }), /h\.json: version 9 is not known/);
  assert.throws(faulty((h) => { h.tips_m.thumb[0] = 9; }), /h\.json: tips_m: .* mm apart/);
  assert.throws(faulty((h) => { h.thickness_m = 'thin'; }), /h\.json: thickness_m is not a number/);
  assert.throws(faulty((h) => { h.scale = 'large'; }), /h\.json: scale is neither/);
  assert.throws(faulty((h) => { h.tips_sigma_m = { ...h.tips_m, thumb: [0, 0, -1] }; }), /tips_sigma_m: a deviation is negative/);
});

test('the hand that a tracker holds can be written and read again', async () => {
  const tracker = await HandTracker.create({ hand: readHand(hand_text) });
  tracker.process(picture(640, 480), 0);
  const hand = tracker.hand();
  readHand(JSON.stringify(hand));
  near(hand.tips_m.little, readHand(hand_text).tips_m.little, 0.01);
});

test('the projection puts points where the camera sees them', () => {
  const camera = readCamera(camera_text);
  const P = projectionMatrix(camera, 0.1, 5);
  const [x, y, z] = [0.03, -0.02, -0.4];  // right, up, before the camera
  const clip = [0, 1, 2, 3].map((row) => P[row] * x + P[4 + row] * y + P[8 + row] * z + P[12 + row]);
  const px = [(clip[0] / clip[3] + 1) / 2 * 640 - 0.5, (1 - clip[1] / clip[3]) / 2 * 480 - 0.5];
  near(px, [618 * 0.03 / 0.4 + 322.38, 618 * 0.02 / 0.4 + 236.94], 1e-9);
  const depth = (z_m) => (P[10] * z_m + P[14]) / -z_m;
  near([depth(-0.1), depth(-5)], [-1, 1], 1e-12);
});

test('a pose is carried on with its velocities', () => {
  const T_camera_hand = Float64Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.5, 1);
  const pose = {
    time_s: 1, T_camera_hand, velocity_m_s: [0.1, 0, -0.2], angular_velocity_rad_s: [0, 0, Math.PI] };
  const later = predictPose(pose, 1.5);
  near(later.T_camera_hand, [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0.05, 0, 0.4, 1]);
  near(later.T_gl_hand.slice(12), [0.05, 0, -0.4, 1]);
  assert.equal(T_camera_hand[0], 1);
});

test('the package has the version of the library', () => {
  const header = readFileSync(data('../include/handyar/api.h'), 'utf8');
  const { version } = JSON.parse(readFileSync(new URL('../package.json', import.meta.url)));
  assert.equal(/HANDYAR_VERSION "(.*)"/.exec(header)[1], version);
});
