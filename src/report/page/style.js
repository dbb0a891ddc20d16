// SPDX-License-Identifier: MIT
// How curves look. One method has one colour on every page, light and dark; the hues are those of Okabe and Ito,
// which colour-blind readers can tell apart, and dashes help where many methods meet. Random walks, of which a figure
// shows many that differ in a number, go from violet to red.
const STYLES = {
  'ekf': { light: '#0072b2', dark: '#5aaee6' },
  'ekf-full': { light: '#00825f', dark: '#2fc397' },
  'lcekf': { light: '#d55e00', dark: '#f58a3a' },
  'mono-left': { light: '#b0509a', dark: '#e592cd', dash: 'dash' },
  'oracle': { light: '#59626b', dark: '#b4bdc6', dash: 'longdash' },
  'soft': { light: '#6b5bc2', dark: '#aa9cf2', dash: 'dashdot' },
  'consider': { light: '#8a6d00', dark: '#d6b741', dash: 'dashdot' },
  'adaptive': { light: '#00838f', dark: '#3cc8d8', dash: 'longdashdot' },
  'truth': { light: '#1b1f23', dark: '#f2f4f6', width: 1.3 },
  'landmarks': { light: '#8a949e', dark: '#77828d' },
  'band': { light: '#59626b', dark: '#aab4be', width: 1.2 },
  'wide': { light: '#c6cdd4', dark: '#4a535c', width: 6 },
  'series 1': { light: '#004488', dark: '#7aaef5' },
  'series 2': { light: '#bb5566', dark: '#f08fa0' },
  'series 3': { light: '#a87b00', dark: '#e3bd55' },
  'series 4': { light: '#3f8f4f', dark: '#7fd08f' },
  'plain': { light: '#0072b2', dark: '#5aaee6' },
};
const DASHES_OF_VARIANTS = ['dash', 'dashdot', 'longdash', 'longdashdot'];
const COLORS_OF_WALKS = [
  { light: '#5b1a8b', dark: '#c39bf0' }, { light: '#3d5bb8', dark: '#8fb0ff' }, { light: '#1a869f', dark: '#5fd0e6' },
  { light: '#2b8a47', dark: '#7fdc98' }, { light: '#9a7800', dark: '#f0cc4a' }, { light: '#c0392b', dark: '#ff9a8a' },
];

const variantsSeen = new Map();  // 'lcekf' -> ['lcekf:rotation', ...], in order of appearance

/** How many other variants of its method came before a style such as 'lcekf:rotation'. */
function placeOfVariant(base, style) {
  const seen = variantsSeen.get(base) ?? [];
  variantsSeen.set(base, seen);
  if (!seen.includes(style)) {
    seen.push(style);
  }
  return seen.indexOf(style);
}

/** A variant has its method's colour, and a dash that tells it from the others; a random walk has a colour of its own. */
function lookOfVariant(base, style, look) {
  const place = placeOfVariant(base, style);
  return {
    ...look, dash: DASHES_OF_VARIANTS[place % DASHES_OF_VARIANTS.length],
    ...(style.includes(':walk=') ? COLORS_OF_WALKS[place % COLORS_OF_WALKS.length] : {}),
  };
}

/** Colour, dash and width of a style in a theme. 'lcekf:full' is what the paper calls LCEKF. */
function lookOf(style, theme) {
  const base = style.split(':')[0];
  const own = STYLES[base] ?? STYLES.plain;
  const look = base === style || style === 'lcekf:full' ? own : lookOfVariant(base, style, own);
  return { color: look[theme], dash: look.dash ?? 'solid', width: look.width ?? 1.8 };
}

const THEMES = {
  light: { ink: '#1b1f23', quiet: '#5a646e', grid: '#e4e8ec', line: '#aeb7c0', card: '#ffffff' },
  dark: { ink: '#e7eaed', quiet: '#a3adb7', grid: '#2b3137', line: '#59626b', card: '#1a1e22' },
};
const FONT = 'system-ui, "Segoe UI", Roboto, "Helvetica Neue", "Noto Sans", Arial, sans-serif';
