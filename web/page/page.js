// SPDX-License-Identifier: MIT
import { readCamera, readHand } from 'handyar';
import { HandThree } from 'handyar/three';
import { Vector3 } from 'three';

import { Turning, keepHand, keptHand, measuredHand, span_m } from './calibration.js';
import { modelFrom, teapot } from './model.js';
import { Teller, cameraFault } from './words.js';

const $ = (id) => document.getElementById(id);
const stage = $('stage');

export const hand = new HandThree({ container: stage, hand: keptHand() });
const stand = hand.addAnchor('face'), thumb = hand.addAnchor('thumb_tip'), index = hand.addAnchor('index_tip');
stand.group.add(teapot());
const canvas = hand.renderer.domElement;

let mixer = null;       // of a model that moves
let teller = new Teller();
let runs = 0;           // how often something was begun or ended
let recorded = false;   // a recorded hand is watched
let recorded_url = null;
let measuring = false;
let turning = null;     // while the hand is calibrated
let notice = { text: '', until_ms: 0 };

function say(text) {
  if ($('said').textContent !== text) $('said').textContent = text;
}

/** Says something for a while, over what is said of the pictures. */
function tell(text, seconds = 4) {
  notice = { text, until_ms: performance.now() + 1000 * seconds };
  say(text);
}

// --- Camera on and off

function show(running) {
  $('welcome').hidden = running;
  closeCalibration();
  say('');
}

/** `begin` gets a function that tells whether nothing else was begun, or all ended, since. */
async function start(begin) {
  const run = ++runs, current = () => run === runs;
  hand.stop();
  $('fault').hidden = true;
  teller = new Teller();
  try {
    say('Starting…');
    await begin(current);
    if (!current()) return;
    show(true);
    mirror(!recorded && hand.facing === 'user');
  } catch (error) {
    if (current()) fail(error);
  }
}

function fail(error) {
  show(false);
  $('fault').textContent = cameraFault(error);
  $('fault').hidden = false;
}

function startCamera() {
  recorded = false;
  return start(() => hand.start());
}

function watchRecorded() {
  recorded = true;
  return start(async (current) => {
    recorded_url ??= URL.createObjectURL(await (await fetch('recorded_hand.mp4')).blob());
    if (current()) await hand.start(recorded_url);
  });
}

async function switchCamera() {
  await hand.setCamera(null);  // a file that was dropped is of one camera
  return start(() => hand.switchCamera());
}

function stop() {
  ++runs;
  hand.stop();
  show(false);
}

function mirror(mirrored) {
  stage.classList.toggle('mirrored', mirrored);
  $('mirror').setAttribute('aria-pressed', mirrored);
}

// Drawn when a picture came, and not more often: what moves moves with the pictures.
hand.onUpdate = ({ result }) => {
  mixer?.setTime(performance.now() / 1000);
  hand.renderer.render(hand.scene, hand.camera);
  drawRuler(result);
  turning?.take(result);
  if (turning) sayCalibration();
  if (performance.now() > notice.until_ms) say(teller.say(result, recorded));
};
hand.onError = (error) => (error.name === 'NotReadableError' ? fail(error) : tell(error.message));

// --- The model

async function takeHand(file) {
  const measured = readHand(await file.text(), file.name);
  keepHand(measured);
  await hand.setHand(measured);
  tell(`${file.name} is your hand now.`);
}

async function takeCamera(file) {
  await hand.setCamera(readCamera(await file.text(), file.name));
  tell(`${file.name} is the camera now.`);
}

/** A file that was chosen or dropped: a model, a hand that was measured, or a camera. */
async function take(file) {
  try {
    if (file.name.endsWith('.json')) return await takeHand(file);
    if (/\.ya?ml$/.test(file.name)) return await takeCamera(file);
    const { model, mixer: moves } = await modelFrom(file);
    mixer = moves;
    stand.group.clear();
    stand.group.add(model);
    tell(`${file.name} stands on the hand.`);
  } catch (error) {
    tell(error.message, 8);
  }
}

// --- Measuring

function measure(on) {
  measuring = on;
  if (on && !(thumb.followed && index.followed)) tell('Hold up the hand that is to be measured.');
}

/** Where a point of the scene is on the page. */
function onPage(point) {
  const { x, y } = point.clone().applyMatrix4(hand.camera.projectionMatrix);
  const { width, height } = canvas, box = stage.getBoundingClientRect();
  const scale = Math.max(box.width / width, box.height / height);  // object-fit: cover
  const flip = stage.classList.contains('mirrored') ? -1 : 1;
  return { x: box.width / 2 + flip * x * width * scale / 2, y: box.height / 2 - y * height * scale / 2 };
}

function drawRuler({ scale_assumed }) {
  const shown = measuring && thumb.followed && index.followed;
  $('ruler').toggleAttribute('hidden', !shown);
  if (!shown) return;
  const from = thumb.group.position, to = index.group.position;
  const a = onPage(from), b = onPage(to), line = $('ruler').firstElementChild;
  Object.entries({ x1: a.x, y1: a.y, x2: b.x, y2: b.y }).forEach(([key, x]) => line.setAttribute(key, x));
  const apart_mm = Math.round(1000 * from.distanceTo(to));
  const away_cm = Math.round(100 * stand.group.position.distanceTo(new Vector3()));
  const assumed = scale_assumed ? ' (if the hand is of average size)' : '';
  tell(`Thumb to index ${apart_mm} mm, ${away_cm} cm away${assumed}`, 2);
}

// --- The person's hand

function openCalibration() {
  turning = new Turning();
  $('calibration').hidden = false;
  $('tools').hidden = true;
  $('length').hidden = true;
  $('save_hand').hidden = !keptHand();
  sayCalibration();
}

function closeCalibration() {
  turning = null;
  $('calibration').hidden = true;
  $('tools').hidden = $('welcome').hidden === false;
}

async function sayCalibration() {
  const { done } = turning;
  $('turned').value = done;
  if (done < 1) {
    $('calibration_said').textContent =
      'Spread the fingers, keep the hand stiff and turn it slowly left, right, up and down.';
  } else if ($('length').hidden) {
    $('length').hidden = false;
    $('calibration_said').textContent = 'Its shape is learned. One length gives it its size.';
    $('span_mm').value = Math.round(1000 * span_m(await hand.hand()));
    $('span_mm').select();
  }
}

async function takeLength() {
  const measured = measuredHand(await hand.hand(), $('span_mm').valueAsNumber / 1000);
  keepHand(measured);
  await hand.setHand(measured);
  closeCalibration();
  tell('This is your hand now: lengths are its own.');
}

async function forgetHand() {
  keepHand(null);
  await hand.setHand(null);
  closeCalibration();
  tell('The hand is taken to be of average size.');
}

// --- Pictures and files

function save(blob, name) {
  const link = Object.assign(document.createElement('a'), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

async function sharePicture() {
  hand.renderer.render(hand.scene, hand.camera);
  const picture = new OffscreenCanvas(canvas.width, canvas.height), pen = picture.getContext('2d');
  if (stage.classList.contains('mirrored')) pen.setTransform(-1, 0, 0, 1, canvas.width, 0);
  pen.drawImage(canvas, 0, 0);
  const file = new File([await picture.convertToBlob({ type: 'image/png' })], 'handyar.png', { type: 'image/png' });
  if (navigator.canShare?.({ files: [file] })) await navigator.share({ files: [file] }).catch(() => {});
  else save(file, file.name);
}

// --- Buttons and keys

const actions = {
  start: startCamera, watch: watchRecorded, stop, switch: switchCamera, picture: sharePicture,
  mirror: () => mirror(!stage.classList.contains('mirrored')),
  model: () => $('file').click(),
  calibrate: () => (turning ? closeCalibration() : openCalibration()),
  forget_hand: forgetHand, close_calibration: closeCalibration,
  save_hand: () => save(new Blob([JSON.stringify(keptHand(), null, 1)]), 'hand.json'),
};
for (const [id, action] of Object.entries(actions)) $(id).addEventListener('click', action);

$('length').addEventListener('submit', (event) => {
  event.preventDefault();
  takeLength();
});
$('file').addEventListener('change', ({ target }) => {
  const [file] = target.files;
  if (file) take(file);
  target.value = '';  // so that the same file, which may have changed, can be chosen again
});

$('measure').addEventListener('pointerdown', () => measure(true));
for (const end of ['pointerup', 'pointercancel', 'blur']) addEventListener(end, () => measure(false));

const keys = {
  f: 'mirror', c: 'switch', o: 'model', h: 'calibrate', p: 'picture', Escape: 'stop' };
const turns_rad = {
  ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };

addEventListener('keydown', (event) => {
  if (!$('welcome').hidden || event.ctrlKey || event.metaKey || event.altKey || event.target.matches('input')) return;
  const onMeasure = event.target.id === 'measure' && (event.key === ' ' || event.key === 'Enter');
  if (event.key === 'm' || onMeasure) measure(true);
  else if (turns_rad[event.key]) stand.turn(...turns_rad[event.key]);
  else if (event.key === 'Escape' && turning) closeCalibration();
  else if (keys[event.key] && !event.repeat) actions[keys[event.key]]();
});
addEventListener('keyup', () => measure(false));

addEventListener('dragover', (event) => {
  event.preventDefault();
  document.body.classList.add('dropping');
});
for (const end of ['dragleave', 'drop']) addEventListener(end, () => document.body.classList.remove('dropping'));
addEventListener('drop', (event) => {
  event.preventDefault();
  if (event.dataTransfer.files.length) take(event.dataTransfer.files[0]);
});

navigator.serviceWorker?.register('service_worker.js');
