// SPDX-License-Identifier: MIT
// What the page remembers: never more than so much, however long the run.

const MOST_FRAMES = 360;
const FRAMES_WITH_IMAGES = 120;
const MOST_PLACES = 4096;
const MOST_LANDMARKS = 6000;

/** Frames in order; the newest are all there, of the older ones fewer and fewer, and those without images. */
export class History {
  constructor() {
    this.frames = [];
    this.complete = false;  // all are there from the beginning, and few
  }

  add(frame) {
    this.frames.push(frame);
    if (this.complete) {
      return;
    }
    const old = this.frames.length - 1 - FRAMES_WITH_IMAGES;
    if (old >= 0) {
      this.frames[old].images = null;
    }
    if (this.frames.length > MOST_FRAMES) {
      const older = MOST_FRAMES - FRAMES_WITH_IMAGES;
      this.frames = this.frames.filter((_, k) => k >= older || k % 2 === 0);
    }
  }
}

/** Places of the path, t x y z each; every second one goes when there are too many. */
export class Path {
  constructor(values = new Float32Array(0)) {
    this.values = new Float32Array(4 * MOST_PLACES);
    this.values.set(values.subarray(0, this.values.length));
    this.size = Math.min(MOST_PLACES, values.length / 4);
    this.count = 0;
    this.stride = 1;
  }

  add(t, [x, y, z]) {
    if (this.size > 0 && t <= this.values[4 * (this.size - 1)]) {
      return;
    }
    if (this.count++ % this.stride !== 0) {
      return;
    }
    if (this.size === MOST_PLACES) {
      for (let k = 0; k < MOST_PLACES / 2; ++k) {
        this.values.copyWithin(4 * k, 8 * k, 8 * k + 4);
      }
      this.size = MOST_PLACES / 2;
      this.stride *= 2;
    }
    this.values.set([t, x, y, z], 4 * this.size++);
  }
}

/** Where landmarks were when last seen; the oldest are forgotten. */
export class FormerMap {
  constructor() {
    this.places = new Map();
  }

  add({ ids, p }) {
    ids.forEach((id, k) => {
      this.places.delete(id);  // to the end of the order
      this.places.set(id, [p[3 * k], p[3 * k + 1], p[3 * k + 2]]);
    });
    for (const id of this.places.keys()) {
      if (this.places.size <= MOST_LANDMARKS) {
        break;
      }
      this.places.delete(id);
    }
  }
}
