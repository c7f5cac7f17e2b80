// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Teller } from '../page/words.js';

/** What is said last when pictures come `rate_per_s` from `from_s` to `to_s`. */
function last(teller, from_s, to_s, rate_per_s, seen, video = false) {
  let said;
  for (let k = 0; from_s + k / rate_per_s <= to_s; ++k)
    said = teller.say({ time_s: from_s + k / rate_per_s, state: 'searching', doubtful: false, ...seen }, video);
  return said;
}

test('first the hand is asked for, and after six seconds how', () => {
  const teller = new Teller();
  assert.match(last(teller, 100, 105, 30), /^Hold up an open hand/);
  assert.match(last(teller, 105.1, 107, 30), /^No hand is found/);
});

test('of a hand that is tracked nothing is said, but where it is doubtful', () => {
  const teller = new Teller();
  assert.equal(last(teller, 0, 10, 30, { state: 'tracking' }), '');
  assert.equal(last(teller, 10.1, 11, 30, { state: 'tracking', doubtful: true }), 'Show the open hand again.');
  assert.match(last(teller, 11.1, 15, 30), /^Hold up an open hand/);  // it was there four seconds ago
});

test('of a hand that has closed nothing is said either', () => {
  const teller = new Teller();
  const closed = { state: 'lost', held_pose: { time_s: 0 } };
  assert.equal(last(teller, 0, 10, 30, closed), '');
  assert.match(last(teller, 10.1, 11, 30, { state: 'lost', held_pose: null }), /^Hold up an open hand/);
});

test('few pictures are told of, with their rate, but not of a recording', () => {
  assert.match(last(new Teller(), 0, 5, 8, { state: 'tracking' }), /^Only 8 pictures a second come in/);
  assert.equal(last(new Teller(), 0, 5, 8, { state: 'tracking' }, true), '');
  assert.equal(last(new Teller(), 0, 1, 8, { state: 'tracking' }), '');  // too early to tell
  assert.match(last(new Teller(), 0, 5, 8), /^Hold up an open hand/, 'what the person can do comes first');
});
