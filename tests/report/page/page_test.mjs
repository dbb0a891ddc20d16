// SPDX-License-Identifier: MIT
// The pages as a reader sees them, in a headless browser.
//   node page_test.mjs FOLDER [--full]     FOLDER: what make_pages.cmake made
// What is drawn in space costs most, without a graphics card: --full has more of it, the tests named `full:`, and every page
// on a phone.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { after, before, test } from 'node:test';
import { openBrowser, openReport } from '../../../scripts/headless_browser.mjs';
import { attitudeError, isNear, meanOf, readCurves, readTable } from './expected.mjs';

const folder = resolve(process.argv[2]);
const full = process.argv[3] === '--full';
const fullTest = (name, body) => test(`full: ${name}`, { skip: !full }, body);
const RUN = join(folder, 'run/report.html');
const COMPARISON = join(folder, 'methods/comparison.html');
const STUDY = join(folder, 'study.html');
let browser, runPage, studyPage, comparisonPage;  // opened once; each test leaves them as it found them
const complaints = [];

before(async () => {
  browser = await openBrowser({ viewport: { width: 1280, height: 900 }, colorScheme: 'light', acceptDownloads: true });
  browser.context.on('request', (request) => {
    if (!/^(file|blob|data):/.test(request.url()) || (request.url().startsWith('file:') && !request.isNavigationRequest())) {
      complaints.push(`asked for ${request.url().slice(0, 200)}`);
    }
  });
  browser.context.on('console', (message) => {
    if (message.type() === 'error') {
      complaints.push(`console: ${message.text()}`);
    }
  });
  browser.context.on('weberror', (error) => complaints.push(`error: ${error.error().message}`));
  runPage = await openReport(browser.context, RUN);
  studyPage = await openReport(browser.context, STUDY);
  comparisonPage = await openReport(browser.context, COMPARISON);
});
after(() => browser.close());

/** A page behind another one is drawn when the browser has nothing else to do. */
async function inFront(page) {
  await page.bringToFront();
  return page;
}

/** Draws a figure and returns its curves as Plotly holds them. */
async function curvesOf(page, id) {
  return page.evaluate(async (figure) => {
    await window.limberReport.draw(figure);
    const plot = window.limberReport.plot(figure);
    return plot.data.map(({ name, x, y, visible, yaxis }) => ({ name, x: [...x], y: [...y], visible, yaxis: yaxis ?? 'y' }));
  }, id);
}

const layoutOf = (page, id, key) => page.evaluate(
  ([figure, part]) => {
    const axis = window.limberReport.plot(figure)._fullLayout[part];
    return { type: axis.type, range: [...axis.range] };
  }, [id, key]);

test('the report of a run has every figure, and each can be drawn', async () => {
  const page = await inFront(runPage);
  assert.match(await page.title(), /lcekf on /);
  const ids = await page.evaluate(() => window.limberReport.document.sections.flatMap((s) => s.blocks).filter((b) => b.type === 'figure').map((b) => b.id));
  const drawn = await page.evaluate(async (figures) => {
    for (const id of figures) {
      await window.limberReport.draw(id);
    }
    return figures.map((id) => [id, document.querySelectorAll(`#${id} .main-svg, #${id} canvas`).length > 0]);
  }, ids.filter((id) => full || id !== 'path-3d'));
  assert.deepEqual(ids, ['path', 'path-3d', 'position-error', 'attitude-error', 'error-over-distance', 'velocity-error', 'bias-gyro', 'bias-accel', 'health-effect', 'health-rotation', 'health-translation', 'nis', 'points-per-frame', 'time-per-frame']);
  assert.ok(drawn.every(([, ok]) => ok), JSON.stringify(drawn));
});

test('the curves of a run are those of its files', async () => {
  const page = await inFront(runPage);
  const estimate = readTable(join(folder, 'run/trajectory.csv'), ',');
  const truth = readTable(join(folder, 'run/truth.tum'), ' ');
  const frames = readTable(join(folder, 'run/frames.csv'), ',');
  const position = await curvesOf(page, 'position-error');
  for (const [k, axis] of ['y', 'y2', 'y3'].entries()) {
    const error = position.find((t) => t.name === 'error' && t.yaxis === axis);
    const upper = position.find((t) => t.name === '+3 sigma' && t.yaxis === axis);
    assert.equal(error.y.length, estimate.length);
    estimate.forEach((row, n) => {
      assert.ok(isNear(error.x[n], (row[0] - estimate[0][0]) * 1e-9));
      assert.ok(isNear(error.y[n], truth[n][1 + k] - row[1 + k]), `error ${k} of frame ${n}`);
      const variance = row[17 + [0, 6, 11][k]];
      assert.ok(isNear(upper.y[n], 3 * Math.sqrt(variance)), `sigma ${k} of frame ${n}`);
    });
  }
  const attitude = await curvesOf(page, 'attitude-error');
  const yaw = attitude.find((t) => t.name === 'error' && t.yaxis === 'y3');
  estimate.forEach((row, n) => {
    const expected = attitudeError(row.slice(4, 8), [truth[n][7], ...truth[n].slice(4, 7)])[2];
    assert.ok(isNear(yaw.y[n], expected * 180 / Math.PI, 1e-7), `yaw of frame ${n}`);
  });
  const velocity = await curvesOf(page, 'velocity-error');
  const known = readTable(join(folder, 'run/truth.csv'), ',');
  for (const [k, axis] of ['y', 'y2', 'y3'].entries()) {
    const error = velocity.find((t) => t.name === 'lcekf' && t.yaxis === axis);
    const upper = velocity.find((t) => t.name === '+3 sigma' && t.yaxis === axis);
    estimate.forEach((row, n) => {
      assert.ok(isNear(error.y[n], known[n][8 + k] - row[8 + k], 1e-9), `velocity ${k} of frame ${n}`);
      assert.ok(isNear(upper.y[n], 3 * row[38 + k]), `its sigma`);
    });
  }
  const bias = (await curvesOf(page, 'bias-accel')).filter((t) => t.yaxis === 'y2');
  estimate.forEach((row, n) => {
    assert.ok(isNear(bias.find((t) => t.name === 'lcekf').y[n], row[15]), `bias of frame ${n}`);
    assert.ok(isNear(bias.find((t) => t.name === '-3 sigma').y[n], row[15] - 3 * row[45], 1e-9), `its sigma`);
    assert.ok(isNear(bias.find((t) => t.name === 'truth').y[n], known[n][15]), `its truth`);
  });
  const nis = (await curvesOf(page, 'nis')).find((t) => t.name === 'NIS / d.o.f.');
  frames.forEach((row, n) => assert.ok(isNear(nis.y[n], row[7] / row[8]), `NIS of frame ${n}`));
  const used = (await curvesOf(page, 'points-per-frame')).find((t) => t.name === 'used');
  assert.deepEqual(used.y, frames.map((row) => row[2]));
});

test('several runs lie over each other, the table first', async () => {
  const page = await inFront(comparisonPage);
  assert.equal(await page.title(), '3 runs on recording');
  const rows = await page.evaluate(() => [...document.querySelectorAll('#comparison .table:first-child tbody tr')].map((tr) => tr.cells[0].textContent));
  assert.deepEqual(rows, ['ekf', 'lcekf', 'adaptive']);
  const error = await curvesOf(page, 'position-error');
  for (const method of rows) {
    const estimate = readTable(join(folder, `methods/${method}/trajectory.csv`), ',');
    const truth = readTable(join(folder, `methods/${method}/truth.tum`), ' ');
    const drawn = error.find((t) => t.name === method);
    assert.equal(drawn.y.length, estimate.length);
    estimate.forEach((row, n) => {
      const length = Math.hypot(...[0, 1, 2].map((k) => truth[n][1 + k] - row[1 + k]));
      assert.ok(isNear(drawn.y[n], length, 1e-9), `${method}, frame ${n}: ${drawn.y[n]} is not ${length}`);
    });
  }
  const ids = await page.evaluate(() => window.limberReport.document.sections.flatMap((s) => s.blocks).filter((b) => b.type === 'figure').map((b) => b.id));
  for (const id of ids) {
    assert.ok((await curvesOf(page, id)).length > 0, id);
  }
  for (const id of ['path', 'position-error', 'attitude-error', 'relative-error', 'error-over-distance', 'velocity-error', 'bias-gyro', 'bias-accel', 'estimated-0', 'health-rotation']) {
    assert.ok(ids.includes(id), id);
  }
});

test('a page opens on the answer: its light, why, and what to do', async () => {
  for (const size of [{ width: 1280, height: 800 }, { width: 390, height: 844 }]) {
    for (const page of [runPage, comparisonPage, studyPage]) {
      await page.bringToFront();
      await page.setViewportSize(size);
      await page.evaluate(() => window.scrollTo({ top: 0, behavior: 'instant' }));
      const seen = await page.evaluate(() => {
        const card = document.getElementById('answer');
        const { top } = card.getBoundingClientRect();
        const facts = document.querySelector('dl.facts.lead').getBoundingClientRect();
        return { top, before: top < facts.top, text: card.textContent, headline: card.querySelector('strong').textContent };
      });
      assert.ok(seen.before && seen.top < 200, JSON.stringify(seen));
      assert.ok(seen.headline.length > 5 && !/NaN|undefined|null/.test(seen.text), seen.text);
    }
  }
  const answer = await runPage.evaluate(() => {
    const card = document.getElementById('answer');
    return { lamp: getComputedStyle(card.querySelector('.lamp')).backgroundColor, light: card.className, paragraphs: [...card.querySelectorAll('p')].map((p) => p.textContent) };
  });
  const { answer: written } = JSON.parse(readFileSync(join(folder, 'run/summary.json')));
  assert.equal(answer.light, `light ${written.light}`);
  assert.equal(answer.paragraphs[0].toLowerCase(), written.headline.toLowerCase());
  assert.match(answer.paragraphs[2], /^What to do: /);
  assert.equal(answer.paragraphs.length, 2 + written.sentences.length);
  for (const page of [runPage, comparisonPage, studyPage]) {
    await page.bringToFront();
    await page.setViewportSize({ width: 1280, height: 900 });
  }
});

/** Where the cursor stands in a figure: x of its lines, how many dots, what is written. */
const markIn = (page, id) => page.evaluate((figure) => {
  const overlay = document.querySelector(`#${figure} .cursor-overlay`);
  return {
    lines: [...(overlay?.querySelectorAll('.cursor-line') ?? [])].map((line) => Number(line.getAttribute('x1'))),
    dots: [...(overlay?.querySelectorAll('.cursor-dot') ?? [])].map((dot) => ['cx', 'cy'].map((name) => Number(dot.getAttribute(name)))),
    values: [...(overlay?.querySelectorAll('.cursor-values') ?? [])].map((text) => text.textContent),
  };
}, id);
const settled = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));

test('the pointer in one figure marks its instant in all of them and on the path', async () => {
  const page = await inFront(runPage);
  for (const id of ['path', 'position-error', 'attitude-error', 'velocity-error', 'bias-gyro', 'nis']) {
    await page.evaluate((figure) => window.limberReport.draw(figure), id);
  }
  await page.locator('#position-error').scrollIntoViewIfNeeded();
  const box = await page.locator('#position-error .nsewdrag').first().boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await settled(page);
  const t = await page.evaluate(() => Number(document.querySelector('.cursor-bar output').textContent.replace(' s', '')));
  assert.ok(Math.abs(t - 2) < 0.05, `${t} s`);  // of four
  for (const [id, panels] of [['position-error', 3], ['attitude-error', 3], ['velocity-error', 3], ['bias-gyro', 3], ['nis', 1]]) {
    const { lines } = await markIn(page, id);
    const expected = await page.evaluate(([figure, at]) => {
      const axis = window.limberReport.plot(figure)._fullLayout.xaxis;
      return axis._offset + axis.c2p(at);
    }, [id, t]);
    assert.equal(lines.length, panels, id);
    lines.forEach((x) => assert.ok(Math.abs(x - expected) < 5, `${id}: ${x} is not ${expected}`));
  }
  assert.deepEqual((await markIn(page, 'position-error')).values, []);  // the plot itself shows them there
  const estimate = readTable(join(folder, 'run/trajectory.csv'), ',');
  const n = estimate.findIndex((row) => (row[0] - estimate[0][0]) * 1e-9 >= t - 0.0251);
  const { values } = await markIn(page, 'bias-gyro');
  assert.equal(values.length, 3);
  assert.ok(values.every((text) => text.length > 2), JSON.stringify(values));
  const place = await page.evaluate(([x, y]) => {
    const { xaxis, yaxis } = window.limberReport.plot('path')._fullLayout;
    return [xaxis._offset + xaxis.c2p(x), yaxis._offset + yaxis.c2p(y)];
  }, estimate[n].slice(1, 3));
  const { dots } = await markIn(page, 'path');
  assert.equal(dots.length, 2);  // truth and estimate
  assert.ok(Math.hypot(dots[1][0] - place[0], dots[1][1] - place[1]) < 12, `${dots[1]} is not ${place}`);
});

fullTest('the path in space shows the instant that is marked', async () => {
  const page = await inFront(runPage);
  await page.evaluate(() => window.limberReport.draw('path-3d'));
  await page.evaluate(() => window.limberReport.mark(2));
  await page.locator('#path-3d').scrollIntoViewIfNeeded();
  await page.waitForFunction(() => window.limberReport.plot('path-3d').data.at(-1).x.length === 2);
});

test('the slider, keys and Off move the instant and take it away', async () => {
  const page = await inFront(runPage);
  await page.locator('.cursor-bar input').focus();
  await page.evaluate(() => window.limberReport.mark(1));
  await settled(page);
  assert.equal(await page.textContent('.cursor-bar output'), '1.00 s');
  const before_ = await markIn(page, 'attitude-error');
  await page.keyboard.press('ArrowRight');
  await settled(page);
  const after_ = await markIn(page, 'attitude-error');
  assert.ok(after_.lines[0] > before_.lines[0], JSON.stringify([before_.lines, after_.lines]));
  await page.keyboard.press('Escape');
  await settled(page);
  assert.deepEqual((await markIn(page, 'attitude-error')).lines, []);
  assert.ok(await page.locator('.cursor-bar button').isHidden());
});

fullTest('a finger on a curve marks its instant, with values that stay in the figure', async () => {
  const phone = await openBrowser({ viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, colorScheme: 'dark' });
  const page = await openReport(phone.context, COMPARISON);
  await page.evaluate(() => document.getElementById('velocity-error').scrollIntoView({ block: 'start', behavior: 'instant' }));
  await page.waitForSelector('#velocity-error .nsewdrag');
  const box = await page.locator('#velocity-error .nsewdrag').first().boundingBox();
  await page.touchscreen.tap(box.x + 0.6 * box.width, box.y + 0.5 * box.height);
  await settled(page);
  const { lines, values } = await markIn(page, 'velocity-error');
  assert.equal(lines.length, 3);
  assert.equal(values.length, 3);
  const outside = await page.evaluate(() => {
    const plot = document.querySelector('#velocity-error .plot').getBoundingClientRect();
    return [...document.querySelectorAll('#velocity-error .cursor-values')].filter((text) => {
      const { left, right } = text.getBoundingClientRect();
      return left < plot.left || right > plot.right;
    }).length;
  });
  assert.equal(outside, 0);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await phone.close();
});

test('relative errors stand over the lengths that limber evaluate has', async () => {
  const expected = JSON.parse(readFileSync(join(folder, 'evaluation.json'))).rpe.over_distance;
  const drawn = await curvesOf(runPage, 'error-over-distance');
  const position = drawn.find((t) => t.name === 'lcekf' && t.yaxis === 'y');
  assert.ok(expected.length >= 4);
  assert.equal(position.x.length, expected.length);
  expected.forEach(({ distance_m: distance, position_percent: { median } }, k) =>
    assert.ok(isNear(position.x[k], distance) && Math.abs(position.y[k] - median) < 1e-4 * median, `${distance} m: ${position.y[k]} is not ${median}`));
  assert.equal((await layoutOf(runPage, 'error-over-distance', 'xaxis')).type, 'log');
});

/** For Plotly a double click is two presses within its delay, and a press before counts as the first of them. On a busy
 *  machine two may lie further apart. */
async function doubleClick(page, id, x, y) {
  await page.waitForFunction((figure) => {
    const { _mouseDownTime: pressed, _context: { doubleClickDelay } } = window.limberReport.plot(figure);
    return Date.now() - pressed > doubleClickDelay;
  }, id);
  await page.mouse.dblclick(x, y);
  await settled(page);
}

test('a figure can be zoomed, and a double click shows all again', async () => {
  const page = await inFront(runPage);
  await curvesOf(page, 'nis');
  const box = await page.locator('#nis .nsewdrag').boundingBox();
  const [from, to] = [0.25, 0.75].map((share) => [box.x + share * box.width, box.y + share * box.height]);
  await page.locator('#nis').scrollIntoViewIfNeeded();
  const shift = await page.locator('#nis .nsewdrag').boundingBox();
  const dy = shift.y - box.y;
  const all = (await layoutOf(page, 'nis', 'xaxis')).range;
  await page.mouse.move(from[0], from[1] + dy);
  await page.mouse.down();
  await page.mouse.move(to[0], to[1] + dy, { steps: 5 });
  await page.mouse.up();
  const zoomed = (await layoutOf(page, 'nis', 'xaxis')).range;
  const width = all[1] - all[0];
  assert.ok(Math.abs(zoomed[0] - (all[0] + 0.25 * width)) < 0.02 * width, `${all} became ${zoomed}`);
  assert.ok(Math.abs(zoomed[1] - (all[0] + 0.75 * width)) < 0.02 * width, `${all} became ${zoomed}`);
  const shown = async () => (await layoutOf(page, 'nis', 'xaxis')).range;
  for (let attempt = 0; attempt < 20 && Math.abs((await shown())[0] - all[0]) > 1e-9; ++attempt) {
    await doubleClick(page, 'nis', to[0], to[1] + dy - 20);
  }
  (await shown()).forEach((end, k) => assert.ok(Math.abs(end - all[k]) < 1e-9, `${end} is not ${all[k]}`));
});

test('the log switch turns the axis, and back', async () => {
  const page = await inFront(studyPage);
  const id = await page.evaluate(() => document.querySelector('figure[id$="-position"]').id);
  await curvesOf(page, id);
  const button = page.locator(`#${id} button.log`);
  assert.equal((await layoutOf(page, id, 'yaxis')).type, 'linear');
  await button.click();
  const log = await layoutOf(page, id, 'yaxis');
  assert.equal(log.type, 'log');
  assert.ok(log.range.every(Number.isFinite));
  assert.equal(await button.getAttribute('aria-pressed'), 'true');
  await button.click();
  assert.equal((await layoutOf(page, id, 'yaxis')).type, 'linear');
});

test('a variant hides the curves it names, and the legend brings one back', async () => {
  const page = await inFront(studyPage);
  const id = await page.evaluate(() => document.querySelector('figure[id$="-position"]').id);
  const shown = async () => (await curvesOf(page, id)).filter((t) => t.visible).map((t) => t.name);
  assert.ok((await shown()).includes('ekf'));
  await page.locator(`#${id} .segments button`, { hasText: /^without ekf$/ }).click();
  const without = await shown();
  assert.ok(!without.includes('ekf') && !without.includes('ekf 3σ') && without.includes('lcekf') && without.includes('ekf-full'));
  await page.locator(`#${id} .legend button`, { hasText: /^ekf$/ }).click();
  assert.ok((await shown()).includes('ekf'));
  assert.equal(await page.locator(`#${id} .segments button`).first().getAttribute('aria-pressed'), 'true');
});

test('dark and light can be switched, and a method keeps its own colour in each', async () => {
  const page = await inFront(studyPage);
  const ids = await page.evaluate(() => [...document.querySelectorAll('figure[id$="-position"], figure[id$="-attitude"]')].map((f) => f.id));
  const look = async () => page.evaluate(async (figures) => {
    const lines = [];
    for (const figure of figures) {
      await window.limberReport.draw(figure);
      lines.push(window.limberReport.plot(figure).data.find((t) => t.name === 'lcekf').line.color);
    }
    return { paper: getComputedStyle(document.body).backgroundColor, lines: [...new Set(lines)] };
  }, ids);
  assert.ok(ids.length >= 2);
  const light = await look();
  await page.locator('#theme').click();
  const dark = await look();
  assert.equal(light.lines.length, 1);
  assert.equal(dark.lines.length, 1);
  assert.notEqual(light.paper, dark.paper);
  assert.notEqual(light.lines[0], dark.lines[0]);
  await page.locator('#theme').click();
  assert.deepEqual(await look(), light);
});

test('random walks of one method can be told apart by colour', async () => {
  const colors = await studyPage.evaluate(async () => {
    const { id } = document.querySelector('figure[id$="-position"]');
    await window.limberReport.draw(id);
    return window.limberReport.plot(id).data.filter((t) => /^ekf-full(:walk=\S+)?$/.test(t.name)).map((t) => t.line.color);
  });
  assert.equal(colors.length, 3);
  assert.equal(new Set(colors).size, 3);
});

test('a figure is saved as SVG and PNG, black on white with its legend', async () => {
  const page = await inFront(runPage);
  await page.locator('#theme').click();
  await curvesOf(page, 'position-error');
  await page.locator('#position-error').scrollIntoViewIfNeeded();
  for (const [title, name, start] of [['Save as SVG', 'position-error.svg', '<svg'], ['Save as PNG', 'position-error.png', '\x89PNG']]) {
    const [download] = await Promise.all([
      page.waitForEvent('download'), page.locator(`#position-error [data-title="${title}"]`).click()]);
    assert.equal(download.suggestedFilename(), name);
    const content = readFileSync(await download.path());
    assert.equal(content.subarray(0, start.length).toString('latin1'), start);
    if (name.endsWith('.svg')) {
      const text = content.toString();
      for (const word of ['time [s]', 'x [m]', '>error<', 'rgb(255, 255, 255)']) {
        assert.ok(text.includes(word), word);
      }
    }
  }
  await page.locator('#theme').click();
});

test('the curves of a study are the moments in its database', async () => {
  const page = await inFront(studyPage);
  const curves = readCurves(join(folder, 'study_curves.csv'));
  const cases = await page.evaluate(() => [...document.querySelectorAll('section[id^="case-"]')].map((s) => s.id));
  assert.equal(cases.length, 2);
  for (const [suffix, quantity, factor, name] of [
    ['position', 'position_squared_error', 1, 'lcekf'], ['position', 'position_variance', 9, 'ekf-full 3σ'],
    ['attitude', 'attitude_squared_error', 1, 'ekf'], ['landmarks', 'landmark_squared_error', 1, 'lcekf'],
    ['nees', 'pose_nees', 1 / 6, 'ekf']]) {
    for (const id of cases) {
      const drawn = (await curvesOf(page, `${id}-${suffix}`)).find((t) => t.name === name);
      const expected = meanOf(curves, id, name.replace(' 3σ', ''), quantity);
      assert.equal(drawn.y.length, expected.length);
      drawn.y.forEach((y, n) => assert.ok(isNear(y, expected[n][1] === null ? null : factor * expected[n][1]) && isNear(drawn.x[n], expected[n][0]),
        `${id} ${suffix} ${name} at ${drawn.x[n]}: ${y} is not ${factor * expected[n][1]}`));
    }
  }
});

test('a study shows the claims of the paper that it can judge, and folds the others', async () => {
  const claims = await studyPage.evaluate(() => window.limberReport.document.sections.flatMap((s) => s.blocks)
    .filter((b) => b.type === 'claims').flatMap((b) => b.claims.map((claim) => ({ ...claim, brief: b.brief }))));
  const shown = await studyPage.evaluate(() => [...document.querySelectorAll('.claims li')].map((li) => ({
    verdict: li.querySelector('.verdict').textContent, text: li.textContent })));
  assert.ok(claims.filter((claim) => claim.brief).length > 3);
  assert.ok(claims.filter((claim) => !claim.brief).length > 3);
  assert.ok(claims.every((claim) => claim.verdict !== 'not measured'));
  assert.match(await studyPage.textContent('#overview details summary'), /^\d+ claims of the paper are about what this study does not hold$/);
  assert.equal(await studyPage.locator('#overview details[open]').count(), 0);
  assert.equal(shown.length, claims.length);
  claims.forEach((claim, k) => {
    assert.ok(shown[k].verdict.endsWith(claim.verdict));
    assert.ok(shown[k].text.includes(claim.statement) && (claim.brief || shown[k].text.includes(claim.measured)));
  });
  assert.match(await studyPage.evaluate(() => document.querySelector('section[id^="case-"] details.listing pre').textContent), /stereo: 20/);
});

test('a desktop screen shows every table and verdict whole', async () => {
  for (const page of [runPage, studyPage, comparisonPage]) {
    await page.bringToFront();
    const hidden = await page.evaluate(() => [
      ...[...document.querySelectorAll('.scroll')].filter((e) => e.scrollWidth > e.clientWidth),
      ...[...document.querySelectorAll('.verdict')].filter((e) => e.getBoundingClientRect().right > document.documentElement.clientWidth),
    ].map((e) => e.textContent.slice(0, 60)));
    assert.deepEqual(hidden, []);
  }
});

test('the path in space is drawn and can be turned', async () => {
  const page = await inFront(runPage);
  await page.locator('#path-3d').scrollIntoViewIfNeeded();
  await page.waitForSelector('#path-3d canvas');
  const eye = () => page.evaluate(() => ({ ...window.limberReport.plot('path-3d')._fullLayout.scene._scene.getCamera().eye }));
  const before_ = await eye();
  const box = await page.locator('#path-3d .plot').boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  const drawn = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  await page.mouse.move(...middle);
  await page.mouse.down();
  for (const way of [40, 80, 120]) {  // Plotly asks where the pointer is when it draws: a drag between two pictures is none
    await drawn();
    await page.mouse.move(middle[0] + way, middle[1]);
  }
  await drawn();
  await page.mouse.up();
  await page.waitForFunction(({ x, y }) => {  // the camera moves when the next picture is drawn
    const now = window.limberReport.plot('path-3d')._fullLayout.scene._scene.getCamera().eye;
    return Math.hypot(now.x - x, now.y - y) > 0.1;
  }, before_);
  const picture = await page.evaluate(async () => {
    const image = new Image();
    image.src = await window.limberReport.image('path-3d', 'png', { width: 300, height: 200 });
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    return { size: [image.width, image.height], colors: new Set(new Uint32Array(data.buffer)).size };
  });
  assert.deepEqual(picture.size, [900, 600]);  // three pixels for one, for print
  assert.ok(picture.colors > 50, `${picture.colors} colours`);
});

test('nothing sticks out of a phone screen, and print is white', async () => {
  for (const page of full ? [runPage, studyPage, comparisonPage] : [studyPage]) {
    await page.bringToFront();
    await page.setViewportSize({ width: 390, height: 844 });
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
    await page.emulateMedia({ colorScheme: 'dark' });
    await page.waitForFunction(() => document.documentElement.dataset.theme === 'dark');
    await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light');
    await page.evaluate(() => window.dispatchEvent(new Event('afterprint')));
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'dark');
  }
});

test('no page complained, and none asked for anything but itself', () => {
  assert.deepEqual(complaints, []);
});
