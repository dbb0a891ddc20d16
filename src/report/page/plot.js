// SPDX-License-Identifier: MIT
// From a figure of the document to what Plotly draws: data and layout, for the screen and for export.

const unitText = (axis) => (axis.unit ? `${axis.title} [${axis.unit}]` : axis.title);
const axisKey = (panel) => (panel === 0 ? '' : String(panel + 1));

function traceLine(figure, trace, theme) {
  const look = lookOf(trace.style, theme);
  if (trace.shape === 'bound') {
    return { color: look.color, width: figure.kind === 'space' ? 2 : 1.3, dash: 'dot' };
  }
  return { color: look.color, width: figure.kind === 'space' ? 4 : look.width, dash: look.dash };
}

const FEW_POINTS = 20;

/** Curves of few points show them. */
function isSparse(figure, series, trace) {
  return figure.kind === 'curves' && trace.shape === 'line' && figure.x.log && series[trace.x].length <= FEW_POINTS;
}

/** The place of the page's cursor in space; empty until there is one. */
const CURSOR_IN_SPACE = {
  type: 'scatter3d', mode: 'markers', x: [], y: [], z: [], marker: { size: 5, line: { width: 1 } }, hoverinfo: 'skip', showlegend: false,
};

function plotTrace(figure, series, trace, view, theme) {
  const inSpace = figure.kind === 'space';
  const dots = trace.shape === 'dots';
  const key = axisKey(trace.panel);
  const out = {
    type: inSpace ? 'scatter3d' : 'scatter',
    name: trace.name,
    mode: dots ? 'markers' : isSparse(figure, series, trace) ? 'lines+markers' : 'lines',
    x: series[trace.x],
    y: series[trace.y],
    visible: !view.hidden.has(trace.style),
    showlegend: trace.shape !== 'bound' && figure.traces.find((t) => t.style === trace.style) === trace,
    legendgroup: trace.style,
    hoverinfo: trace.shape === 'bound' && inSpace ? 'skip' : 'all',
  };
  if (inSpace) {
    out.z = series[trace.z];
  } else {
    Object.assign(out, { yaxis: `y${key}`, connectgaps: false });
  }
  if (dots) {
    out.marker = { color: lookOf(trace.style, theme).color, size: inSpace ? 1.8 : 3.5, opacity: inSpace ? 0.8 : 0.65 };
  } else {
    out.line = traceLine(figure, trace, theme);
  }
  return out;
}

function baseAxis(theme, title) {
  const colors = THEMES[theme];
  return {
    title: { text: title, standoff: 8, font: { size: 13 } },
    gridcolor: colors.grid, linecolor: colors.line, zerolinecolor: colors.line, tickcolor: colors.line,
    showline: true, mirror: true, ticks: 'outside', ticklen: 4, automargin: true,
    exponentformat: 'power', hoverformat: '.4~g', tickfont: { size: 12 },
  };
}

function spaceLayout(figure, theme) {
  const colors = THEMES[theme];
  const axis = (a) => ({
    title: { text: unitText(a), font: { size: 12 } }, gridcolor: colors.grid, zerolinecolor: colors.line,
    color: colors.quiet, showbackground: false, showspikes: false, hoverformat: '.4~g',
  });
  return {
    scene: {
      xaxis: axis(figure.x), yaxis: axis(figure.y[0]), zaxis: axis(figure.y[1]),
      aspectmode: 'data', dragmode: 'turntable', camera: { eye: { x: 1.1, y: -1.25, z: 0.85 }, center: { x: 0, y: 0, z: -0.2 } },
    },
  };
}

/** Smallest and largest number along 'x', 'y' or 'z' of all traces. */
function extentOf(figure, series, direction) {
  let [low, high] = [Infinity, -Infinity];
  for (const trace of figure.traces) {
    for (const value of series[trace[direction]]) {
      if (Number.isFinite(value)) {
        [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
    }
  }
  return [low, high];
}

/** Curves fill the width: no room left and right of the first and the last sample. */
function fullWidth(figure, series) {
  const [minallowed, maxallowed] = extentOf(figure, series, 'x');
  return minallowed < maxallowed ? { minallowed, maxallowed } : {};
}

/** A tick at each of the few lengths that a logarithmic axis has. */
function roundTicks(figure, series) {
  const values = [...new Set(figure.traces.flatMap((trace) => [...series[trace.x]]))].sort((a, b) => a - b);
  return { tickmode: 'array', tickvals: values, ticktext: values.map((value) => String(Number(value.toPrecision(3)))) };
}

/** Decades that the shown curves of a panel span; 0 if nothing positive is shown. */
function decadesOf(figure, series, view, panel) {
  let [low, high] = [Infinity, 0];
  for (const trace of figure.traces.filter((t) => t.panel === panel && !view.hidden.has(t.style))) {
    for (const value of series[trace.y]) {
      if (value > 0) {
        [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
    }
  }
  return high > low ? Math.log10(high / low) : 0;
}

function planeLayout(figure, series, view, theme) {
  const panels = figure.y.length;
  const gap = panels > 1 ? 0.045 : 0;
  const height = (1 - gap * (panels - 1)) / panels;
  const last = axisKey(panels - 1);
  const layout = { xaxis: { ...baseAxis(theme, unitText(figure.x)), anchor: `y${last}` } };
  figure.y.forEach((axis, panel) => {
    const decades = view.log ? decadesOf(figure, series, view, panel) : 0;
    const top = 1 - panel * (height + gap);
    layout[`yaxis${axisKey(panel)}`] = {
      ...baseAxis(theme, unitText(axis)),
      domain: [Math.max(0, top - height), top],
      type: view.log ? 'log' : 'linear',
      rangemode: figure.log_switch ? 'tozero' : 'normal',
      nticks: panels > 1 ? 5 : 8,
      ...(decades > 1.7 ? { dtick: Math.ceil(decades / 8) } : {}),
    };
  });
  if (figure.kind === 'top-view') {
    Object.assign(layout.yaxis, { scaleanchor: 'x', scaleratio: 1, constrain: 'domain' });
    layout.xaxis.constrain = 'domain';
  } else {
    layout.hovermode = 'x unified';
    if (figure.x.log) {
      Object.assign(layout.xaxis, { type: 'log', ...roundTicks(figure, series) });
    } else {
      layout.xaxis.autorangeoptions = fullWidth(figure, series);
    }
  }
  return layout;
}

/** Pixels a figure is high on a screen `width` pixels wide. */
function plotHeight(figure, series, width) {
  const narrow = width < 480;
  if (figure.kind === 'space') {
    return narrow ? 380 : 560;
  }
  if (figure.kind === 'top-view') {
    const [[west, east], [south, north]] = ['x', 'y'].map((direction) => extentOf(figure, series, direction));
    const shape = east > west && north > south ? (north - south) / (east - west) : 1;
    return Math.max(narrow ? 220 : 260, Math.min(narrow ? 400 : 620, 90 + shape * (width - 70)));
  }
  return figure.y.length > 1 ? 80 + figure.y.length * (narrow ? 120 : 150) : narrow ? 270 : 340;
}

/**
 * What Plotly draws for a figure.
 * view: {hidden: Set of styles, log: bool}; theme: 'light' or 'dark'; touch: a finger scrolls the page.
 */
function plotOf(figure, series, view, theme, touch = false) {
  const colors = THEMES[theme];
  const inSpace = figure.kind === 'space';
  return {
    data: [...figure.traces.map((trace) => plotTrace(figure, series, trace, view, theme)), ...(inSpace ? [{ ...CURSOR_IN_SPACE }] : [])],
    layout: {
      ...(inSpace ? spaceLayout(figure, theme) : planeLayout(figure, series, view, theme)),
      font: { family: FONT, size: 13, color: colors.ink },
      paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
      margin: inSpace ? { l: 0, r: 0, t: 30, b: 0 } : { l: 50, r: 10, t: 34, b: 40 },
      showlegend: false,
      dragmode: inSpace ? 'turntable' : touch ? false : 'zoom',
      hoverlabel: { bgcolor: colors.card, bordercolor: colors.line, font: { color: colors.ink, size: 12 } },
      modebar: { bgcolor: 'rgba(0,0,0,0)', color: colors.quiet, activecolor: colors.ink },
      uirevision: view.log ? 'log' : 'linear',  // a zoom survives a change of theme, not one of scale
    },
  };
}

/** The same for a paper: black on white, with a legend, whatever the screen shows. */
function paperPlotOf(figure, series, view, camera) {
  const plot = plotOf(figure, series, view, 'light');
  Object.assign(plot.layout, {
    paper_bgcolor: '#ffffff', plot_bgcolor: '#ffffff', showlegend: true,
    font: { family: 'Arial, Helvetica, sans-serif', size: 14, color: '#000000' },
    legend: { orientation: 'h', x: 0, y: 1.02, yanchor: 'bottom', font: { size: 13 } },
    margin: figure.kind === 'space' ? { l: 0, r: 0, t: 40, b: 0 } : { l: 60, r: 16, t: 40, b: 48 },
  });
  if (camera) {
    plot.layout.scene.camera = camera;
  }
  return plot;
}
