// SPDX-License-Identifier: MIT
// node build_template.mjs PAGE_FOLDER PLOTLY.js OUT.cpp
// Puts style, script and Plotly.js into page.html and the result into a C++ source: page_template().
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { scriptText, sourceOf } from './cpp_literals.mjs';

const [folder, plotly, out] = process.argv.slice(2);
const SCRIPTS = ['style.js', 'plot.js', 'figure.js', 'cursor.js', 'page.js'];

const read = (name) => readFileSync(join(folder, name), 'utf8');

const pieces = {
  style: read('page.css'),
  plotly: scriptText(readFileSync(plotly, 'utf8'), plotly),
  script: `'use strict';\n(() => {\n${SCRIPTS.map((name) => scriptText(read(name), name)).join('\n')}\n})();`,
};
const html = read('page.html').replace(/\/\*limber:(style|plotly|script)\*\//g, (_, name) => pieces[name]);

writeFileSync(out, sourceOf('page_template', 'Plotly.js, Copyright Plotly, Inc., MIT licence', html));
