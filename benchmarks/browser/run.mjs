// SPDX-License-Identifier: MIT
// Bytes shipped and milliseconds a picture in Chromium, beside MediaPipe's hand landmarker on the
// CPU, in turns on the shipped clip, and how long the built page (scripts/web) takes to show a
// tracked hand:
//   npm install && npm start
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, gzipSync } from 'node:zlib';

import { chromium } from 'playwright-core';

import { serve } from '../../web/serve.mjs';
import { cameraClip, note, poses, skip, withPage } from '../../web/test/browser.mjs';
import { handLandmarkerTask } from './mediapipe_task.mjs';

const PICTURES = 200, WARM_UP = 20, ROUNDS = 4;
const here = fileURLToPath(new URL('./', import.meta.url));
const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];

function sizes(name, parts) {
  const sum = (length) => parts.reduce((total, bytes) => total + length(bytes), 0);
  const kB = (bytes) => (bytes / 1000).toFixed(0).padStart(6);
  console.log(`${name.padEnd(40)} ${kB(sum((b) => b.length))} ${kB(sum((b) => gzipSync(b, { level: 9 }).length))}` +
    ` ${kB(sum((b) => brotliCompressSync(b).length))}`);
}

const task = handLandmarkerTask();
const own = (...paths) => paths.map((path) => readFileSync(join(here, '../../bindings/wasm', path)));
const theirs = (...paths) => paths.map((path) => readFileSync(join(here, 'node_modules/@mediapipe/tasks-vision', path)));
const core = ['dist/handyar.wasm', 'dist/layout.js', ...['handyar', 'memory', 'files', 'pose', 'live', 'worker']
  .map((name) => `src/${name}.js`)];
console.log('kB shipped                                  raw   gzip brotli');
sizes('handyar', own(...core));
sizes('handyar with the adapter for three.js', own(...core, 'src/three.js', 'src/anchor.js', 'src/hand_surface.js'));
sizes('MediaPipe: script and runtime', theirs('vision_bundle.mjs', 'wasm/vision_wasm_internal.js', 'wasm/vision_wasm_internal.wasm'));
sizes('MediaPipe: networks', [task]);

const folder = mkdtempSync(join(tmpdir(), 'handyar-'));
for (const name of ['page.html', 'page.js', 'node_modules']) symlinkSync(join(here, name), join(folder, name));
writeFileSync(join(folder, 'hand_landmarker.task'), task);
mkdirSync(join(folder, 'pictures'));
execFileSync('ffmpeg', ['-v', 'error', '-i', join(here, '../../data/sample/video.mp4'), '-frames:v', String(PICTURES),
  join(folder, 'pictures/%04d.png')]);
const server = await serve(folder);
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox'] });
try {
  const page = await browser.newPage();
  page.on('pageerror', (error) => console.error(error.message));
  await page.goto(`http://localhost:${server.address().port}/page.html`);
  await page.waitForFunction(() => window.measure);
  const rounds = [];
  for (let i = 0; i < ROUNDS; ++i) rounds.push(await page.evaluate((count) => window.measure(count), PICTURES));
  console.log(`\nms a picture of 640x480, ${PICTURES} pictures    least   medians of ${ROUNDS} rounds       hand seen`);
  for (const name of ['handyar', 'mediapipe']) {
    const warm = rounds.map(({ ms }) => ms[name].slice(WARM_UP));
    const medians = warm.map(median).sort((a, b) => a - b).map((ms) => ms.toFixed(1).padStart(6)).join(' ');
    console.log(`${name.padEnd(38)} ${Math.min(...warm.flat()).toFixed(1).padStart(6)}   ${medians}` +
      `   ${Math.min(...rounds.map(({ seen }) => seen[name]))}`);
  }
} finally {
  await browser.close();
  server.close();
  rmSync(folder, { recursive: true });
}

if (skip) {
  console.log(`\nThe page was not timed: ${skip}`);
} else {
  await withPage({ camera: cameraClip() }, async (page) => {
    await page.evaluate(() => navigator.serviceWorker.ready);
    await page.reload();  // from the service worker
    await note(page);
    const start_ms = performance.now();
    await page.click('#start');
    await poses(page, 1);
    console.log(`\nFrom the button to a tracked hand: ${((performance.now() - start_ms) / 1000).toFixed(1)} s`);
  });
}
