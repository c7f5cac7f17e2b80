// SPDX-License-Identifier: MIT
// A shipped clip as pictures, and what the program says of just these pictures.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('../../../', import.meta.url));
export const data = (path) => join(root, 'data', path);

/** The program that the poses are compared with. */
export const program = [process.env.HANDYAR_PROGRAM, 'build/dev/apps/handyar/handyar',
  'build/release/apps/handyar/handyar'].filter(Boolean)
  .map((path) => join(path.startsWith('/') ? '' : root, path)).find(existsSync);

/** An RGBA picture from a binary PPM. */
function readPicture(path) {
  const file = readFileSync(path);
  const [header, width, height] = /^P6\s+(\d+)\s+(\d+)\s+255\s/.exec(file.toString('latin1', 0, 40));
  const data = new Uint8ClampedArray(4 * width * height).fill(255);
  for (let from = header.length, to = 0; to < data.length; from += 3, to += 4)
    data.set(file.subarray(from, from + 3), to);
  return { data, width: Number(width), height: Number(height) };
}

function readTable(path) {
  const [names, ...rows] = readFileSync(path, 'utf8').trim().split('\n').map((line) => line.split(','));
  return rows.map((row) => Object.fromEntries(row.map((field, i) => [names[i], field])));
}

/**
 * Calls `look` with each picture of a clip and the row of poses.csv that `handyar track` writes of
 * it with `options`.
 */
export function alongClip(clip, options, look) {
  const folder = mkdtempSync(join(tmpdir(), 'handyar-'));
  try {
    execFileSync('ffmpeg', ['-v', 'error', '-i', data(clip), join(folder, '%04d.ppm')]);
    const poses = join(folder, 'poses.csv');
    execFileSync(program, ['track', join(folder, '%04d.ppm'), '--poses', poses, '--no-timings', ...options],
      { stdio: ['ignore', 'ignore', 'pipe'] });
    for (const row of readTable(poses)) {
      const name = String(Number(row.frame) + 1).padStart(4, '0') + '.ppm';
      look(readPicture(join(folder, name)), row);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
}
