// SPDX-License-Identifier: MIT
// One figure on the page: its head with switches, its legend, its plot.

/** element('p', {class: 'note'}, 'text', child...): text is text, never markup. */
function element(name, attributes = {}, ...children) {
  const out = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) {
      out.addEventListener(key.slice(2), value);
    } else {
      out.setAttribute(key, value);
    }
  }
  out.append(...children);
  return out;
}

const SVG_ICON = {
  width: 24, height: 24,
  path: 'M3 3h12l6 6v12H3zM14 4v6h6M6 18l4-6 3 4 2-2 3 4z',
};
const EXPORT_SIZE = { width: 900, height: 560 };
const MAX_LIVE_SCENES = 6;  // browsers keep no more than 16 WebGL contexts alive
const liveScenes = [];

class FigureView {
  constructor(figure, series) {
    this.figure = figure;
    this.series = series;
    this.view = { hidden: new Set(figure.variants[0]?.hidden_styles), log: figure.starts_in_log };
    this.drew = null;  // called after each time that the plot was drawn
    this.plot = element('div', { class: 'plot' });
    this.legend = element('div', { class: 'legend', role: 'group', 'aria-label': 'Curves' });
    this.tools = element('div', { class: 'figure-tools' });
    this.root = element('figure', { id: figure.id, class: figure.half_width ? 'half' : '' },
      element('div', { class: 'figure-head' }, element('h3', {}, figure.title), this.tools),
      this.legend, this.plot,
      element('figcaption', {}, ...[figure.caption, figure.note].filter(Boolean).map((t) => element('p', {}, t))));
    this.plot.style.minHeight = `${plotHeight(figure, series, Math.min(window.innerWidth, 700))}px`;
    this.addTools();
    this.addLegend();
  }

  addTools() {
    if (this.figure.variants.length > 0) {
      this.variantButtons = this.figure.variants.map((variant) => element('button', {
        type: 'button', 'aria-pressed': 'false', onclick: () => this.show(variant.label),
      }, variant.label));
      this.tools.append(element('div', { class: 'segments', role: 'group', 'aria-label': 'Curves shown' }, ...this.variantButtons));
    }
    if (this.figure.log_switch) {
      this.logButton = element('button', {
        type: 'button', class: 'log', onclick: () => this.change({ log: !this.view.log }),
      }, 'log scale');
      this.tools.append(this.logButton);
    }
  }

  addLegend() {
    this.legendButtons = new Map();
    for (const trace of this.figure.traces) {
      if (trace.shape === 'bound' || this.legendButtons.has(trace.style)) {
        continue;
      }
      const button = element('button', { type: 'button', onclick: () => this.toggle(trace.style) });
      this.legendButtons.set(trace.style, { button, trace });
      this.legend.append(button);
    }
  }

  /** One of the figure's variants, by its label. */
  show(label) {
    const variant = this.figure.variants.find((v) => v.label === label);
    if (!variant) {
      throw new Error(`${this.figure.id} has no variant '${label}', but: ${this.figure.variants.map((v) => v.label).join(', ')}`);
    }
    this.change({ hidden: new Set(variant.hidden_styles) });
  }

  toggle(style) {
    const hidden = new Set(this.view.hidden);
    if (!hidden.delete(style)) {
      hidden.add(style);
    }
    this.change({ hidden });
  }

  change(part) {
    Object.assign(this.view, part);
    return this.refresh();
  }

  /** Switches and legend as they are now, and the plot, if it has been drawn before. */
  refresh() {
    const hidden = this.view.hidden;
    this.logButton?.setAttribute('aria-pressed', String(this.view.log));
    this.variantButtons?.forEach((button, k) => {
      const styles = this.figure.variants[k].hidden_styles;
      button.setAttribute('aria-pressed', String(styles.length === hidden.size && styles.every((s) => hidden.has(s))));
    });
    for (const [style, { button, trace }] of this.legendButtons) {
      button.setAttribute('aria-pressed', String(!hidden.has(style)));
      button.innerHTML = sampleOf(trace, currentTheme());
      button.append(trace.name);
    }
    return this.drawn ? this.draw() : Promise.resolve();
  }

  draw() {
    this.drawn = true;
    const touch = window.matchMedia('(pointer: coarse)').matches;
    const { data, layout } = plotOf(this.figure, this.series, this.view, currentTheme(), touch);
    layout.height = plotHeight(this.figure, this.series, this.plot.clientWidth);
    if (this.figure.kind === 'space') {
      this.claimScene();
    }
    return Plotly.react(this.plot, data, layout, this.config()).then(() => this.drew?.());
  }

  config() {
    const inSpace = this.figure.kind === 'space';
    return {
      responsive: true, displaylogo: false, displayModeBar: true, scrollZoom: inSpace,
      modeBarButtons: [
        inSpace ? ['pan3d', 'orbitRotation', 'tableRotation', 'resetCameraDefault3d']
          : ['zoom2d', 'pan2d', 'zoomIn2d', 'zoomOut2d', 'resetScale2d'],
        [{ name: 'svg', title: 'Save as SVG', icon: SVG_ICON, click: () => this.save('svg') },
          { name: 'png', title: 'Save as PNG', icon: Plotly.Icons.camera, click: () => this.save('png') }],
      ],
    };
  }

  /** A 3-D figure needs a WebGL context; the one drawn longest ago gives its own back. */
  claimScene() {
    const at = liveScenes.indexOf(this);
    if (at >= 0) {
      liveScenes.splice(at, 1);
    }
    liveScenes.push(this);
    if (liveScenes.length > MAX_LIVE_SCENES) {
      const oldest = liveScenes.shift();
      Plotly.purge(oldest.plot);
      oldest.drawn = false;
    }
  }

  /** The figure for a paper, as shown but black on white and with a legend: a data URL. */
  image(format, size = EXPORT_SIZE) {
    const camera = this.figure.kind === 'space' ? this.plot.layout?.scene?.camera : undefined;
    const plot = paperPlotOf(this.figure, this.series, this.view, camera);
    return Plotly.toImage(plot, { format, scale: format === 'png' ? 3 : 1, ...EXPORT_SIZE, ...size });
  }

  async save(format) {
    const link = element('a', { href: await this.image(format), download: `${this.figure.id}.${format}` });
    link.click();
  }
}

/** A short piece of a curve, for the legend. */
function sampleOf(trace, theme) {
  const { color, dash, width } = lookOf(trace.style, theme);
  if (trace.shape === 'dots') {
    return `<svg width="14" height="10" aria-hidden="true"><circle cx="7" cy="5" r="3.5" fill="${color}"/></svg>`;
  }
  const pattern = { solid: '', dash: '6 4', longdash: '9 4', dashdot: '6 3 2 3', longdashdot: '9 3 2 3' }[dash];
  return '<svg width="26" height="10" aria-hidden="true">' +
    `<path d="M1 5h24" stroke="${color}" stroke-width="${width + 0.7}" stroke-dasharray="${pattern}"/></svg>`;
}
