#!/usr/bin/env node
// SPDX-License-Identifier: MIT
// A figure of a report as a file for a paper, without a screen:
//
//   scripts/export_figure.mjs REPORT.html FIGURE OUT.svg [--variant LABEL] [--log] [--size 900x560]
//
// FIGURE is the figure's id: --list prints those of a report. OUT ends in .svg or .png. Needs chromium, and the
// playwright-core that a build with tests has fetched (see headless_browser.mjs).
import { writeFileSync } from 'node:fs';
import { extname, resolve } from 'node:path';
import { parseArgs } from 'node:util';

const USAGE = 'usage: scripts/export_figure.mjs REPORT.html FIGURE OUT.svg|OUT.png [--variant LABEL] [--log] [--size 900x560]\n' +
  '       scripts/export_figure.mjs REPORT.html --list';

function wrongUsage(message) {
  console.error(`${message}\n${USAGE}`);
  process.exit(2);
}

function readArguments() {
  try {
    return parseArgs({
      allowPositionals: true,
      options: {
        variant: { type: 'string' }, log: { type: 'boolean' }, list: { type: 'boolean' }, help: { type: 'boolean', short: 'h' },
        size: { type: 'string', default: '900x560' },
      },
    });
  } catch (error) {
    return wrongUsage(error.message);
  }
}

const { values: options, positionals: [report, figure, out] } = readArguments();
if (options.help) {
  console.log(USAGE);
  process.exit(0);
}
const size = /^(\d+)x(\d+)$/.exec(options.size);
const format = out && extname(out).slice(1);
if (!report || (!options.list && !['svg', 'png'].includes(format)) || !size) {
  wrongUsage('expected a report, a figure and a file to write');
}

const { openBrowser, openReport } = await import('./headless_browser.mjs');
const browser = await openBrowser({ colorScheme: 'light' });
try {
  const page = await openReport(browser.context, resolve(report));
  if (options.list) {
    const figures = await page.evaluate(() => window.limberReport.figures());
    console.log(figures.map(({ id, title, variants }) => [id, title, ...variants].join('\t')).join('\n'));
  } else {
    const url = await page.evaluate(({ id, kind, variant, log, width, height }) =>
      window.limberReport.image(id, kind, { width, height }, { variant, log }), {
      id: figure, kind: format, variant: options.variant, log: options.log, width: Number(size[1]), height: Number(size[2]),
    });
    const [, encoding, content] = /^data:[^,]*?(;base64)?,(.*)$/s.exec(url);
    writeFileSync(out, encoding ? Buffer.from(content, 'base64') : decodeURIComponent(content));
  }
} catch (error) {
  console.error(error.message.split('\n')[0]);
  process.exitCode = 1;
} finally {
  await browser.close();
}
