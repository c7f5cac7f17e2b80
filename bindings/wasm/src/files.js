// SPDX-License-Identifier: MIT
// Camera and hand files (docs/formats.md of the project), checked before anything is made of them.
// Every fault is an Error of one line that names the file.

const FINGERS = ['thumb', 'index', 'middle', 'ring', 'little'];
const SOURCES = ['checkerboard', 'default', 'self', 'truth'];
const FIGURE_MODES = 12;
const MOST_THICKNESS_m = 0.1;

const isFinite = (x) => Number.isFinite(x);
const isPoint = (p) => Array.isArray(p) && p.length === 3 && p.every(isFinite);

/** A camera from the text of a YAML file as OpenCV and ROS write it. */
export function readCamera(text, name = 'camera.yml') {
  const fail = (fault) => { throw new Error(`${name}: ${fault}`); };
  const number = (key) => {
    const found = new RegExp(`^${key}\\s*:\\s*(\\S+)`, 'm').exec(text);
    if (!found) fail(`${key} is missing`);
    return isFinite(Number(found[1])) ? Number(found[1]) : fail(`${key} is not a number`);
  };
  const numbers = (key, count) => {
    const found = new RegExp(`^${key}\\s*:[^\\[]*?data\\s*:\\s*\\[([^\\]]*)\\]`, 'm').exec(text);
    if (!found) fail(`${key} is missing`);
    const list = found[1].split(',').map((word) => word.trim() === '' ? NaN : Number(word));
    if (!list.every(isFinite)) fail(`${key} holds something that is not a number`);
    if (!count.includes(list.length)) fail(`${key} has ${list.length} numbers`);
    return list;
  };
  const size = (key) => {
    const px = number(key);
    return Number.isInteger(px) && px > 0 ? px : fail(`${key} is not a whole number above 0`);
  };
  const width_px = size('image_width'), height_px = size('image_height');
  const K = numbers('camera_matrix', [9]);
  const model = /^distortion_model[ \t]*:[ \t]*["']?([^\s"']*)/m.exec(text)?.[1] || 'plumb_bob';
  if (model !== 'plumb_bob' && model !== 'rational_polynomial')
    fail(`distortion_model ${model} is not supported, only plumb_bob`);
  const distortion = numbers('distortion_coefficients', [4, 5, 8]);
  if (distortion.slice(5).some((k) => k !== 0)) fail('distortion_coefficients: only five may be in use');
  const assumed = /^assumed\s*:/m.test(text) ? number('assumed') : 0;
  if (assumed !== 0 && assumed !== 1) fail('assumed must be 0 or 1');
  const camera = {
    width_px, height_px, fx_px: K[0], fy_px: K[4], cx_px: K[2], cy_px: K[5],
    distortion: [...distortion, 0].slice(0, 5), assumed: assumed === 1 };
  if (!(camera.fx_px > 0 && camera.fy_px > 0)) fail('a focal length is not positive');
  const inside = (c, size) => c >= -0.5 && c <= size - 0.5;
  if (!inside(camera.cx_px, width_px) || !inside(camera.cy_px, height_px))
    fail('the principal point lies outside the picture');
  return camera;
}

/** A hand from the text of a JSON file; the hand is what the file holds. */
export function readHand(text, name = 'hand.json') {
  const fail = (fault) => { throw new Error(`${name}: ${fault}`); };
  let hand;
  try {
    hand = JSON.parse(text);
  } catch {
    fail('is not JSON');
  }
  if (hand?.format !== 'handyar-hand') fail('format is not handyar-hand');
  if (![1, 2, 3, 4].includes(hand.version)) fail(`version ${hand.version} is not known, only 1 to 4`);
  if (hand.layout !== 'thumb_right' && hand.layout !== 'thumb_left')
    fail('layout is neither thumb_right nor thumb_left');
  if (!SOURCES.includes(hand.source)) fail(`source is none of ${SOURCES.join(', ')}`);
  for (const finger of FINGERS)
    if (!isPoint(hand.tips_m?.[finger])) fail(`tips_m: ${finger} is not [x, y, z]`);
  const thumb = hand.tips_m.thumb, little = hand.tips_m.little;
  const span_mm = Math.round(1000 * Math.hypot(...thumb.map((x, k) => x - little[k])));
  if (span_mm < 50 || span_mm > 350)
    fail(`tips_m: thumb and little finger are ${span_mm} mm apart, a hand has 50 to 350 mm`);
  if ((thumb[0] > little[0]) !== (hand.layout === 'thumb_right'))
    fail(`layout is ${hand.layout}, but the thumb is on the other side`);
  if (hand.tips_sigma_m)
    for (const finger of FINGERS) {
      if (!isPoint(hand.tips_sigma_m[finger])) fail(`tips_sigma_m: ${finger} is not [x, y, z]`);
      if (hand.tips_sigma_m[finger].some((sigma) => sigma < 0)) fail('tips_sigma_m: a deviation is negative');
    }
  if (![undefined, 'measured', 'average'].includes(hand.scale)) fail('scale is neither measured nor average');
  const thickness_m = hand.thickness_m ?? 0;
  if (!(isFinite(thickness_m) && thickness_m >= 0 && thickness_m <= MOST_THICKNESS_m))
    fail('thickness_m is not a number from 0 to 0.1');
  if (hand.figure) {
    const isRow = (row) => Array.isArray(row) && row.length === FIGURE_MODES && row.every(isFinite);
    const { mean, covariance } = hand.figure;
    if (!isRow(mean) || covariance?.length !== FIGURE_MODES || !covariance.every(isRow))
      fail(`figure: mean and covariance are not of ${FIGURE_MODES} modes`);
  }
  return hand;
}
