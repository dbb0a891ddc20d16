// SPDX-License-Identifier: MIT
// The page of a run that works: takes frames from the program and shows the newest, or one that was before.
import { FormerMap, History, Path } from './history.js';
import { fixed, floatsOf } from './numbers.js';
import { showCalibration, showStages, showState, showVerdict } from './panels.js';
import { Pictures } from './pictures.js';
import { SpaceView } from './scene.js';

const at = (id) => document.getElementById(id);

class Page {
  constructor() {
    this.pictures = new Pictures([at('left'), at('right')]);
    try {
      this.space = new SpaceView(at('space'));
    } catch (error) {
      at('space').append(Object.assign(document.createElement('p'), { textContent: `No 3-D here: ${error.message}` }));
    }
    this.history = new History();
    this.path = new Path();
    this.formerMap = new FormerMap();
    this.chosen = null;  // the frame that the reader went back to; null: the newest
    this.received = [];  // numbers of the latest frames, for tests
    this.leftOut = 0;
    this.paused = false;
    this.inTime = false;
  }

  begin({ run, path, viewer }) {
    const again = this.run !== undefined;
    this.run = run;
    this.viewer = viewer;
    this.path = new Path(floatsOf(path));
    document.title = `${run.title}, ${run.method}: limber`;
    at('title').textContent = `${run.title} · ${run.method}`;
    if (!again) {
      this.space?.begin(run);
      showVerdict(at('verdict'), null);
      showCalibration(document.querySelector('.gauges'), run, null);
    }
  }

  add(frame) {
    frame.points.uv = floatsOf(frame.points.uv);
    frame.map.p = floatsOf(frame.map.p);
    if (!frame.waiting) {
      this.endWaiting();
    }
    const last = this.history.frames.at(-1);
    if (last && frame.n <= last.n) {
      return;
    }
    this.leftOut += last && !frame.waiting ? frame.n - last.n - 1 : 0;
    this.received.push(frame.n);
    this.received.splice(0, this.received.length - 1000);
    this.history.add(frame);
    if (!frame.waiting) {
      this.path.add(frame.t, frame.p);
      this.formerMap.add(frame.map);
    }
  }

  /** The frames that a start has taken in come again, with poses. */
  endWaiting() {
    if (this.history.frames.at(-1)?.waiting) {
      this.history = new History();
      this.chosen = null;
    }
  }

  get shown() {
    return this.chosen ?? this.history.frames.at(-1);
  }

  /** Where the shown frame stands in the history, or would if it had not been thinned out. */
  get index() {
    return this.history.frames.findIndex((frame) => frame.n >= this.shown.n);
  }

  /** Draws what is to be seen now. */
  async draw() {
    const frame = this.shown;
    if (!frame) {
      return;
    }
    const { frames } = this.history;
    const index = this.index;
    const before = frames.slice(Math.max(0, index - 20), index);
    showVerdict(at('verdict'), frame.health);
    showCalibration(document.querySelector('.gauges'), this.run, frame.health);
    showState(document.querySelector('#state .facts'), frame);
    showStages(document.querySelector('#stages .bars'), [...before, frame]);
    this.space?.show(frame, this.path, this.formerMap);
    this.showControls();
    await this.pictures.draw(frame, contiguous(before, frame), this.run.cameras);
  }

  showControls() {
    at('seek').max = this.history.frames.length - 1;
    at('seek').value = this.index;
    const frame = this.shown;
    at('place').textContent = `frame ${frame.n} of ${this.run.frames} · ${fixed(frame.t, 2)} s`;
    at('newest').setAttribute('aria-pressed', String(this.chosen === null));
    at('shown').textContent = this.leftOut > 0 ? `${this.leftOut} frames of the run were not shown: it is faster than the page` : '';
  }

  choose(index) {
    const { frames } = this.history;
    this.chosen = index >= frames.length - 1 ? null : frames[Math.max(0, index)];
    return this.draw();
  }
}

/** The frames right before one, as far as none is left out. */
function contiguous(before, frame) {
  let begin = before.length;
  for (let next = frame.n; begin > 0 && next - before[begin - 1].n === 1; --begin) {
    next = before[begin - 1].n;
  }
  return before.slice(begin);
}

/** Frames from the program behind the page, and what the page asks of it. */
class Live {
  constructor(page) {
    this.page = page;
    this.source = new EventSource('events?acknowledge=1');
    const on = (name, take) =>
      this.source.addEventListener(name, (event) => take(JSON.parse(event.data), Number(event.lastEventId)));
    on('hello', (hello) => {
      page.begin(hello);
      this.setControl(hello);
      this.setConnection('live');
    });
    on('frame', (frame, sequence) => {
      page.add(frame);
      this.show(sequence);
    });
    on('control', (control) => this.setControl(control));
    on('end', ({ message, path }) => {
      this.ended = true;
      page.path = new Path(floatsOf(path));
      this.say(message);
      this.setConnection('the run is over');
      for (const id of ['pause', 'step', 'in-time']) {
        at(id).hidden = true;
      }
      at('dismiss').hidden = false;
      page.draw();
    });
    this.source.addEventListener('error', () => {
      if (this.ended) {
        this.source.close();
        this.setConnection('the program has ended');
      } else {
        this.setConnection('connection lost, trying again');
      }
    });
    at('pause').addEventListener('click', () => this.ask(page.paused ? (page.inTime ? 'time' : 'run') : 'pause'));
    at('step').addEventListener('click', () => this.ask('step'));
    at('in-time').addEventListener('click', () => this.ask(page.inTime ? 'run' : 'time'));
    at('dismiss').addEventListener('click', () => this.ask('dismiss'));
  }

  /** Draws at the screen's pace and tells the program: what comes meanwhile waits there, or is left out. */
  show(sequence) {
    const done = () => fetch(`shown?viewer=${this.page.viewer}&frame=${sequence}`, { method: 'POST' }).catch(() => {});
    if (document.hidden) {
      done();
      return;
    }
    requestAnimationFrame(async () => {
      if (this.page.chosen === null) {
        await this.page.draw();
      } else {
        this.page.showControls();
      }
      done();
    });
  }

  ask(what) {
    return fetch(`control?do=${what}`, { method: 'POST' }).catch(() => this.setConnection('connection lost'));
  }

  setControl({ paused, in_time: inTime }) {
    Object.assign(this.page, { paused, inTime });
    at('pause').textContent = paused ? 'Run' : 'Pause';
    at('in-time').setAttribute('aria-pressed', String(inTime));
    document.body.classList.toggle('paused', paused);
  }

  setConnection(text) {
    at('connection').textContent = text;
  }

  say(text) {
    at('message').textContent = text;
    at('message').hidden = text === '';
  }
}

const PLAY_MS = 80;  // a frame

/** Frames that stand in the page itself: they are played, and nobody is asked. */
class Recorded {
  constructor(page, { run, path, frames, message }) {
    this.page = page;
    page.begin({ run, path });
    page.history.complete = true;
    frames.forEach((frame) => page.add(frame));
    page.leftOut = 0;
    at('connection').textContent = `recorded: ${frames.length} frames of the run`;
    at('message').textContent = message;
    at('message').hidden = false;
    at('in-time').hidden = at('newest').hidden = true;
    this.turn = 0;
    at('pause').addEventListener('click', () => this.play(!this.playing));
    at('step').addEventListener('click', () => {
      this.play(false);
      page.choose(page.index + 1);
    });
    at('seek').addEventListener('input', () => this.play(false));
    this.play(false);
    page.choose(Infinity);  // the answer: where the run came to
  }

  /** Plays from the shown frame, or from the first if it is the last; or stops. */
  async play(on) {
    const turn = ++this.turn;
    const set = (playing) => {
      this.playing = playing;
      at('pause').textContent = playing ? 'Pause' : 'Play';
    };
    set(on);
    if (on && this.page.chosen === null) {
      await this.page.choose(0);
    }
    while (this.turn === turn && this.playing && this.page.chosen !== null) {
      await Promise.all([this.page.choose(this.page.index + 1), new Promise((done) => setTimeout(done, PLAY_MS))]);
    }
    if (this.turn === turn) {
      set(false);
    }
  }
}

const darkSystem = window.matchMedia('(prefers-color-scheme: dark)');

// Light or dark: as the system says, until the reader says otherwise.
function setTheme(theme, page) {
  document.documentElement.dataset.theme = theme;
  at('theme').setAttribute('aria-pressed', String(theme === 'dark'));
  at('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
  page.space?.setTheme();
  return page.draw();
}

function addControls(page) {
  at('seek').addEventListener('input', () => page.choose(Number(at('seek').value)));
  at('newest').addEventListener('click', () => page.choose(Infinity));
  at('follow').addEventListener('click', () => {
    if (page.space) {
      page.space.follows = !page.space.follows;
      at('follow').setAttribute('aria-pressed', String(page.space.follows));
      page.draw();
    }
  });
  at('above').addEventListener('click', () => {
    page.space?.look(!page.space.fromAbove);
    at('above').setAttribute('aria-pressed', String(page.space?.fromAbove ?? false));
  });
  at('theme').addEventListener('click', () =>
    setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark', page));
  darkSystem.addEventListener('change', () => setTheme(darkSystem.matches ? 'dark' : 'light', page));
  window.addEventListener('resize', () => page.draw());
}

const page = new Page();
addControls(page);
setTheme(darkSystem.matches ? 'dark' : 'light', page);
const recorded = at('view-data').textContent;
const source = recorded.startsWith('{') ? new Recorded(page, JSON.parse(recorded)) : new Live(page);
window.limberView = { page, source };  // for scripts and tests
