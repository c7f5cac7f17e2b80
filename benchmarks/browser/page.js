// SPDX-License-Identifier: MIT
// Runs in the browser: each tracker sees the same pictures, one tracker after the other.
import { FilesetResolver, HandLandmarker } from './node_modules/@mediapipe/tasks-vision/vision_bundle.mjs';
import { HandTracker } from './node_modules/handyar/src/handyar.js';

async function pictures(count) {
  return Promise.all(Array.from({ length: count }, async (_, i) => {
    const bitmap = await createImageBitmap(await (await fetch(`pictures/${String(i + 1).padStart(4, '0')}.png`)).blob());
    const pen = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d', { willReadFrequently: true });
    pen.drawImage(bitmap, 0, 0);
    return pen.getImageData(0, 0, bitmap.width, bitmap.height);
  }));
}

async function handyar() {
  const tracker = await HandTracker.create();
  return (picture, time_s) => tracker.process(picture, time_s).state === 'tracking';
}

async function mediapipe() {
  const files = await FilesetResolver.forVisionTasks('node_modules/@mediapipe/tasks-vision/wasm');
  const landmarker = await HandLandmarker.createFromOptions(files, {
    baseOptions: { modelAssetPath: 'hand_landmarker.task', delegate: 'CPU' }, runningMode: 'VIDEO', numHands: 1 });
  return (picture, time_s) => landmarker.detectForVideo(picture, 1000 * time_s).landmarks.length > 0;
}

/** Milliseconds of each picture, and in how many a hand was seen. */
window.measure = async (count) => {
  const film = await pictures(count);
  const seen = { handyar: 0, mediapipe: 0 }, ms = { handyar: [], mediapipe: [] };
  for (const [name, make] of Object.entries({ handyar, mediapipe })) {
    const track = await make();
    film.forEach((picture, i) => {
      const start_ms = performance.now();
      seen[name] += track(picture, i / 30);
      ms[name].push(performance.now() - start_ms);
    });
  }
  return { seen, ms };
};
