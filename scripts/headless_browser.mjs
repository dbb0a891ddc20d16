// SPDX-License-Identifier: MIT
// A headless Chromium for the page tests and for export_figure.mjs. Two environment variables tell where things are:
//   LIMBER_CHROMIUM    the browser's program (default: /usr/bin/chromium)
//   LIMBER_REPORT_NPM  folder with node_modules/playwright-core (default: that of the release build)
import { mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = dirname(dirname(fileURLToPath(import.meta.url)));
const NPM = process.env.LIMBER_REPORT_NPM ?? join(ROOT, 'build/release/src/report/npm');
const { chromium } = createRequire(join(NPM, 'package.json'))('playwright-core');

const PATIENCE_MS = 120_000;  // 3-D in software takes its time beside other work; how long says nothing of a page

// Without a graphics card 3-D is drawn by SwiftShader.
const ARGUMENTS = [
  '--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
];

/** A browser with a fresh profile; close() also removes that. Options are those of a Playwright context. */
export async function openBrowser(options = {}) {
  const profile = mkdtempSync(join(tmpdir(), 'limber-browser-'));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.LIMBER_CHROMIUM ?? '/usr/bin/chromium', headless: true, args: ARGUMENTS, ...options,
  });
  context.setDefaultTimeout(PATIENCE_MS);
  return {
    context,
    async close() {
      await context.close();
      rmSync(profile, { recursive: true, force: true });
    },
  };
}

/** Opens a report and waits until it is built. */
export async function openReport(context, file) {
  const page = await context.newPage();
  await page.goto(`file://${file}`);
  await page.waitForFunction(() => window.limberReport !== undefined);
  return page;
}
