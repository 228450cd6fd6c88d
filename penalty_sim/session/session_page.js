// Light or dark as the system has it, until the button is used.
const root = document.documentElement, darkSystem = matchMedia('(prefers-color-scheme: dark)');
const redraws = [], panes = [];
const setTheme = dark => { root.dataset.theme = dark ? 'dark' : 'light'; redraws.forEach(draw => draw()); };
setTheme(darkSystem.matches);
darkSystem.addEventListener('change', () => setTheme(darkSystem.matches));
document.getElementById('theme').addEventListener('click', () => setTheme(root.dataset.theme !== 'dark'));
addEventListener('beforeprint', () => { panes.forEach(pane => { pane.visible = true; }); setTheme(false); });

const colour = name => getComputedStyle(root).getPropertyValue('--' + name).trim();
const DASHES = [[], [6, 4], [2, 3]];
const LEFT = 58, RIGHT = 8, HEIGHT = 150, BELOW = 20;  // of a plot [px]
const LEAST_SPAN = 0.004;                              // that zooming ends at [s]

const element = (tag, parent, properties = {}) => parent.appendChild(Object.assign(document.createElement(tag), properties));
const shownNumber = value => value === null || Number.isNaN(value) ? '–' : Math.abs(value) >= 1e5 || (value !== 0 && Math.abs(value) < 1e-3)
  ? value.toExponential(2) : value.toPrecision(4).replace('-', '−');

async function inflate(base64) {
  const text = atob(base64), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);  // Uint8Array.from takes five times as long
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Planes of low and high bytes of differences; see session_series.py.
function unpack(bytes, data) {
  const count = data.points, planes = data.bin > 1 ? 2 : 1;
  let at = 0;
  const plane = (least, step) => {
    const values = new Float32Array(count);
    let level = 0;
    for (let i = 0; i < count; ++i) {
      level = (level + (bytes[at + i] | bytes[at + count + i] << 8)) << 16 >> 16;
      values[i] = level === -32768 ? NaN : least + step * (level + 32767);
    }
    at += 2 * count;
    return values;
  };
  return data.ranges.map(([least, step]) => {
    const low = plane(least, step);
    return {low, high: planes > 1 ? plane(least, step) : low};
  });
}

// Powers of ten for an axis of logarithms.
function decadesOf(low, high) {
  const ticks = [];
  for (let i = Math.ceil(low); i <= high; ++i) ticks.push(i);
  return {ticks, label: tick => String(10 ** tick)};
}

// Round numbers for an axis: about `count` of them.
function ticksOf(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(factor => factor * power >= rough);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9 * step; ++i) ticks.push(i * step);
  return {ticks, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

class Trace {
  constructor(about, data, series) {
    Object.assign(this, about);
    if (about.x) {
      this.low = this.high = Float32Array.from(about.y);
      this.index = t => { let a = 0, b = about.x.length; while (a < b) { const m = (a + b) >> 1; about.x[m] < t ? a = m + 1 : b = m; } return a; };
      this.time = i => about.x[i];
    } else {
      ({low: this.low, high: this.high} = series[about.series]);
      this.index = t => Math.max(0, Math.min(this.low.length, Math.ceil(t / data.period)));
      this.time = i => i * data.period;
    }
  }
  range(t0, t1) {
    let low = Infinity, high = -Infinity;
    for (let i = Math.max(0, this.index(t0) - 1), end = Math.min(this.low.length, this.index(t1) + 1); i < end; ++i) {
      if (this.low[i] < low) low = this.low[i];
      if (this.high[i] > high) high = this.high[i];
    }
    return [low, high];
  }
  value(t) {  // the latest point
    const i = Math.min(this.low.length, this.index(t + 1e-9)) - 1, at = this.time(i + 1) <= t + 1e-9 ? i + 1 : i;
    return at < 0 || at >= this.low.length ? NaN : this.high[at] + (this.low[at] - this.high[at]) / 2;
  }
}

// One pane: a canvas that is drawn while it can be seen.
class Pane {
  constructor(session, height) {
    this.session = session;
    this.height = height;
    this.visible = false;
  }
  place(figure, label) {
    const pane = element('div', figure, {className: 'pane'});
    this.canvas = element('canvas', pane);
    this.nowLine = element('i', pane, {className: 'now'});
    this.canvas.style.height = this.height + 'px';
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', label);
    new IntersectionObserver(entries => { this.visible = entries.at(-1).isIntersecting; if (this.visible) this.draw(); },
      {rootMargin: '600px'}).observe(this.canvas);  // drawn before it is scrolled to
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.session.listen(this);
  }
  begin() {
    const ratio = devicePixelRatio || 1, width = this.canvas.clientWidth;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    const g = this.canvas.getContext('2d');
    g.scale(ratio, ratio);
    g.font = '11px system-ui, sans-serif';
    this.width = width - LEFT - RIGHT;
    return g;
  }
  // The line of the time that the picture shows; beside the canvas, so that playing redraws no curve.
  moveNow() {
    const {now, t0, t1} = this.session, style = this.nowLine.style;
    style.display = now >= t0 && now <= t1 ? '' : 'none';
    style.left = `calc(${LEFT}px + (100% - ${LEFT + RIGHT}px) * ${(now - t0) / (t1 - t0)})`;
  }
  x(t) { const {t0, t1} = this.session; return LEFT + this.width * (t - t0) / (t1 - t0); }
  timeAt(clientX) {
    const {t0, t1} = this.session, box = this.canvas.getBoundingClientRect();
    return t0 + (t1 - t0) * Math.max(0, Math.min(1, (clientX - box.left - LEFT) / (box.width - LEFT - RIGHT)));
  }
  timeAxis(g, top, bottom) {
    const {t0, t1} = this.session, {ticks, digits} = ticksOf(t0, t1, Math.max(2, this.width / 90));
    g.textAlign = 'center'; g.textBaseline = 'top'; g.lineWidth = 1;
    ticks.forEach((t, i) => {
      const x = Math.round(this.x(t)) + 0.5;
      g.strokeStyle = colour('faint');
      g.beginPath(); g.moveTo(x, top); g.lineTo(x, bottom); g.stroke();
      g.fillStyle = colour('ink');
      const label = t.toFixed(digits) + (i === ticks.length - 1 ? ' s' : ''), half = g.measureText(label).width / 2;
      g.fillText(label, Math.min(x, LEFT + this.width + RIGHT - half), bottom + 4);
    });
  }
  marks(g, top, bottom) {
    const {drag, cursor} = this.session;
    if (drag) {
      g.fillStyle = colour('accent'); g.globalAlpha = 0.2;
      g.fillRect(this.x(Math.min(...drag)), top, Math.abs(this.x(drag[1]) - this.x(drag[0])), bottom - top);
      g.globalAlpha = 1;
    }
    if (cursor !== null && cursor >= this.session.t0 && cursor <= this.session.t1) {
      g.strokeStyle = colour('ink'); g.setLineDash([]); g.lineWidth = 1;
      g.beginPath(); g.moveTo(this.x(cursor), top); g.lineTo(this.x(cursor), bottom); g.stroke();
    }
  }
}

class Plot extends Pane {
  constructor(session, about, data, series) {
    super(session, HEIGHT + BELOW);
    this.about = about;
    this.traces = about.traces.map(trace => new Trace(trace, data, series));
    const figure = element('figure', session.plots), caption = element('figcaption', figure);
    element('b', caption, {textContent: `${about.title} [${about.unit}]`});
    if (about.note) element('small', caption, {textContent: about.note});
    const legend = element('div', caption, {className: 'legend'});
    for (const trace of this.traces) {
      const button = element('button', legend, {type: 'button', title: 'show or hide'});
      button.setAttribute('aria-pressed', trace.shown);
      button.innerHTML = `<svg viewBox="0 0 24 10" aria-hidden="true"><line x1="0" y1="5" x2="24" y2="5" stroke-width="2.5"
        stroke="var(--c${trace.style})" stroke-dasharray="${DASHES[trace.dash].join(' ')}"/></svg>`;
      element('span', button, {textContent: trace.name});
      trace.output = element('output', button);
      button.addEventListener('click', () => {
        trace.shown = !trace.shown;
        button.setAttribute('aria-pressed', trace.shown);
        this.draw();
      });
    }
    this.place(figure, `${about.title} over time`);
  }
  yRange(traces) {
    const {t0, t1} = this.session;
    let low = Infinity, high = -Infinity;
    for (const trace of traces) {
      const [least, greatest] = trace.range(t0, t1);
      low = Math.min(low, least); high = Math.max(high, greatest);
    }
    if (!(low <= high)) [low, high] = [0, 0];
    if (this.about.log) return [Math.log10(Math.max(low, 0.1)) - 0.1, Math.log10(Math.max(high, 1)) + 0.1];
    if (this.about.zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
    const more = Math.max(0, (this.about.span || 1e-9) - (high - low)) / 2;
    const margin = 0.06 * (high - low + 2 * more);
    return [low - more - margin, high + more + margin];
  }
  draw() {
    if (!this.visible || !this.canvas.clientWidth) return;
    const g = this.begin(), shown = this.traces.filter(trace => trace.shown), [low, high] = this.yRange(shown);
    const height = value => 4 + (HEIGHT - 4) * (high - value) / (high - low);
    const y = this.about.log ? value => height(Math.log10(Math.max(value, 1e-3))) : height;
    this.timeAxis(g, 4, HEIGHT);
    this.valueAxis(g, low, high, height);
    g.save();
    g.beginPath(); g.rect(LEFT, 0, this.width, HEIGHT); g.clip();
    for (const trace of shown) this.drawTrace(g, trace, y);
    g.restore();
    this.marks(g, 4, HEIGHT);
    this.tellValues();
  }
  tellValues() {
    const time = this.session.cursor ?? this.session.now;
    for (const trace of this.traces) trace.output.value = shownNumber(trace.value(time));
  }
  valueAxis(g, low, high, height) {
    const linear = this.about.log ? null : ticksOf(low, high, 5), isZero = tick => linear && Math.abs(tick) < 1e-12 * (high - low);
    const {ticks, label} = this.about.log ? decadesOf(low, high)
      : {ticks: linear.ticks, label: tick => (isZero(tick) ? 0 : tick).toFixed(linear.digits).replace('-', '−')};
    g.textAlign = 'right'; g.textBaseline = 'middle';
    for (const tick of ticks) {
      const at = Math.round(height(tick)) + 0.5;
      g.strokeStyle = colour(isZero(tick) ? 'c5' : 'faint');
      g.beginPath(); g.moveTo(LEFT, at); g.lineTo(LEFT + this.width, at); g.stroke();
      g.fillStyle = colour('ink');
      g.fillText(label(tick), LEFT - 6, at);
    }
  }
  // Where several points share a column of pixels, the line goes through their least and their greatest.
  drawTrace(g, trace, y) {
    const {t0, t1} = this.session, from = Math.max(0, trace.index(t0) - 1), to = Math.min(trace.low.length, trace.index(t1) + 1);
    const perPixel = Math.max(1, Math.floor((to - from) / this.width));
    g.strokeStyle = colour('c' + trace.style);
    g.lineWidth = trace.dash ? 1.8 : 1.4;
    g.setLineDash(DASHES[trace.dash]);
    g.beginPath();
    let pen = false;
    for (let i = from - from % perPixel; i < to; i += perPixel) {
      let least = Infinity, greatest = -Infinity, first = NaN, last = NaN;
      for (let k = Math.max(0, i), end = Math.min(trace.low.length, i + perPixel); k < end; ++k) {
        const a = trace.low[k], b = trace.high[k];
        if (Number.isNaN(a)) continue;
        if (Number.isNaN(first)) first = a;
        last = b;
        if (a < least) least = a;
        if (b > greatest) greatest = b;
      }
      if (Number.isNaN(first)) { pen = false; continue; }
      const x = this.x(trace.time(Math.max(0, i)));
      if (pen) g.lineTo(x, y(first)); else g.moveTo(x, y(first));
      if (greatest > least) { g.lineTo(x, y(first < last ? least : greatest)); g.lineTo(x, y(first < last ? greatest : least)); g.lineTo(x, y(last)); }
      pen = true;
    }
    g.stroke();
    g.setLineDash([]);
  }
}

// Strips: solid for what sticks, hatched for what slips, so that it does not take colours to tell them apart.
class Lanes extends Pane {
  constructor(session, title, note, lanes, kinds, events = []) {
    super(session, 0);
    this.rows = lanes;
    this.events = events;
    this.row = 30;
    this.height = this.row * lanes.length + BELOW + (events.length ? 12 : 0);
    const figure = element('figure', session.plots), caption = element('figcaption', figure);
    element('b', caption, {textContent: title});
    if (note) element('small', caption, {textContent: note});
    const legend = element('div', caption, {className: 'legend'});
    for (const kind of kinds) {
      const entry = element('span', legend), swatch = element('canvas', entry);
      swatch.style.width = '24px'; swatch.width = 24; swatch.height = 10;
      element('span', entry, {textContent: kind[1]});
      const paint = () => { const g = swatch.getContext('2d'); g.clearRect(0, 0, 24, 10); this.paint(g, kind[0], 0, 0, 24, 10); };
      redraws.push(paint);
      paint();
    }
    this.place(figure, title + ' over time');
  }
  paint(g, kind, x, y, width, height) {
    const fill = {stick: 'stick', slip: 'slip', turn: 'slip', limit: 'slip', fault: 'alarm', UNCALIBRATED: 'faint', READY: 'c0', ENABLED: 'c2', REDUCED: 'slip',
      FAULT: 'alarm', DISCONNECTED: 'alarm'}[kind];
    g.fillStyle = colour(fill);
    if (kind !== 'slip') { g.fillRect(x, y, width, height); }
    if (kind !== 'slip' && kind !== 'turn') return;
    g.save();
    g.beginPath(); g.rect(x, y, width, height); g.clip();
    g.globalAlpha = 0.3; g.fillRect(x, y, width, height); g.globalAlpha = 1;
    g.strokeStyle = kind === 'turn' ? colour('stick') : g.fillStyle; g.lineWidth = 2.5;
    g.beginPath();
    for (let at = Math.floor((x - height) / 7) * 7; at < x + width + height; at += 7) { g.moveTo(at, y + height); g.lineTo(at + height, y); }
    g.stroke();
    g.restore();
  }
  draw() {
    if (!this.visible || !this.canvas.clientWidth) return;
    const g = this.begin(), bottom = this.height - BELOW, {t0, t1} = this.session;
    this.timeAxis(g, 0, bottom);
    this.rows.forEach((lane, row) => {
      const top = row * this.row;
      g.fillStyle = colour('ink'); g.textAlign = 'left'; g.textBaseline = 'top';
      g.fillText(lane.name, 2, top + 2);
      g.save();
      g.beginPath(); g.rect(LEFT, 0, this.width, bottom); g.clip();
      for (const [begin, end, kind] of lane.spells) {
        if (end < t0 || begin > t1) continue;
        const x = Math.max(LEFT - 1, this.x(begin)), right = Math.min(LEFT + this.width + 1, this.x(end));
        this.paint(g, kind, x, top + 16, Math.max(1, right - x), 10);
      }
      g.restore();
    });
    g.fillStyle = colour('ink');
    for (const [at] of this.events) {
      if (at < t0 || at > t1) continue;
      const x = this.x(at);
      g.beginPath(); g.moveTo(x, bottom - 11); g.lineTo(x - 5, bottom - 1); g.lineTo(x + 5, bottom - 1); g.fill();
    }
    this.marks(g, 0, bottom);
  }
}

class Session {
  constructor(section) {
    this.section = section;
    this.plots = section.querySelector('.plots');
    this.panes = [];
    this.cursor = this.drag = null;
    const [about, blob, view] = section.querySelectorAll('script');
    this.data = JSON.parse(about.textContent);
    this.t0 = 0;
    this.t1 = this.duration = this.data.duration;
    this.now = 0;
    this.series = null;
    this.timeline = new Timeline(this, view?.textContent);
    this.build(blob.textContent);
  }
  async build(blob) {
    this.toolbar();
    await this.timeline.opened;  // the first picture comes before the curves
    let series;
    try {
      series = this.series = unpack(await inflate(blob), this.data);
    } catch (error) {
      element('p', this.plots, {textContent: `The plots cannot be drawn: ${error.message}. A browser of 2023 or later can.`});
      return;
    }
    this.lanes();
    for (const panel of this.data.panels) if (panel.traces.length) new Plot(this, panel, this.data, series);
    this.timeline.go(this.now);  // the strings have colours now
    this.draw();
  }
  // Of a series at a time; NaN while it is not unpacked.
  valueAt(index, time) {
    if (!this.series) return NaN;
    const {low, high} = this.series[index], i = Math.min(low.length - 1, Math.floor(time / this.data.period + 1e-6));
    return low[i] + (high[i] - low[i]) / 2;
  }
  moveNow() { this.panes.forEach(pane => pane.moveNow()); }
  tellValues() { this.panes.forEach(pane => { if (pane.visible && pane.traces) pane.tellValues(); }); }
  lanes() {
    const of = group => this.data.lanes.filter(lane => lane.group === group), contacts = of('contact'), limits = of('limit');
    const kinds = new Set(this.data.lanes.flatMap(lane => lane.spells.map(spell => spell[2])));
    const named = list => list.filter(([kind]) => kinds.has(kind));
    if (contacts.length) new Lanes(this, 'contacts', '', contacts, named([['stick', 'sticks'], ['slip', 'slips'], ['turn', 'sticks and slips in turn']]));
    const events = this.data.events;
    new Lanes(this, 'state of the device', events.length ? '▲ a command: ' + [...new Set(events.map(event => event[1]))].join(', ') : '',
      of('state'), named([['UNCALIBRATED', 'uncalibrated'], ['READY', 'ready, force off'], ['ENABLED', 'force on'], ['REDUCED', 'reduced'], ['FAULT', 'fault']]), events);
    if (limits.length) new Lanes(this, 'limits and faults', 'when each of them acted', limits, named([['limit', 'limit'], ['fault', 'fault']]));
  }
  toolbar() {
    const bar = element('div', this.plots, {className: 'toolbar'});
    bar.append(this.timeline.bar);
    const button = (label, title, act) => element('button', bar, {type: 'button', textContent: label, title}).addEventListener('click', act);
    button('all', 'whole session (0)', () => this.view(0, this.duration));
    button('+', 'zoom in (+)', () => this.zoom(0.5));
    button('−', 'zoom out (−)', () => this.zoom(2));
    button('◀', 'earlier (←)', () => this.move(-0.5));
    button('▶', 'later (→)', () => this.move(0.5));
    this.output = element('output', bar);
    element('small', bar, {textContent: 'Click a plot to go there, drag over it to zoom in, double click for all; a click on a name hides it.'});
    addEventListener('keydown', event => {
      if (event.ctrlKey || event.metaKey || event.altKey || bar.getBoundingClientRect().top > innerHeight) return;
      const act = {'+': () => this.zoom(0.5), '=': () => this.zoom(0.5), '-': () => this.zoom(2), '0': () => this.view(0, this.duration),
        ArrowLeft: () => this.move(-0.25), ArrowRight: () => this.move(0.25)}[event.key];
      if (act) { act(); event.preventDefault(); }
    });
  }
  listen(pane) {
    this.panes.push(pane);
    panes.push(pane);
    redraws.push(() => pane.draw());
    const canvas = pane.canvas;
    canvas.addEventListener('pointerdown', event => {
      canvas.setPointerCapture(event.pointerId);
      this.drag = [pane.timeAt(event.clientX), pane.timeAt(event.clientX)];
    });
    canvas.addEventListener('pointermove', event => {
      this.cursor = pane.timeAt(event.clientX);
      if (this.drag) this.drag[1] = this.cursor;
      this.draw();
    });
    canvas.addEventListener('pointerup', () => {
      const drag = this.drag && [...this.drag].sort((a, b) => a - b);
      this.drag = null;
      if (drag && drag[1] - drag[0] > 0.005 * (this.t1 - this.t0)) this.view(...drag);
      else if (drag) { this.timeline.play(false); this.timeline.go(drag[0]); }
      this.draw();
    });
    canvas.addEventListener('pointercancel', () => { this.drag = null; this.draw(); });
    canvas.addEventListener('pointerleave', () => { this.cursor = null; this.draw(); });
    canvas.addEventListener('dblclick', () => this.view(0, this.duration));
    canvas.addEventListener('wheel', event => {
      if (!event.ctrlKey && !event.shiftKey) return;  // the page scrolls
      event.preventDefault();
      this.zoom((event.deltaY || event.deltaX) > 0 ? 1.25 : 0.8, pane.timeAt(event.clientX));
    }, {passive: false});
  }
  view(t0, t1) {
    const span = Math.min(this.duration, Math.max(LEAST_SPAN, t1 - t0));
    this.t0 = Math.max(0, Math.min(this.duration - span, t0));
    this.t1 = this.t0 + span;
    this.draw();
  }
  zoom(factor, at = (this.t0 + this.t1) / 2) { this.view(at - (at - this.t0) * factor, at + (this.t1 - at) * factor); }
  move(share) { const way = share * (this.t1 - this.t0); this.view(this.t0 + way, this.t1 + way); }
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const at = this.cursor === null ? '' : `, at ${this.cursor.toFixed(3)} s`;
      this.output.value = `${this.t0.toFixed(3)} to ${this.t1.toFixed(3)} s${at}`;
      this.panes.forEach(pane => pane.draw());
      this.moveNow();
    });
  }
}

window.sessions = [...document.querySelectorAll('section.session')].map(section => new Session(section));
