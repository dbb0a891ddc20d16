// SPDX-License-Identifier: MIT
// One instant, marked in every figure over time and on every path: where the pointer is, or the slider stands.

const SVG_NAMESPACE = 'http://www.w3.org/2000/svg';
const MOST_VALUES = 6;  // written beside the line of a panel
const NARROW = 420;  // pixels

const isOverTime = (figure) => figure.kind === 'curves' && figure.x.title === 'time';
const isPath = (figure) => figure.traces.some((trace) => trace.t !== undefined);

/** Index of the value of an increasing series that is nearest to t; -1 if it is further away than its neighbours are. */
function nearestIndex(values, t) {
  let [low, high] = [0, values.length - 1];
  if (high < 0 || !(t >= values[0] - 1e-6) || !(t <= values[high] + 1e-6)) {
    return -1;
  }
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    [low, high] = values[middle] <= t ? [middle, high] : [low, middle];
  }
  return t - values[low] <= values[high] - t ? low : high;
}

function svgElement(name, attributes) {
  const out = document.createElementNS(SVG_NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) {
    out.setAttribute(key, value);
  }
  return out;
}

/** A number short enough to stand in a figure. */
function shortNumber(value) {
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(2) : String(Number(value.toPrecision(3)));
}

/** The mark in a figure of curves or seen from above: an SVG over the plot, which takes no pointer. */
class Overlay {
  constructor(view) {
    this.view = view;
    this.svg = svgElement('svg', { class: 'cursor-overlay', 'aria-hidden': 'true' });
  }

  clear() {
    this.svg.replaceChildren();
  }

  /** Draws the mark at t; values are written unless the pointer is here, where the plot itself shows them. */
  show(t, withValues) {
    const { plot } = this.view;
    if (this.svg.parentNode !== plot) {
      plot.append(this.svg);
    }
    this.clear();
    if (isOverTime(this.view.figure)) {
      this.showLine(t, withValues);
    } else {
      this.showPlaces(t);
    }
  }

  shownTraces() {
    const { figure, view } = this.view;
    return figure.traces.filter((trace) => trace.shape !== 'bound' && !view.hidden.has(trace.style));
  }

  showLine(t, withValues) {
    const { figure, series, plot } = this.view;
    const layout = plot._fullLayout;
    const x = layout.xaxis._offset + layout.xaxis.c2p(t);
    if (x < layout.xaxis._offset - 1 || x > layout.xaxis._offset + layout.xaxis._length + 1) {
      return;
    }
    const theme = currentTheme();
    figure.y.forEach((_, panel) => {
      const axis = layout[`yaxis${axisKey(panel)}`];
      const [top, bottom] = [axis._offset, axis._offset + axis._length];
      this.svg.append(svgElement('line', { class: 'cursor-line', x1: x, x2: x, y1: top, y2: bottom }));
      const values = [];
      for (const trace of this.shownTraces().filter((candidate) => candidate.panel === panel)) {
        const at = nearestIndex(series[trace.x], t);
        const value = at < 0 ? NaN : series[trace.y][at];
        const y = axis._offset + axis.c2p(value);
        if (!Number.isFinite(value) || !Number.isFinite(y)) {
          continue;
        }
        const { color } = lookOf(trace.style, theme);
        if (y >= top - 1 && y <= bottom + 1) {
          this.svg.append(svgElement('circle', { class: 'cursor-dot', cx: layout.xaxis._offset + layout.xaxis.c2p(series[trace.x][at]), cy: y, r: 4, fill: color }));
        }
        values.push({ text: shortNumber(value), color });
      }
      if (withValues) {
        this.writeValues(values.slice(0, MOST_VALUES), x, top, layout);
      }
    });
  }

  writeValues(values, x, top, layout) {
    const left = x > layout.xaxis._offset + 0.7 * layout.xaxis._length;
    const text = svgElement('text', { class: 'cursor-values', x: x + (left ? -7 : 7), y: top + 14, 'text-anchor': left ? 'end' : 'start' });
    const narrow = layout.xaxis._length < NARROW;  // one below the other
    values.forEach(({ text: value, color }, k) => {
      const after = narrow ? { x: text.getAttribute('x'), dy: 14 } : { dx: 8 };
      const part = svgElement('tspan', { fill: color, ...(k > 0 ? after : {}) });
      part.textContent = value;
      text.append(part);
    });
    this.svg.append(text);
  }

  showPlaces(t) {
    const { series, plot } = this.view;
    const { xaxis, yaxis } = plot._fullLayout;
    for (const trace of this.shownTraces().filter((candidate) => candidate.t !== undefined)) {
      const at = nearestIndex(series[trace.t], t);
      if (at >= 0) {
        const { color } = lookOf(trace.style, currentTheme());
        this.svg.append(svgElement('circle', {
          class: 'cursor-dot', r: 6, fill: color,
          cx: xaxis._offset + xaxis.c2p(series[trace.x][at]), cy: yaxis._offset + yaxis.c2p(series[trace.y][at]),
        }));
      }
    }
  }
}

/** The mark in space is a trace of its own, the last one of the plot. */
function showInSpace(view, t) {
  const { figure, series, plot } = view;
  const places = { x: [], y: [], z: [], color: [] };
  for (const trace of figure.traces.filter((candidate) => candidate.t !== undefined && !view.view.hidden.has(candidate.style))) {
    const at = t === null ? -1 : nearestIndex(series[trace.t], t);
    if (at >= 0) {
      ['x', 'y', 'z'].forEach((axis) => places[axis].push(series[trace[axis]][at]));
      places.color.push(lookOf(trace.style, currentTheme()).color);
    }
  }
  return Plotly.restyle(plot, {
    x: [places.x], y: [places.y], z: [places.z], 'marker.color': [places.color],
  }, [figure.traces.length]);
}

/** The instant of a page, its bar with the slider, and the figures that show it. */
class Cursor {
  constructor(views) {
    this.views = [...views].filter(({ figure }) => isOverTime(figure) || isPath(figure));
    this.t = null;
    this.under = null;  // the figure under the pointer
    const times = this.views.filter(({ figure }) => isOverTime(figure)).flatMap(({ figure, series }) =>
      figure.traces.map((trace) => series[trace.x]).filter((x) => x.length > 0));
    this.range = [Math.min(...times.map((x) => x[0])), Math.max(...times.map((x) => x[x.length - 1]))];
    this.isOfUse = this.views.length > 1 && this.range[0] < this.range[1];
    this.overlays = new Map(this.views.filter(({ figure }) => figure.kind !== 'space').map((view) => [view, new Overlay(view)]));
    // A scene that is out of sight is not drawn anew for every instant, but when it comes back.
    this.inSight = new Set();
    this.observer = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        this.inSight[isIntersecting ? 'add' : 'delete'](target.view);
        this.mark(target.view);
      }
    });
    for (const view of this.isOfUse ? this.views : []) {
      view.drew = () => this.attach(view);
      if (view.figure.kind === 'space') {
        this.observer.observe(view.root);
      }
    }
  }

  /** The bar below the page. */
  bar() {
    const [min, max] = this.range;
    this.slider = element('input', {
      type: 'range', min, max, step: (max - min) / 1000, value: min, 'aria-label': 'Time in all figures',
      oninput: () => this.set(Number(this.slider.value)),
    });
    this.output = element('output', {}, 'time');
    this.off = element('button', { type: 'button', onclick: () => this.set(null) }, 'Off');
    this.off.hidden = true;
    document.addEventListener('keydown', (event) => event.key === 'Escape' && this.set(null));
    return element('div', { class: 'cursor-bar', role: 'group', 'aria-label': 'Time cursor' }, this.output, this.slider, this.off);
  }

  /** A figure that was drawn: what the pointer does there, and the mark, if there is one. */
  attach(view) {
    view.markedAt = null;  // what is drawn anew has no mark
    if (!view.listens) {
      view.listens = true;
      const take = (event) => this.takePointer(view, event);
      if (isOverTime(view.figure)) {
        view.plot.addEventListener('pointermove', (event) => event.pointerType === 'mouse' && take(event));
        view.plot.addEventListener('click', take);
      }
      view.plot.addEventListener('pointerleave', () => {
        this.under = null;
      });
    }
    const on = (event, take) => {
      view.plot.removeAllListeners(event);
      view.plot.on(event, take);
    };
    if (isPath(view.figure)) {
      on('plotly_hover', ({ points }) => {
        const trace = view.figure.traces[points[0].curveNumber];
        if (trace?.t !== undefined) {
          this.set(view.series[trace.t][points[0].pointNumber], view);
        }
      });
    }
    if (view.figure.kind !== 'space') {
      on('plotly_afterplot', () => this.mark(view));  // zoomed, or of another size
    }
    this.mark(view);
  }

  takePointer(view, event) {
    const axis = view.plot._fullLayout?.xaxis;
    const box = view.plot.getBoundingClientRect();
    const x = event.clientX - box.left - axis._offset;
    if (x >= 0 && x <= axis._length) {
      this.set(axis.p2c(x), event.pointerType === 'mouse' ? view : null);
    }
  }

  /** Marks t [s] in all figures; null takes the mark away. `under`: the figure that the pointer is on. */
  set(t, under = null) {
    this.t = t;
    this.under = under;
    this.off.hidden = t === null;
    this.output.textContent = t === null ? 'time' : `${t.toFixed(2)} s`;
    if (t !== null) {
      this.slider.value = t;
    }
    if (!this.waits) {
      this.waits = true;
      requestAnimationFrame(() => {
        this.waits = false;
        this.views.forEach((view) => this.mark(view));
      });
    }
  }

  mark(view) {
    if (!view.drawn) {
      return;
    }
    if (view.figure.kind === 'space') {
      if (this.inSight.has(view) && view.markedAt !== this.t) {
        view.markedAt = this.t;
        showInSpace(view, this.t);
      }
    } else if (this.t === null) {
      this.overlays.get(view).clear();
    } else {
      this.overlays.get(view).show(this.t, view !== this.under);
    }
  }
}
