// SPDX-License-Identifier: MIT
// Left and right image with tracks and matches; where there are no images, on an empty frame.

const FATES = { u: '--used', r: '--refused', o: '--other' };
const TRAIL = 10;  // frames

/** Width and height of a camera; where the recording does not say, what holds all points. */
function sizeOf(camera, frame, k) {
  if (camera.width > 0 && camera.height > 0) {
    return camera;
  }
  let width = 2 * camera.cu, height = 2 * camera.cv;
  for (let n = 2 * k; n < frame.points.uv.length; n += 4) {
    width = Math.max(width, frame.points.uv[n] || 0);
    height = Math.max(height, frame.points.uv[n + 1] || 0);
  }
  return { width: Math.max(1, width), height: Math.max(1, height) };
}

export class Pictures {
  constructor(canvases) {
    this.canvases = canvases;
    this.turn = 0;
  }

  /** Draws a frame; resolves when it is there. `earlier`: frames before it, newest last. */
  async draw(frame, earlier, cameras) {
    const turn = ++this.turn;
    const images = await Promise.all((frame.images ?? [null, null]).map(decoded));
    if (turn !== this.turn) {
      return;  // a newer frame is being drawn
    }
    const trails = trailsOf(frame, earlier);
    this.canvases.forEach((canvas, k) => this.drawOne(canvas, k, frame, images[k], trails, sizeOf(cameras[k], frame, k)));
  }

  drawOne(canvas, k, frame, image, trails, size) {
    const width = canvas.clientWidth * Math.min(2, window.devicePixelRatio);
    const scale = width / size.width;
    canvas.width = Math.round(width);
    canvas.height = Math.round(size.height * scale);
    const context = canvas.getContext('2d');
    if (image) {
      context.drawImage(image, 0, 0, canvas.width, canvas.height);
    }
    const line = Math.max(1, canvas.width / 500);
    const colors = colorsOf(canvas);
    context.lineWidth = line;
    const { uv, fates } = frame.points;
    for (let n = 0; n < fates.length; ++n) {
      const [u, v] = [uv[4 * n + 2 * k] * scale, uv[4 * n + 2 * k + 1] * scale];
      if (!Number.isFinite(u)) {
        continue;
      }
      context.strokeStyle = context.fillStyle = colors[fates[n]];
      context.beginPath();
      context.moveTo(u, v);
      if (k === 0) {  // where it came from
        for (const [x, y] of trails[n]) {
          context.lineTo(x * scale, y * scale);
        }
      } else if (Number.isFinite(uv[4 * n])) {  // where its match in the left image lies
        context.lineTo(uv[4 * n] * scale, uv[4 * n + 1] * scale);
      }
      context.globalAlpha = 0.7;
      context.stroke();
      context.globalAlpha = 1;
      context.beginPath();
      context.arc(u, v, 2.2 * line, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

function colorsOf(canvas) {
  const style = getComputedStyle(canvas);
  return Object.fromEntries(Object.entries(FATES).map(([fate, name]) => [fate, style.getPropertyValue(name)]));
}

/** Pixels in the left image of each point in the frames before, newest first, as far as it was there. */
function trailsOf(frame, earlier) {
  const trails = frame.points.ids.map(() => []);
  const alive = new Map(frame.points.ids.map((id, n) => [id, n]));
  for (const before of earlier.slice(-TRAIL).reverse()) {
    const seen = new Map(before.points.ids.map((id, n) => [id, n]));
    for (const [id, n] of alive) {
      const u = before.points.uv[4 * (seen.get(id) ?? -1)];
      if (Number.isFinite(u)) {
        trails[n].push([u, before.points.uv[4 * seen.get(id) + 1]]);
      } else {
        alive.delete(id);
      }
    }
  }
  return trails;
}

async function decoded(base64) {
  if (!base64) {
    return null;
  }
  const image = new Image();
  image.src = `data:image/jpeg;base64,${base64}`;
  await image.decode().catch(() => {});
  return image.naturalWidth > 0 ? image : null;
}
