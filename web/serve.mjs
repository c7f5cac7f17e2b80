// SPDX-License-Identifier: MIT
// A static server for this machine:   node serve.mjs [PORT]
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize, sep } from 'node:path';
import { fileURLToPath } from 'node:url';

const types = {
  '.html': 'text/html; charset=utf-8', '.css': 'text/css', '.js': 'text/javascript', '.mjs': 'text/javascript', '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm', '.mp4': 'video/mp4', '.webmanifest': 'application/manifest+json' };

/** Serves the folder to this machine alone; port 0: any that is free. */
export function serve(folder, port = 0) {
  const server = createServer(async (request, response) => {
    try {
      const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
      const file = join(folder, path.endsWith(sep) ? join(path, 'index.html') : path);
      const body = await readFile(file);
      response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream' }).end(body);
    } catch {
      response.writeHead(404).end('not found');
    }
  });
  return new Promise((resolve, reject) => {
    server.once('error', reject);
    server.listen(port, '127.0.0.1', () => resolve(server));
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const port = Number(process.argv[2] ?? 8000);
  const server = await serve(fileURLToPath(new URL('../build/web', import.meta.url)), port)
    .catch((error) => {
      console.error(`port ${process.argv[2] ?? port} cannot be served at: ${error.message}`);
      process.exit(1);
    });
  console.log(`The page is at http://localhost:${server.address().port}/ (Ctrl-C ends it)`);
}
