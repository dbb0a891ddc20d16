// SPDX-License-Identifier: MIT
// The page: reads the document beside it, builds sections, draws figures when they come into view.

function currentTheme() {
  return document.documentElement.dataset.theme;
}

const VERDICTS = { 'agrees': ['agrees', '✓ '], 'does not agree': ['disagrees', '✗ '], 'not measured': ['open', ''] };

const BLOCKS = {
  text: (block) => element('p', {}, block.text),
  listing: (block) => element('details', { class: 'listing' }, element('summary', {}, block.title), element('pre', {}, block.text)),
  facts: (block) => element('div', {}, ...heading(block.title), factList(block.facts, 'facts')),
  table: (block) => tableOf(block),
  claims: (block) => element('div', { class: block.brief ? 'claims brief' : 'claims' }, ...heading(block.title),
    element('ol', {}, ...block.claims.map(block.brief ? briefClaimOf : claimOf))),
  figure: (block, page) => {
    const view = new FigureView(block, page.document.series);
    page.figures.set(block.id, view);
    view.refresh();
    page.watch(view);
    return view.root;
  },
};

function heading(title) {
  return title ? [element('h3', {}, title)] : [];
}

function factList(facts, name) {
  return element('dl', { class: name }, ...facts.map((fact) =>
    element('div', {}, element('dt', {}, fact.name), element('dd', {}, fact.value))));
}

function tableOf(block) {
  const row = (cells) => element('tr', {}, ...cells.map((cell, k) =>
    element('td', cell.mark ? { class: cell.mark } : {}, ...(k === 0 ? breakable(cell.text) : [cell.text]))));
  return element('div', { class: 'table' }, ...heading(block.title),
    element('div', { class: 'scroll', tabindex: '0', role: 'group', 'aria-label': block.title || 'Table' },
      element('table', block.columns.length > 11 ? { class: 'wide' } : {},
        element('thead', {}, element('tr', {}, ...block.columns.map((name) => element('th', { scope: 'col' }, ...breakable(name))))),
        element('tbody', {}, ...block.rows.map(row)))),
    ...(block.note ? [element('p', { class: 'note' }, block.note)] : []));
}

/** A name may break after a colon or a plus, as in 'lcekf:rotation+direction', but not within '5e-07'. */
function breakable(name) {
  return name.split(/(?<=[:+])/).flatMap((part) => [
    /\de-\d/.test(part) ? element('span', { class: 'whole' }, part) : part, element('wbr')]);
}

/** Several results, a line each. */
function linesOf(text) {
  return text.split('\n').flatMap((line, k) => [...(k > 0 ? ['\n'] : []), element('span', {}, line)]);
}

function claimOf(claim) {
  const [name, sign] = VERDICTS[claim.verdict];
  return element('li', { class: name },
    element('div', {}, element('p', {}, claim.statement), element('p', { class: 'small' }, claim.source)),
    element('div', {}, element('p', { class: 'measured' }, ...linesOf(claim.measured)), element('p', { class: 'small' }, claim.criterion)),
    element('span', { class: 'verdict' }, sign + claim.verdict));
}

function briefClaimOf(claim) {
  const [name, sign] = VERDICTS[claim.verdict];
  return element('li', { class: name }, element('span', { class: 'verdict' }, sign + claim.verdict),
    element('p', {}, claim.statement), element('p', { class: 'small' }, claim.source));
}

/** The answer: its lamp, why, and what to do. */
function answerOf({ light, headline, sentences, advice }) {
  const say = (sentence) => element('p', {}, sentence);
  return element('div', { id: 'answer', class: `light ${light}` },
    element('p', { class: 'headline' }, ...(light ? [element('span', { class: 'lamp' })] : []), element('strong', {}, headline)),
    ...sentences.slice(0, 1).map(say), ...(advice ? [element('p', { class: 'advice' }, element('b', {}, 'What to do: '), advice)] : []),
    ...sentences.slice(1).map(say));
}

class Page {
  constructor(data) {
    this.document = data;
    this.figures = new Map();
    this.observer = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (entry.isIntersecting && !entry.target.view.drawn) {
          entry.target.view.draw();
        }
      }
    }, { rootMargin: '400px' });
  }

  watch(view) {
    view.root.view = view;
    this.observer.observe(view.root);
  }

  build() {
    const { title, subtitle, answer, facts, sections, footer } = this.document;
    document.getElementById('title').textContent = title;
    document.getElementById('subtitle').textContent = subtitle;
    if (answer) {
      document.getElementById('facts').before(answerOf(answer));
    }
    document.getElementById('facts').replaceWith(factList(facts, 'facts lead'));
    document.getElementById('footer').textContent = footer;
    document.getElementById('sections').replaceChildren(...sections.map((section) => this.section(section)));
    this.buildContents(sections);
    this.cursor = new Cursor(this.figures.values());
    if (this.cursor.isOfUse) {
      document.body.append(this.cursor.bar());
    }
  }

  section({ id, title, blocks }) {
    return element('section', { id }, element('h2', {}, title),
      element('div', { class: 'blocks' }, ...blocks.map((block) => BLOCKS[block.type](block, this))));
  }

  buildContents(sections) {
    if (sections.length < 4) {
      return;
    }
    const wide = window.matchMedia('(min-width: 1100px)');
    const details = element('details', {}, element('summary', {}, 'Contents'),
      element('ul', {}, ...sections.map(({ id, title }) => element('li', {}, element('a', { href: `#${id}` }, title)))));
    const fit = () => details.toggleAttribute('open', wide.matches);
    wide.addEventListener('change', fit);
    fit();
    document.getElementById('contents').append(details);
    document.querySelector('.columns').classList.add('with-contents');
  }

  refresh() {
    return Promise.all([...this.figures.values()].map((view) => view.refresh()));
  }
}

// Light or dark: as the system says, until the reader says otherwise.
const darkSystem = window.matchMedia('(prefers-color-scheme: dark)');

function setTheme(theme, page) {
  document.documentElement.dataset.theme = theme;
  const button = document.getElementById('theme');
  button.setAttribute('aria-pressed', String(theme === 'dark'));
  button.textContent = theme === 'dark' ? 'Light' : 'Dark';
  return page.refresh();
}

const PRINT_WIDTH = 640;  // pixels of 1/96 inch: fits A4 and Letter with wide margins

/** Paper is white and narrow: light colours while the page is printed, figures drawn (those in space only if
 *  they were on the screen, since WebGL takes its time), wide ones scaled. */
function drawForPrint(page) {
  let before = currentTheme();
  window.addEventListener('beforeprint', () => {
    before = currentTheme();
    setTheme('light', page);
    for (const view of page.figures.values()) {
      if (!view.drawn && view.figure.kind !== 'space') {
        view.draw();
      }
      view.root.hidden = !view.drawn;
      view.plot.style.zoom = Math.min(1, PRINT_WIDTH / view.plot.clientWidth);
    }
  });
  window.addEventListener('afterprint', () => {
    for (const view of page.figures.values()) {
      view.root.hidden = false;
      view.plot.style.zoom = '';
    }
    setTheme(before, page);
  });
}

/** 32-bit floats, little-endian, from base64; NaN is a gap. */
function decodeSeries(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length / 4 }, (_, k) => view.getFloat32(4 * k, true));
}

function start() {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  data.series = data.series.map(decodeSeries);
  const page = new Page(data);
  document.documentElement.dataset.theme = darkSystem.matches ? 'dark' : 'light';
  page.build();
  setTheme(currentTheme(), page);
  darkSystem.addEventListener('change', () => setTheme(darkSystem.matches ? 'dark' : 'light', page));
  document.getElementById('theme').addEventListener('click', () =>
    setTheme(currentTheme() === 'dark' ? 'light' : 'dark', page));
  drawForPrint(page);
  // For scripts: the document, and any figure as an image for a paper (docs/report.md).
  const view = (id) => {
    if (!page.figures.has(id)) {
      throw new Error(`this report has no figure '${id}'`);
    }
    return page.figures.get(id);
  };
  window.limberReport = {
    document: page.document,
    figures: () => [...page.figures.values()].map(({ figure }) => ({
      id: figure.id, title: figure.title, variants: figure.variants.map((v) => v.label) })),
    plot: (id) => view(id).plot,
    draw: (id) => view(id).draw(),
    mark: (t) => page.cursor.set(t),
    image: (id, format, size, { variant, log } = {}) => {
      if (variant) {
        view(id).show(variant);
      }
      if (log !== undefined) {
        view(id).change({ log });
      }
      return view(id).image(format, size);
    },
  };
}

start();
