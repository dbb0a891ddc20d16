// SPDX-License-Identifier: MIT
// What the pages should show, from the files beside them, computed on a way of its own.
import { readFileSync } from 'node:fs';

/** Rows of numbers; comment lines and empty cells aside (NaN). Times in ns lose their last digits, which is fine. */
export function readTable(path, separator) {
  return readFileSync(path, 'utf8').split('\n').filter((line) => line && !line.startsWith('#') && !/^[a-z]/i.test(line))
    .map((line) => line.split(separator).map((cell) => (cell === '' ? NaN : Number(cell))));
}

/** study_curves.csv: rows as objects, keys without units. */
export function readCurves(path) {
  const [head, ...lines] = readFileSync(path, 'utf8').trim().split('\n');
  const names = head.split(',').map((name) => name.replace(/ \[.*\]$/, ''));
  return lines.map((line) => Object.fromEntries(line.split(',').map((cell, k) => [names[k], cell])));
}

/** [t, mean] of a quantity; `id` is the case's anchor on the page. */
export function meanOf(curves, id, method, quantity) {
  return curves.filter((row) => `case-${row.case.replace(/[^A-Za-z0-9]+/g, '-')}` === id && row.method === method)
    .map((row) => [Number(row.t), row[quantity] === '' ? null : Number(row[quantity])]);
}

/** The page keeps 32-bit floats; null stands for a gap, NaN on the page. `slack` is for what is computed from rounded numbers. */
export function isNear(value, expected, slack = 0) {
  return expected === null ? !Number.isFinite(value)
    : Math.abs(value - expected) <= 1.2e-7 * Math.abs(expected) + 1e-12 + slack;
}

/** Rotation vector from estimate to truth, quaternions w x y z, for small angles: 2 * vector part. */
export function attitudeError([w, x, y, z], [tw, tx, ty, tz]) {
  const vector = [
    w * tx - x * tw - y * tz + z * ty,
    w * ty + x * tz - y * tw - z * tx,
    w * tz - x * ty + y * tx - z * tw,
  ];
  const real = w * tw + x * tx + y * ty + z * tz;
  return vector.map((v) => 2 * v * Math.sign(real));
}
