// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { afterEach, test } from 'node:test';

const hand_text = readFileSync(new URL('../../data/sample/hand.json', import.meta.url), 'utf8');

/** The module as a page that was just opened has it, in a browser that keeps `items`. */
let opened = 0;
function open(items) {
  globalThis.localStorage = {
    getItem: (key) => items[key] ?? null,
    setItem: (key, text) => { items[key] = text; },
    removeItem: (key) => { delete items[key]; } };
  return import(`../page/calibration.js?${++opened}`);
}

afterEach(() => { delete globalThis.localStorage; });

test('a hand is kept until it is forgotten', async () => {
  const items = {}, hand = JSON.parse(hand_text);
  const { keepHand } = await open(items);
  keepHand(hand);
  const { keepHand: keepAnother, keptHand } = await open(items);
  assert.deepEqual(keptHand(), hand);
  keepAnother(null);
  assert.equal(keptHand(), null);
  assert.equal((await open(items)).keptHand(), null);
});

test('where a browser keeps nothing the hand is there while the page is open', async () => {
  const refuse = () => { throw new Error('the storage is closed'); };
  const refused = new Proxy({}, { get: refuse, set: refuse, deleteProperty: refuse });
  const { keepHand, keptHand } = await open(refused);
  assert.equal(keptHand(), null);
  const hand = JSON.parse(hand_text);
  keepHand(hand);
  assert.deepEqual(keptHand(), hand);
});

test('what is kept and is no hand is none', async () => {
  for (const text of ['{', '{"format": "handyar-hand"}'])
    assert.equal((await open({ 'handyar-hand': text })).keptHand(), null);
});
