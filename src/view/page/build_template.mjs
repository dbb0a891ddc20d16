// SPDX-License-Identifier: MIT
// node build_template.mjs PAGE_FOLDER REPORT_PAGE_FOLDER NPM_FOLDER OUT.cpp
// Bundles script and three.js (esbuild), puts them and the style into view.html and the result into a C++ source.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { scriptText, sourceOf } from '../../report/page/cpp_literals.mjs';

const [folder, reportFolder, npm, out] = process.argv.slice(2);
const { buildSync } = createRequire(join(npm, 'package.json'))('esbuild');

const bundle = buildSync({
  entryPoints: [join(folder, 'main.js')], bundle: true, minify: true, format: 'iife', target: 'es2022', write: false,
  legalComments: 'none', nodePaths: [join(npm, 'node_modules')], logLevel: 'warning',
});
const pieces = {
  style: readFileSync(join(reportFolder, 'page.css'), 'utf8') + readFileSync(join(folder, 'view.css'), 'utf8'),
  script: scriptText(bundle.outputFiles[0].text, 'main.js'),
};
const html = readFileSync(join(folder, 'view.html'), 'utf8')
  .replace(/\/\*limber:(style|script)\*\//g, (_, name) => pieces[name]);

writeFileSync(out, sourceOf('view_page', 'three.js, Copyright three.js authors, MIT licence', html));
