// SPDX-License-Identifier: MIT
// Numbers as the program sends them, and as people read them.

/** 32-bit floats, little-endian, from base64; NaN is what is not there. */
export function floatsOf(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, k) => view.getFloat32(4 * k, true));
}

/** A number with so many decimals, and its sign if asked for. */
export function fixed(value, decimals, signed = false) {
  if (!Number.isFinite(value)) {
    return '–';
  }
  return (signed && value >= 0 ? '+' : '') + value.toFixed(decimals).replace('-', '−');
}

/** Decimals that show a size such as this with three digits. */
export function decimalsFor(size) {
  return Number.isFinite(size) && size > 0 ? Math.min(5, Math.max(0, 2 - Math.floor(Math.log10(size)))) : 3;
}
