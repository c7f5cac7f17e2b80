// SPDX-License-Identifier: MIT
// The built page in Debian's Chromium, whose camera shows a clip over and over.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

import { chromium } from 'playwright-core';

import { serve } from '../serve.mjs';

const built = fileURLToPath(new URL('../../build/web', import.meta.url));
const out = fileURLToPath(new URL('../../build/web_test/', import.meta.url));
const executablePath = ['/usr/bin/chromium', '/usr/bin/google-chrome'].find(existsSync);

export const skip = !executablePath ? 'chromium is not installed'
  : !existsSync(built) ? 'the page is not built' : false;

/** Where a picture of a test is kept, to be looked at. */
export function artefact(name) {
  mkdirSync(out, { recursive: true });
  return out + name;
}

/** The shipped clip as Chromium's fake camera reads it. */
export function cameraClip() {
  const clip = artefact('camera.mjpeg');
  const video = fileURLToPath(new URL('../../data/sample/video.mp4', import.meta.url));
  execFileSync('ffmpeg', ['-v', 'error', '-y', '-i', video, '-q:v', '2', '-f', 'mjpeg', clip]);
  return clip;
}

/**
 * Opens the page and calls `use`; fails on any error in the console and on any request to elsewhere.
 * `camera`: a clip, 'refused', or null: none is connected.
 */
export async function withPage({ camera = null, ...context_options }, use) {
  const server = await serve(built);
  const origin = `http://localhost:${server.address().port}`;
  const clip = camera !== 'refused' ? camera : null;
  const browser = await chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
      ...(camera === 'refused' ? ['--deny-permission-prompts'] : ['--use-fake-ui-for-media-stream']),
      ...(clip || camera === 'refused' ? ['--use-fake-device-for-media-stream'] : []),
      ...(clip ? [`--use-file-for-fake-video-capture=${clip}`] : [])] });
  const faults = [];
  try {
    const context = await browser.newContext(context_options);
    const page = await context.newPage();
    page.setDefaultTimeout(90_000);
    page.on('pageerror', (error) => faults.push(error.message));
    page.on('console', (message) => { if (message.type() === 'error') faults.push(message.text()); });
    context.on('request', (request) => {
      const url = request.url();
      if (!url.startsWith(`${origin}/`) && !/^(blob|data):/.test(url)) faults.push(`request to ${url}`);
    });
    await page.goto(`${origin}/`);
    await use(page);
  } finally {
    await browser.close();
    server.close();
  }
  if (faults.length) throw new Error(faults.join('\n'));
}

/** Begins to note what the page tracks: poses, column by column, in `noted.poses` of the page. */
export async function note(page) {
  await page.evaluate(async () => {
    const { hand } = await import('./page.js');
    const goOn = hand.onUpdate;
    window.noted = { poses: [], pictures: 0 };
    hand.onUpdate = (tracked) => {
      const { pose, doubtful } = tracked.result;
      ++window.noted.pictures;
      if (pose && !doubtful) window.noted.poses.push([...pose.T_camera_hand]);
      goOn(tracked);
    };
  });
}

/** Waits until `count` more pictures show a tracked hand; returns their poses. */
export async function poses(page, count) {
  await page.evaluate(() => { window.noted.poses.length = 0; });
  await page.waitForFunction((wanted) => window.noted.poses.length >= wanted, count);
  return page.evaluate(() => window.noted.poses);
}
