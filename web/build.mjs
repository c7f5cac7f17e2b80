// SPDX-License-Identifier: MIT
// Puts the page together in build/web: its own files, the npm packages handyar and three, a recorded
// hand. Any static server can then serve it.
import { createHash } from 'node:crypto';
import { cpSync, mkdirSync, readFileSync, readdirSync, realpathSync, rmSync, statSync, writeFileSync }
  from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const out = join(here, '../build/web');
const copy = (from, to) => {
  mkdirSync(dirname(join(out, to)), { recursive: true });
  cpSync(from, join(out, to), { recursive: true });
};

rmSync(out, { recursive: true, force: true });
copy(join(here, 'page'), '.');
const handyar = realpathSync(join(here, 'node_modules/handyar'));
for (const folder of ['src', 'dist']) copy(join(handyar, folder), `handyar/${folder}`);
const three = join(here, 'node_modules/three');
for (const file of ['build/three.module.js', 'build/three.core.js', 'LICENSE',
  'examples/jsm/loaders/GLTFLoader.js', 'examples/jsm/utils/BufferGeometryUtils.js',
  'examples/jsm/utils/SkeletonUtils.js', 'examples/jsm/geometries/TeapotGeometry.js'])
  copy(join(three, file), join('three', file));
copy(join(here, '../data/sample/video.mp4'), 'recorded_hand.mp4');

// The one script inside the page, its import map, is allowed by what it holds.
const index = join(out, 'index.html');
const html = readFileSync(index, 'utf8');
const [, importmap] = /<script type="importmap">(.*?)<\/script>/s.exec(html);
const digest = createHash('sha256').update(importmap).digest('base64');
writeFileSync(index, html.replace('sha256-IMPORTMAP', `sha256-${digest}`));

// The service worker keeps just these files, under a name that changes when one of them does.
const files = readdirSync(out, { recursive: true }).map((name) => join(out, name))
  .filter((path) => statSync(path).isFile() && !path.endsWith('.d.ts')).sort();
const version = createHash('sha256');
for (const file of files) version.update(readFileSync(file));
const kept = files.map((file) => relative(out, file)).filter((file) => file !== 'service_worker.js');
const service_worker = join(out, 'service_worker.js');
writeFileSync(service_worker, readFileSync(service_worker, 'utf8')
  .replace("'VERSION'", JSON.stringify(version.digest('hex').slice(0, 12)))
  .replace("['FILES']", JSON.stringify(['./', ...kept], null, 1)));
