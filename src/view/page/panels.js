// SPDX-License-Identifier: MIT
// What stands beside pictures and path: verdict, calibration against its tolerance, state, time per stage.
import { decimalsFor, fixed } from './numbers.js';

function element(name, className, ...children) {
  const out = document.createElement(name);
  out.className = className;
  out.append(...children);
  return out;
}

const SPAN = 1.6;  // a scale reaches to so many times what is wrong

/** A part of a scale, from and to as shares of its length. */
function part(className, from, to) {
  const out = element('span', className);
  const [a, b] = [from, to].map((share) => Math.min(1, Math.max(0, share)));
  out.style.left = `${100 * a}%`;
  out.style.width = `${100 * (b - a)}%`;
  return out;
}

/** A size with its interval, on a scale with the tolerance. `signed`: it lies on both sides of zero. */
function gauge({ name, words, value, low, high, ok, wrong, unit, signed, isNamed }) {
  const known = Number.isFinite(value) && wrong > 0;
  const end = SPAN * wrong;
  const at = (x) => (signed ? 0.5 + 0.5 * x / end : x / end);
  const scale = element('div', 'scale');
  if (known) {
    scale.append(part('wrong', at(signed ? -wrong : 0), at(wrong)), part('ok', at(signed ? -ok : 0), at(ok)),
      part('interval', at(low), at(high)));
    const mark = element('span', 'mark');
    mark.style.left = `${100 * Math.min(0.995, Math.max(0.005, at(value)))}%`;
    scale.append(mark);
    if (signed) {
      scale.append(part('zero', 0.5, 0.501));
    }
  }
  const decimals = decimalsFor(ok);
  const text = !known ? '–' : signed
    ? `${fixed(value, decimals, true)} ± ${fixed(high - value, decimals)} ${unit}`
    : `${fixed(value, decimals)} (${fixed(low, decimals)} to ${fixed(high, decimals)}) ${unit}`;
  const label = element('span', 'name', element('b', '', name), words);
  label.title = known ? `ok up to ${fixed(ok, decimals)} ${unit}, wrong from ${fixed(wrong, decimals)} ${unit}` : '';
  return element('div', isNamed ? 'gauge named' : 'gauge', label, element('span', 'value', text), scale);
}

/** The axis that drifts most, in words. */
function drift({ axes, most_likely_axis: name }) {
  const { per_minute: rate, sigma, unit } = axes[name];
  const decimals = decimalsFor(2 * sigma);
  return element('p', 'drift', `${name} drifts by ${fixed(rate, decimals, true)} ± ${fixed(1.96 * sigma, decimals)} ${unit} a minute`);
}

/** Both effects, how much the rig moves, then the six axes and their drift; with no health, empty scales. */
export function showCalibration(root, run, health) {
  const state = health?.present;
  const effect = (name, words, key, unit) => {
    const e = state?.[key] ?? {};
    return gauge({ name, words, unit, value: e.size, low: e.low, high: e.high, ok: e.ok, wrong: e.wrong });
  };
  root.replaceChildren(
    effect('off the line', '', 'epipolar_px', 'px'),
    effect('depth', state ? `at ${state.depth_percent.baselines} baselines` : '', 'depth_percent', '%'),
    effect('moves', 'from frame to frame', 'movement_px', 'px'),
    effect('depth moves', 'from frame to frame', 'movement_depth_percent', '%'),
    ...run.axes.map(({ name, words }) => {
      const axis = state?.axes?.[name] ?? {};
      const half = 1.96 * axis.sigma;
      return gauge({
        name, words, unit: axis.unit, value: axis.error, low: axis.error - half, high: axis.error + half, ok: axis.ok,
        wrong: axis.wrong, signed: true, isNamed: state?.most_likely_axis === name,
      });
    }),
    ...(state?.drift ? [drift(state.drift)] : []));
}

/** The light. */
export function showVerdict(root, health) {
  const verdict = health?.verdict ?? 'waiting';
  root.className = `light ${verdict.replace(' ', '-')}`;
  root.querySelector('strong').textContent = health ? verdict : 'cannot tell';
  root.querySelector('.words').textContent = health?.words ?? 'no window of frames is over yet';
}

/** Numbers of the state. */
export function showState(root, frame) {
  const count = (fate) => [...frame.points.fates].filter((letter) => letter === fate).length;
  const speed = frame.v ? Math.hypot(...frame.v) : NaN;
  const facts = [
    ['position [m]', frame.waiting ? '–' : frame.p.map((x) => fixed(x, 2)).join(', ')],
    ['speed', frame.v ? `${fixed(speed, 2)} m/s` : '–'],
    ['position, 1σ [m]', frame.sigma_m?.map((s) => fixed(s, 3)).join(', ') ?? '–'],
    ['attitude, 1σ [deg]', frame.sigma_deg?.map((s) => fixed(s, 2)).join(', ') ?? '–'],
    ['used, refused, seen', `${count('u')}, ${count('r')}, ${frame.points.fates.length} points`],
    ['points of the map', String(frame.map.ids.length)],
    ['frame', frame.status],
  ];
  root.replaceChildren(...facts.map(([name, value]) => element('div', '', element('dt', '', name), element('dd', '', value))));
}

const MEAN_OF = 20;  // frames

/** Mean time per stage over the latest frames. */
export function showStages(root, frames) {
  const latest = frames.slice(-MEAN_OF);
  const sums = new Map();
  for (const frame of latest) {
    for (const [name, ms] of frame.stages) {
      sums.set(name, (sums.get(name) ?? 0) + ms / latest.length);
    }
  }
  const most = Math.max(1e-9, ...sums.values());
  const rows = [...sums].flatMap(([name, ms]) => {
    const bar = element('div', 'bar');
    bar.style.width = `${100 * ms / most}%`;
    return [element('span', '', name), bar, element('span', '', `${fixed(ms, 2)} ms`)];
  });
  root.replaceChildren(...rows, element('span', 'sum', latest.length === 1 ? 'of this frame' : `mean of ${latest.length} frames`));
}
