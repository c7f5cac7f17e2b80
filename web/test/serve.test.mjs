// SPDX-License-Identifier: MIT
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { serve } from '../serve.mjs';

test('the page is served, and what is no file of it is not found', async () => {
  const server = await serve(fileURLToPath(new URL('../page', import.meta.url)));
  try {
    const answer = (path) => fetch(`http://127.0.0.1:${server.address().port}${path}`);
    for (const path of ['/none.js', '/%2e%2e/%2e%2e/package.json', '/%ff', '/%00', '//'])
      assert.equal((await answer(path)).status, 404, path);
    const page = await answer('/');
    assert.equal(page.status, 200);
    assert.match(await page.text(), /Hold up a hand/);
  } finally {
    server.close();
  }
});
