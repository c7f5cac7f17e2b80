// SPDX-License-Identifier: MIT
import { predictPose } from './pose.js';

const MOST_PREDICTED_s = 0.25;  // as the tracker itself

const stopped = () => new Error('the tracker was stopped');

/**
 * Tracks the hand in a playing video, in a worker. Always the newest picture, never a queue: what
 * comes in while the worker is busy is left out, all but the last.
 */
export class LiveTracker {
  places;
  #video;
  #worker;
  #onFrame;
  #onError;
  #waiting = new Map();
  #asked = 0;
  #busy = false;
  #newest = null;  // time of a picture that came in while the worker was busy
  #callback = 0;
  #last_time_s = 0;
  #pose = null;
  #stopped = false;

  static async start(video, { camera, hand, wasm, places = [], onFrame, onError } = {}) {
    if (!globalThis.VideoFrame || !video.requestVideoFrameCallback)
      throw new Error('this browser is too old: it does not hand out the pictures of a video');
    const live = new LiveTracker();
    live.#video = video;
    live.places = places;
    live.#onFrame = onFrame ?? (() => {});
    live.#onError = onError ?? console.error;
    live.#worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    live.#worker.onmessage = ({ data }) => live.#settle(data);
    live.#worker.onerror = (event) => live.#fail(new Error(event.message ?? 'the worker did not load'));
    try {
      await live.#ask('create', { options: { camera, hand, wasm } });
    } catch (error) {
      live.stop();
      throw error;
    }
    live.#callback = video.requestVideoFrameCallback(live.#pictureCame);
    return live;
  }

  /** Ends the worker; the video goes on. */
  stop() {
    this.#stopped = true;
    this.#video.cancelVideoFrameCallback(this.#callback);
    this.#worker.terminate();
    this.#fail(stopped());
  }

  /** The pose expected at `time_s` (as performance.now() / 1000), or null without a hand. */
  predict(time_s) {
    const pose = this.#pose;
    return pose && time_s - pose.time_s < MOST_PREDICTED_s ? predictPose(pose, time_s) : null;
  }

  /** The person's hand as far as it was learned, as a hand file holds it. */
  hand() {
    return this.#ask('hand');
  }

  /** Goes on with another hand, from the next picture on. */
  setHand(hand) {
    return this.#ask('setHand', { hand });
  }

  /** Goes on with another camera; rejects when it was calibrated for pictures of another shape. */
  setCamera(camera) {
    return this.#ask('setCamera', { camera });
  }

  #pictureCame = (now_ms, { captureTime }) => {
    this.#callback = this.#video.requestVideoFrameCallback(this.#pictureCame);
    const time_s = (captureTime ?? now_ms) / 1000;
    if (this.#busy) this.#newest = time_s;
    else this.#track(time_s);
  };

  async #track(time_s) {
    if (!(time_s > this.#last_time_s)) return;
    this.#busy = true;
    this.#newest = null;
    this.#last_time_s = time_s;
    // The picture that is shown is the one that the pose belongs to: one copy goes to the worker,
    // the other stays until the answer comes.
    let frame = null;
    try {
      frame = new VideoFrame(this.#video, { timestamp: Math.round(1e6 * time_s) });
      const sent = frame.clone();
      const tracked = await this.#ask('process', { frame: sent, time_s, places: this.places }, [sent]);
      this.#pose = tracked.result.pose;
      this.#onFrame({ ...tracked, frame });
    } catch (error) {
      if (!this.#stopped) this.#onError(error);
    } finally {
      frame?.close();
      this.#busy = false;
    }
    if (this.#newest !== null && !this.#stopped) this.#track(this.#newest);
  }

  #ask(ask, message = {}, transfer = []) {
    if (this.#stopped) return Promise.reject(stopped());
    const id = ++this.#asked;
    this.#worker.postMessage({ ask, id, ...message }, transfer);
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }

  #settle({ id, answer, error }) {
    const { resolve, reject } = this.#waiting.get(id);
    this.#waiting.delete(id);
    if (error === undefined) resolve(answer);
    else reject(new Error(error));
  }

  #fail(error) {
    for (const { reject } of this.#waiting.values()) reject(error);
    this.#waiting.clear();
  }
}
