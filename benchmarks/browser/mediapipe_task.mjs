// SPDX-License-Identifier: MIT
// MediaPipe's hand landmarker as its npm packages hold it. The runtime (tasks-vision) comes without
// its networks; they lie in the older package "hands": palm detection and hand landmarks, both full.
// Packed together, with the note on how pictures are scaled that the runtime asks for, they are the
// task file that it reads.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { Builder, ByteBuffer } from 'flatbuffers';

const hands = fileURLToPath(new URL('node_modules/@mediapipe/hands/', import.meta.url));

function list(fbb, offsets) {
  fbb.startVector(4, offsets.length, 4);
  for (const offset of [...offsets].reverse()) fbb.addOffset(offset);
  return fbb.endVector();
}

/** `fields`: by number, what writes them. */
function table(fbb, size, fields) {
  fbb.startObject(size);
  for (const [index, write] of Object.entries(fields)) write(Number(index));
  return fbb.endObject();
}

/** TensorFlow Lite's metadata: colours from 0 to 255 become 0 to 1. */
function scalingNote() {
  const fbb = new Builder(256);
  const refer = (offset) => (field) => fbb.addFieldOffset(field, offset, 0);
  const number = (value) => {
    fbb.startVector(4, 1, 4);
    fbb.addFloat32(value);
    return fbb.endVector();
  };
  const mean = number(0), deviation = number(255);
  const scaling = table(fbb, 2, { 0: refer(mean), 1: refer(deviation) });
  const unit = table(fbb, 2, { 0: (field) => fbb.addFieldInt8(field, 1, 0), 1: refer(scaling) });
  const units = list(fbb, [unit]);
  const inputs = list(fbb, [table(fbb, 7, { 4: refer(units) })]);
  const graphs = list(fbb, [table(fbb, 5, { 2: refer(inputs) })]);
  fbb.finish(table(fbb, 8, { 3: refer(graphs) }), 'M001');
  return fbb.asUint8Array();
}

/** The model with a note: the old one at the end of a file whose new first table refers to its parts. */
function withNote(model, note) {
  const length = 16 * Math.ceil(model.length / 16);
  const fbb = new Builder(length + 65536);
  fbb.space -= length;
  fbb.bb.bytes().set(model, fbb.space);
  fbb.minalign = 16;

  const old = new ByteBuffer(model);
  const root = old.readInt32(0);
  const field = (index) => root + old.__offset(root, 4 + 2 * index);
  const kept = (at) => length - (at + old.readInt32(at));  // what the reference at `at` refers to
  const buffers = field(4) + old.readInt32(field(4));
  const count = old.readInt32(buffers);

  const refer = (offset) => (index) => fbb.addFieldOffset(index, offset, 0);
  fbb.startVector(1, note.length, 16);
  for (const byte of [...note].reverse()) fbb.addInt8(byte);
  const noteBuffer = table(fbb, 1, { 0: refer(fbb.endVector()) });
  const allBuffers = list(fbb,
    [...Array.from({ length: count }, (_, i) => kept(buffers + 4 + 4 * i)), noteBuffer]);
  const name = fbb.createString('TFLITE_METADATA');
  const entry = table(fbb, 2, { 0: refer(name), 1: (index) => fbb.addFieldInt32(index, count, 0) });
  const notes = list(fbb, [entry]);
  fbb.finish(table(fbb, 8, {
    0: (index) => fbb.addFieldInt32(index, old.readInt32(field(0)), 0),
    1: refer(kept(field(1))), 2: refer(kept(field(2))), 4: refer(allBuffers), 6: refer(notes) }), 'TFL3');
  return fbb.asUint8Array();
}

/** The bytes of hand_landmarker.task. */
export function handLandmarkerTask() {
  const packed = readFileSync(join(hands, 'hands_solution_packed_assets.data'));
  const [, start, end] = /palm_detection_full\.tflite", "start": (\d+), "end": (\d+)/.exec(
    readFileSync(join(hands, 'hands_solution_packed_assets_loader.js'), 'utf8'));
  const folder = mkdtempSync(join(tmpdir(), 'handyar-'));
  try {
    const note = scalingNote();
    const write = (file, model) => writeFileSync(join(folder, file), withNote(new Uint8Array(model), note));
    write('hand_detector.tflite', packed.subarray(Number(start), Number(end)));
    write('hand_landmarks_detector.tflite', readFileSync(join(hands, 'hand_landmark_full.tflite')));
    execFileSync('zip', ['-q', '-0', '-X', 'task.zip', 'hand_detector.tflite', 'hand_landmarks_detector.tflite'],
      { cwd: folder });
    return readFileSync(join(folder, 'task.zip'));
  } finally {
    rmSync(folder, { recursive: true });
  }
}
