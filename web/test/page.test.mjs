// SPDX-License-Identifier: MIT
// The page as a person meets it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { before, test } from 'node:test';

import { alongClip, data, program } from '../../bindings/wasm/test/clip.mjs';
import { artefact, cameraClip, note, poses, skip, withPage } from './browser.mjs';

const desktop = { viewport: { width: 1100, height: 700 }, colorScheme: 'dark' };
const phone = { viewport: { width: 360, height: 740 }, colorScheme: 'light', hasTouch: true, isMobile: true };

let camera;
const programs_m = [];  // where the program, if it is built, has the hand in the same clip
before(() => {
  if (skip) return;
  camera = cameraClip();
  if (!program) return;
  alongClip('sample/video.mp4', [], (_, row) => {
    if (row.tx_m) programs_m.push([row.tx_m, row.ty_m, row.tz_m].map(Number));
  });
});

/** Everything that can be pressed or read lies within the window. */
async function assertFits(page) {
  const outside = await page.evaluate(() =>
    [...document.querySelectorAll('section:not([hidden]), button, #said')].filter((element) => {
      const box = element.getBoundingClientRect();
      return box.width > 0 && (box.left < 0 || box.right > innerWidth || box.top < 0 || box.bottom > innerHeight);
    }).map((element) => element.id));
  assert.deepEqual(outside, []);
}

test('a hand before the camera is tracked', { skip }, () => withPage({ camera, ...desktop }, async (page) => {
  await page.screenshot({ path: artefact('welcome.png') });
  await note(page);
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');  // the first button starts the camera
  const tracked = await poses(page, 5);
  await page.screenshot({ path: artefact('desktop.png') });
  for (const T of tracked) {
    const off_m = Math.min(...programs_m.map((p) => Math.hypot(p[0] - T[12], p[1] - T[13], p[2] - T[14])));
    assert.ok(!program || off_m < 0.02, `the program has the hand ${off_m} m from here`);
    assert.ok(T[10] < -0.3, 'its visible face looks at the camera');
  }
  await page.keyboard.down('m');
  await page.waitForFunction(() => /^Thumb to index \d+ mm, \d+ cm away/.test(said.textContent));
  await page.keyboard.up('m');
  const download = page.waitForEvent('download');
  await page.keyboard.press('p');
  const picture = readFileSync(await (await download).path());
  assert.equal(picture.toString('latin1', 1, 4), 'PNG');
  assert.equal(await page.isVisible('#welcome'), false);
  await assertFits(page);
  await page.keyboard.press('Escape');
  await page.waitForSelector('#welcome:not([hidden])');
}));

test('a phone has room for it', { skip }, () => withPage({ camera, ...phone }, async (page) => {
  await assertFits(page);
  await page.screenshot({ path: artefact('phone_welcome.png') });
  await note(page);
  await page.tap('#start');
  await poses(page, 3);
  await page.screenshot({ path: artefact('phone.png') });
  await assertFits(page);
  await page.tap('#calibrate');
  await assertFits(page);
  await page.screenshot({ path: artefact('phone_calibration.png') });
  const { top, height } = await page.evaluate(() => ({
    top: document.getElementById('calibration').getBoundingClientRect().top, height: innerHeight }));
  assert.ok(top > 0.5 * height, `the panel leaves the upper half to the hand, but begins at ${top} of ${height}`);
}));

test('held sideways it leaves the middle to the hand', { skip }, () =>
  withPage({ camera, ...phone, viewport: { width: 740, height: 360 } }, async (page) => {
    await assertFits(page);
    await note(page);
    await page.tap('#start');
    await poses(page, 1);
    await assertFits(page);
    const from_x = (id) => page.evaluate((name) => document.getElementById(name).getBoundingClientRect().left, id);
    assert.ok(await from_x('tools') > 0.75 * 740);
    await page.tap('#calibrate');
    await assertFits(page);
    assert.ok(await from_x('calibration') > 0.5 * 740);
    await page.screenshot({ path: artefact('phone_sideways.png') });
  }));

test('a refused camera is told of', { skip }, () => withPage({ camera: 'refused' }, async (page) => {
  await page.click('#start');
  await page.waitForSelector('#fault:not([hidden])');
  assert.match(await page.textContent('#fault'), /refused.*Allow it/);
  await page.screenshot({ path: artefact('refused.png') });
}));

test('without a camera there is a recorded hand', { skip }, () => withPage({}, async (page) => {
  await page.click('#start');
  await page.waitForSelector('#fault:not([hidden])');
  assert.match(await page.textContent('#fault'), /No camera is connected.*recorded hand/);
  await note(page);
  await page.click('#watch');
  await poses(page, 3);
  assert.equal(await page.isVisible('#fault'), false);
}));

/** Lets the page wait for its camera until `window.giveCamera()`. */
const holdCamera = (page) => page.evaluate(() => {
  const devices = navigator.mediaDevices, give = devices.getUserMedia.bind(devices);
  devices.getUserMedia = (wanted) => new Promise((resolve) => {
    window.giveCamera = async () => {
      const stream = await give(wanted);
      resolve(stream);
      await new Promise((settled) => setTimeout(settled));
    };
  });
});

test('a recorded hand is watched by who does not answer for the camera', { skip }, () =>
  withPage({ camera }, async (page) => {
    await note(page);
    await holdCamera(page);
    await page.click('#start');
    await page.click('#watch');
    await poses(page, 3);
    await page.evaluate(() => window.giveCamera());
    await poses(page, 3);
    assert.equal(await page.isVisible('#welcome'), false);
  }));

test('what was stopped while it waited for another camera stays so', { skip }, () =>
  withPage({ camera }, async (page) => {
    await note(page);
    await page.click('#start');
    await poses(page, 1);
    await holdCamera(page);
    await page.click('#switch');
    await page.waitForFunction(() => window.giveCamera);
    await page.click('#stop');
    await page.evaluate(() => window.giveCamera());
    assert.equal(await page.isVisible('#welcome'), true);
  }));

test('hidden and shown again, it goes on', { skip }, () => withPage({ camera }, async (page) => {
  await note(page);
  await page.click('#start');
  await poses(page, 2);
  const devtools = await page.context().newCDPSession(page);
  await devtools.send('Page.setWebLifecycleState', { state: 'frozen' });
  await new Promise((resolve) => setTimeout(resolve, 2000));
  await devtools.send('Page.setWebLifecycleState', { state: 'active' });
  await poses(page, 2);
}));

test('a model of one’s own is dropped on the page', { skip }, () => withPage({}, async (page) => {
  const drop = (name, text) => page.evaluate(([file, content]) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([content], file));
    dispatchEvent(new DragEvent('drop', { dataTransfer, cancelable: true }));
  }, [name, text]);
  const corners = Buffer.from(new Float32Array([0, 0, 0, 2, 0, 0, 0, 1, 0]).buffer).toString('base64');
  const triangle = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [2, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    buffers: [{ byteLength: 36, uri: `data:application/octet-stream;base64,${corners}` }] };
  await drop('triangle.gltf', JSON.stringify(triangle));
  await page.waitForFunction(() => /triangle\.gltf stands on the hand/.test(said.textContent));
  await page.setInputFiles('#file', { name: 'chosen.gltf', mimeType: '', buffer: Buffer.from(JSON.stringify(triangle)) });
  await page.waitForFunction(() => /chosen\.gltf stands on the hand/.test(said.textContent));
  assert.equal(await page.inputValue('#file'), '', 'the same file can be chosen again');
  await drop('hand.json', '{}');
  await page.waitForFunction(() => /hand\.json: format is not handyar-hand/.test(said.textContent));
  await drop('camera.yml', 'image_width: 640');
  await page.waitForFunction(() => /camera\.yml: image_height is missing/.test(said.textContent));
  await drop('camera.yml', readFileSync(data('sample/camera.yml'), 'utf8'));
  await page.waitForFunction(() => /camera\.yml is the camera now/.test(said.textContent));
  await drop('letter.gltf', 'Dear Sir');
  await page.waitForFunction(() => /letter\.gltf cannot be shown: it is not glTF/.test(said.textContent));
}));

test('a hand is measured and remembered', { skip }, () => withPage({ camera }, async (page) => {
  await note(page);
  await page.click('#start');
  await poses(page, 1);
  await page.keyboard.press('h');
  await page.waitForSelector('#length:not([hidden])');
  await page.fill('#span_mm', '200');
  await page.screenshot({ path: artefact('calibration.png') });
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => localStorage.getItem('handyar-hand'));
  const hand = JSON.parse(await page.evaluate(() => localStorage.getItem('handyar-hand')));
  const { thumb, little } = hand.tips_m;
  assert.ok(Math.abs(Math.hypot(...thumb.map((x, i) => x - little[i])) - 0.2) < 1e-9);
  assert.deepEqual([hand.source, hand.scale], ['self', 'measured']);
  await poses(page, 2);
  assert.equal(await page.evaluate(async () => (await (await import('./page.js')).hand.hand()).scale), 'measured');
}));

test('lengths of a hand whose size is not known are not told as measured', { skip }, () =>
  withPage({ camera }, async (page) => {
    const measured = JSON.parse(readFileSync(data('sample/hand.json'), 'utf8'));
    for (const [scale, told] of [['average', /away \(if the hand is of average size\)$/], ['measured', /away$/]]) {
      await page.evaluate((text) => localStorage.setItem('handyar-hand', text),
        JSON.stringify({ ...measured, version: 2, source: 'self', scale }));
      await page.reload();
      await note(page);
      await page.click('#start');
      await poses(page, 1);
      await page.keyboard.down('m');
      await page.waitForFunction(() => /^Thumb to index/.test(said.textContent));
      assert.match(await page.textContent('#said'), told);
      await page.keyboard.up('m');
    }
  }));

test('it works without a network once it was opened', { skip }, () => withPage({ camera }, async (page) => {
  await page.evaluate(() => navigator.serviceWorker.ready);
  await page.context().setOffline(true);
  await page.reload();
  await note(page);
  await page.click('#start');
  await poses(page, 1);
}));
