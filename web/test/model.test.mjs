// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Box3, Vector3 } from 'three';

import { modelFrom } from '../page/model.js';

/** A .glb file of one node: a triangle 2 wide and 1 high; with `moving` it goes up by 1 in a second. */
function triangle(moving) {
  const corners = [0, 0, 0, 2, 0, 0, 0, 1, 0], times_s = [0, 1], places = [0, 0, 0, 0, 1, 0];
  const binary = new Uint8Array(new Float32Array([...corners, ...times_s, ...places]).buffer);
  const numbers = (bufferView, count, type, min, max) => ({ bufferView, componentType: 5126, count, type, min, max });
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [numbers(0, 3, 'VEC3', [0, 0, 0], [2, 1, 0]), numbers(1, 2, 'SCALAR', [0], [1]), numbers(2, 2, 'VEC3')],
    bufferViews: [[0, 36], [36, 8], [44, 24]].map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength })),
    buffers: [{ byteLength: binary.length }],
    animations: moving ? [{
      channels: [{ sampler: 0, target: { node: 0, path: 'translation' } }], samplers: [{ input: 1, output: 2 }] }] : [] };
  const text = new TextEncoder().encode(JSON.stringify(json));
  const padded = new Uint8Array(4 * Math.ceil(text.length / 4)).fill(0x20);
  padded.set(text);
  const chunk = (kind, bytes) => [new Uint32Array([bytes.length, kind]), bytes];
  const total = 12 + 8 + padded.length + 8 + binary.length;
  const blob = new Blob([new Uint32Array([0x46546c67, 2, total]), ...chunk(0x4e4f534a, padded), ...chunk(0x004e4942, binary)]);
  return Object.assign(blob, { name: 'triangle.glb' });
}

const foot_m = (model) => new Box3().setFromObject(model).min.y;

test('a model stands on its foot and is 9 cm long', async () => {
  const { model, mixer } = await modelFrom(triangle(false));
  const box = new Box3().setFromObject(model);
  assert.ok(Math.abs(box.getSize(new Vector3()).x - 0.09) < 1e-9);
  assert.ok(Math.abs(foot_m(model)) < 1e-9);
  assert.equal(mixer, null);
});

test('an animated model moves, over and over', async () => {
  const { model, mixer } = await modelFrom(triangle(true));
  for (const [time_s, share] of [[0.5, 0.5], [0.25, 0.25], [1.75, 0.75]]) {
    mixer.setTime(time_s);
    assert.ok(Math.abs(foot_m(model) - share * 0.045) < 1e-6, `${foot_m(model)} m at ${time_s} s`);
  }
});
