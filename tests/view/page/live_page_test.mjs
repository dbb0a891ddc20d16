// SPDX-License-Identifier: MIT
// The page of `limber run --view` as a reader sees it, in a headless browser.
//   node live_page_test.mjs LIMBER FOLDER [--full]     the program, and what make_recording.cmake made; 20 minutes, not 5
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { openBrowser } from '../../../scripts/headless_browser.mjs';

const [limber, folder] = process.argv.slice(2, 4).map((name) => resolve(name));
const MINUTES = process.argv[4] === '--full' ? 20 : 5;
const RECORDING = join(folder, 'images');
const FRAMES = 41;
let browser, out, run, url, page, file;  // one run, through which the tests go in order
const complaints = [];

/** A run with its page; `ended` resolves to the exit code. */
function startRun(name, ...more) {
  const child = spawn(limber, ['run', RECORDING, '--out', join(out, name), '--view', ...more], { stdio: ['ignore', 'ignore', 'pipe'] });
  const ended = new Promise((done) => child.on('close', done));
  const begun = new Promise((done, fail) => {
    let text = '';
    child.stderr.on('data', (data) => {
      text += data;
      const found = text.match(/live view: (http:\S+)/);
      if (found) {
        done(found[1]);
      }
    });
    ended.then(() => fail(new Error(`no page: ${text}`)));
  });
  return { child, ended, begun };
}

const shown = () => page.evaluate(() => window.limberView.page.shown?.n ?? 0);
const shows = (number) => page.waitForFunction((n) => document.getElementById('place').textContent.startsWith(`frame ${n} of`), number);

before(async () => {
  out = mkdtempSync(join(tmpdir(), 'limber-view-'));
  run = startRun('paused', '--view-paused');
  url = await run.begun;
  browser = await openBrowser({ viewport: { width: 1280, height: 900 }, colorScheme: 'light' });
  browser.context.on('request', (request) => {
    if (!request.url().startsWith(url) && request.url() !== file && !/^(data|blob):/.test(request.url())) {
      complaints.push(`asked for ${request.url().slice(0, 200)}`);
    }
  });
  browser.context.on('console', (message) => {
    if (message.type() === 'error') {
      complaints.push(`console: ${message.text()}`);
    }
  });
  browser.context.on('weberror', (error) => complaints.push(`error: ${error.error().message}`));
  page = await browser.context.newPage();
  await page.goto(url);
});
after(async () => {
  run.child.kill();
  await browser.close();
  rmSync(out, { recursive: true, force: true });
});

test('a paused run shows its first frame, and each step one more', async () => {
  await shows(1);
  assert.match(await page.title(), /images, lcekf/);
  assert.equal(await page.textContent('#pause'), 'Run');
  for (let n = 2; n <= 4; ++n) {
    await page.click('#step');
    await shows(n);
  }
  assert.equal(await shown(), 4);
  assert.match(await page.textContent('#state'), /start: /);
});

test('a run that is let go comes to its end, and says so', async () => {
  await page.click('#pause');
  await page.waitForFunction(() => !document.getElementById('message').hidden, null, { timeout: 60_000 });
  await shows(FRAMES);
  assert.match(await page.textContent('#message'), new RegExp(`Done: ${FRAMES} of ${FRAMES} frames`));
  assert.equal(await page.textContent('#connection'), 'the run is over');
  assert.equal(await page.isVisible('#pause'), false);
});

test('pictures show images with points on them, and space shows path and map', async () => {
  const drawn = await page.evaluate(() => ['left', 'right'].map((id) => {
    const canvas = document.getElementById(id);
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let grey = 0, green = 0;
    for (let k = 0; k < data.length; k += 4) {
      const [r, g, b, a] = data.slice(k, k + 4);
      grey += a === 255 && r === g && g === b;
      green += g > r + 60 && g > b + 40;
    }
    return { share: grey / (data.length / 4), green };
  }));
  for (const { share, green } of drawn) {
    assert.ok(share > 0.5 && green > 100, JSON.stringify(drawn));
  }
  const space = await page.evaluate(() => {
    const { path, map } = window.limberView.page.space;
    return { path: path.geometry.drawRange.count, map: map.geometry.drawRange.count };
  });
  assert.ok(space.path >= FRAMES - 1, JSON.stringify(space));  // all of it, although frames were left out
  assert.ok(space.map > 10, JSON.stringify(space));
});

test('verdict, calibration, state and times are there', async () => {
  assert.match(await page.textContent('#verdict strong'), /^(ok|degraded|decalibrated|cannot tell)$/);
  assert.equal(await page.locator('.gauge').count(), 10);
  assert.match(await page.textContent('#state'), /updated, inputs sound/);
  assert.deepEqual(await page.locator('.bars > span:first-child, .bars > span:nth-child(3n+1)').allTextContents(),
    ['read images', 'track points', 'filter', await page.textContent('.bars .sum')]);
});

test('the slider goes back to frames that were, and Newest returns', async () => {
  await page.fill('#seek', '1');
  await shows(await page.evaluate(() => window.limberView.page.history.frames[1].n));
  assert.equal(await page.getAttribute('#newest', 'aria-pressed'), 'false');
  await page.click('#newest');
  await shows(FRAMES);
});

test('light and dark', async () => {
  const paper = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  assert.equal(await paper(), 'rgb(255, 255, 255)');
  await page.click('#theme');
  assert.equal(await paper(), 'rgb(20, 23, 26)');
  await page.click('#theme');
});

test('nothing is wider than a phone', async () => {
  const phone = await browser.context.newPage();
  await phone.setViewportSize({ width: 360, height: 740 });
  await phone.goto(url);
  await phone.waitForFunction(() => document.getElementById('place').textContent !== '');
  assert.ok(await phone.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth));
  await phone.close();
});

test(`${MINUTES} minutes of 20 Hz do not make the page grow`, async () => {
  const other = await browser.context.newPage();
  await other.goto(url);
  await other.waitForFunction(() => window.limberView.page.shown);
  const last = 99 + MINUTES * 60 * 20;
  const kept = await other.evaluate(async (end) => {
    const { page: view } = window.limberView;
    const picture = 'A'.repeat(60_000);
    const pixels = btoa('\0'.repeat(16 * 120)), places = btoa('\0'.repeat(12 * 120));
    const sizes = [];
    for (let n = 100; n <= end; ++n) {
      const ids = Array.from({ length: 120 }, (_, k) => n + k);
      view.add({
        n, t: 0.05 * n, p: [n, 0, 0], q: [1, 0, 0, 0], status: 'updated', stages: [], health: null, images: [picture + n, picture + n],
        points: { ids, fates: 'u'.repeat(120), uv: pixels }, map: { ids, p: places },
      });
      if (n % 2000 === 0) {
        sizes.push(performance.memory.usedJSHeapSize);
      }
      if (n % 500 === 0) {
        await new Promise((done) => setTimeout(done));  // garbage is collected between turns
      }
    }
    return {
      frames: view.history.frames.length, images: view.history.frames.filter((frame) => frame.images).length, path: view.path.size,
      map: view.formerMap.places.size, oldest: view.history.frames[0].n, newest: view.shown.n, megabytes: sizes.map((size) => size / 1e6),
    };
  }, last);
  assert.equal(kept.newest, last);
  assert.ok(kept.frames <= 360 && kept.images <= 120 && kept.path <= 4096 && kept.map <= 6000, JSON.stringify(kept));
  assert.ok(Math.max(...kept.megabytes) < 150, JSON.stringify(kept));
  await other.close();
});

test('the recorded page plays without a server', async () => {
  const again = spawnSync(limber, ['run', RECORDING, '--out', join(out, 'recorded'), '--view-out', join(out, 'view.html')]);
  assert.equal(again.status, 0, String(again.stderr));
  const recorded = await browser.context.newPage();
  file = `file://${join(out, 'view.html')}`;
  await recorded.goto(file);
  const stands = (n) => recorded.waitForFunction((text) => document.getElementById('place').textContent.startsWith(text), `frame ${n} of`);
  await stands(FRAMES);  // it opens on what the run came to
  assert.match(await recorded.textContent('#message'), /^Done: /);
  assert.match(await recorded.textContent('#verdict strong'), /^(ok|degraded|decalibrated|cannot tell)$/);
  await recorded.fill('#seek', '0');
  await stands(1);
  await recorded.click('#step');
  await stands(2);
  await recorded.click('#pause');
  await stands(FRAMES);
  await recorded.waitForFunction(() => document.getElementById('pause').textContent === 'Play');
  const frames = await recorded.evaluate(() => window.limberView.page.history.frames.map(({ n, images }) => [n, images !== null]));
  assert.deepEqual(frames, Array.from({ length: FRAMES }, (_, k) => [k + 1, true]));
  await recorded.close();
});

test('Done ends the program, and the page says so', async () => {
  await page.click('#dismiss');
  assert.equal(await run.ended, 0);
  await page.waitForFunction(() => document.getElementById('connection').textContent === 'the program has ended');
});

test('nothing was asked of others, and no error was logged', () => {
  assert.deepEqual(complaints, []);
});
