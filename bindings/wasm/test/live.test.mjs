// SPDX-License-Identifier: MIT
// The page's side of a tracker in a worker, with a worker and a video that are made up.
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';

import { LiveTracker } from '../src/live.js';

/** Answers what it is asked with the question, until it is ended. */
class EchoWorker {
  #ended = false;

  postMessage({ ask, id }) {
    queueMicrotask(() => this.#ended || this.onmessage({ data: { id, answer: ask } }));
  }

  terminate() {
    this.#ended = true;
  }
}

const video = { requestVideoFrameCallback: () => 1, cancelVideoFrameCallback() {} };

beforeEach(() => Object.assign(globalThis, { Worker: EchoWorker, VideoFrame: class {} }));

/** What becomes of a promise, or 'waits'. */
const fate = (promise) => Promise.race([
  promise.then((answer) => answer, (error) => error.message),
  new Promise((resolve) => setImmediate(resolve, 'waits'))]);

test('what is asked is answered until the tracker is stopped, and then refused', async () => {
  const live = await LiveTracker.start(video);
  assert.equal(await fate(live.hand()), 'hand');
  const asked = live.setHand(null);
  live.stop();
  assert.equal(await fate(asked), 'the tracker was stopped');
  for (const late of [live.hand(), live.setHand(null), live.setCamera(null)])
    assert.equal(await fate(late), 'the tracker was stopped');
});
