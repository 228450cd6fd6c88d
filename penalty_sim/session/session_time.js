'use strict';
// One time for curves and picture: played, stepped, dragged, and jumped to where something happens. Works without the picture.
const SPEEDS = [[0.25, '¼ ×'], [0.5, '½ ×'], [1, '1 ×'], [2, '2 ×'], [4, '4 ×']];
const JUMPS = [['contact', 'c', 'a touch begins'], ['slip', 's', 'a contact begins to slip'], ['fault', 'f', 'a fault begins'], ['missed tick', 'm', 'ticks were lost']];
const CAMERAS = [['all', '1', 'everything'], ['grip', '2', 'follow the grip'], ['contact', '3', 'follow the strongest contact']];
const SLIDER = 10000;    // steps of the time slider
const TELL_MS = 100;     // while it plays, the slider and all numbers change this often

// The program of the 3-D view, once for all sessions of a page; null where it was not built in.
let view3d = null;
const viewProgram = () => view3d ??= (async () => {
  const packed = document.getElementById('view3d');
  if (!packed) return null;
  return new Function(new TextDecoder().decode(await inflate(packed.textContent)) + '; return View3D')();
})();

class Timeline {
  constructor(session, blob) {
    this.session = session;
    this.period = session.data.tick;
    this.jumps = this.findJumps(session.data);
    const box = this.box = element('div', session.plots, {className: 'stage'});
    this.build(box);
    addEventListener('keydown', event => this.key(event));
    redraws.push(() => { if (this.view) { this.view.theme(root.dataset.theme === 'dark'); this.wake(); } });
    this.opened = session.data.view ? this.openView(blob).catch(error => this.noView(error.message)) : null;
    if (session.data.noView) this.noView(session.data.noView);
  }

  findJumps(data) {
    const begins = (group, kinds) => data.lanes.filter(lane => lane.group === group)
      .flatMap(lane => lane.spells.filter(([, , kind]) => kinds.includes(kind)).map(([begin]) => begin));
    const touches = data.lanes.filter(lane => lane.group === 'contact')
      .flatMap(lane => lane.spells.filter(([begin], i) => i === 0 || begin - lane.spells[i - 1][1] > 1.5 * this.period).map(([begin]) => begin));
    const sorted = times => [...new Set(times)].sort((a, b) => a - b);
    return {contact: sorted(touches), slip: sorted(begins('contact', ['slip', 'turn'])),
      fault: sorted([...begins('limit', ['fault']), ...begins('state', ['FAULT', 'DISCONNECTED'])]), 'missed tick': sorted(data.missed)};
  }

  build(box) {
    this.canvas = element('canvas', box, {className: 'view', tabIndex: 0, hidden: true});
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', 'The session in 3-D: device, strings, bodies, contact patches and forces');
    this.legend = element('p', box, {className: 'note scale', hidden: true});
    this.said = element('p', box, {className: 'note', hidden: true});
    this.said.setAttribute('role', 'status');
    const bar = this.bar = element('div', box, {className: 'time'});
    const button = (label, title, act, parent = bar) => {
      const made = element('button', parent, {type: 'button', textContent: label, title});
      made.addEventListener('click', act);
      return made;
    };
    this.playing = button('▶', 'play or stop (space)', () => this.play(!this.isPlaying));
    this.playing.setAttribute('aria-label', 'play or stop');
    button('−1', 'one tick back (,)', () => this.step(-1)).setAttribute('aria-label', 'one tick back');
    button('+1', 'one tick on (.)', () => this.step(1)).setAttribute('aria-label', 'one tick on');
    this.speed = element('select', bar, {title: 'speed'});
    this.speed.setAttribute('aria-label', 'speed');
    for (const [factor, label] of SPEEDS) element('option', this.speed, {value: factor, textContent: label, selected: factor === 1});
    this.slider = element('input', bar, {type: 'range', min: 0, max: SLIDER, step: 1, value: 0});
    this.slider.setAttribute('aria-label', 'time');
    this.slider.addEventListener('input', () => { this.play(false); this.go(this.session.duration * this.slider.value / SLIDER); });
    this.output = element('output', bar);
    const jumps = element('div', box, {className: 'time jumps'});
    element('span', jumps, {textContent: 'next'});
    for (const [name, key, what] of JUMPS) {
      button(`${name} (${this.jumps[name].length})`, `the next time that ${what} (${key}; with shift: the last)`, event => this.jump(name, event.shiftKey ? -1 : 1), jumps);
    }
    this.cameras = element('span', jumps, {className: 'cameras', hidden: true});
    element('span', this.cameras, {textContent: 'camera'});
    for (const [name, key, what] of CAMERAS) button(name, `${what} (${key})`, () => this.look(name), this.cameras).dataset.camera = name;
    this.tell();
  }

  async openView(blob) {
    const [program, bytes] = await Promise.all([viewProgram(), inflate(blob)]);
    this.canvas.hidden = false;
    try {
      this.view = new program.View(this.canvas, this.session.data.view, program.unpackView(bytes, this.session.data.view));
    } catch (error) {
      this.canvas.hidden = true;
      throw /webgl/i.test(error.message) ? new Error('This browser has no WebGL: the curves go on without the 3-D view.') : error;
    }
    this.canvas.addEventListener('webglcontextlost', () => this.noView('The graphics card was taken away: load the page anew for the 3-D view.'));
    this.canvas.addEventListener('wheel', event => {  // before the view's own: without a key the page scrolls
      event.stopImmediatePropagation();
      if (!event.ctrlKey && !event.shiftKey) return;
      event.preventDefault();
      this.view.zoom((event.deltaY || event.deltaX) > 0 ? 1.15 : 0.87);
      this.wake();
    }, {passive: false, capture: true});
    this.canvas.addEventListener('keydown', event => {
      const way = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
      if (!way || event.ctrlKey || event.altKey) return;
      this.view.turn(...way);
      event.preventDefault();
      event.stopPropagation();
    });
    for (const name of ['pointerdown', 'pointermove', 'keydown']) this.canvas.addEventListener(name, () => this.wake());
    new ResizeObserver(() => { this.view.resize(); this.wake(); }).observe(this.canvas);
    this.showLegend(program);
    this.cameras.hidden = false;
    this.view.theme(root.dataset.theme === 'dark');
    this.view.follows = 'all';
    this.go(this.now);
    this.view.resize();
    this.look('all');
    this.view.draw();
    performance.mark('first frame');
  }

  noView(reason) {
    this.said.hidden = false;
    this.said.textContent = reason;
  }

  showLegend({tensionColour, pressureColour}) {
    const css = ([r, g, b]) => `rgb(${[r, g, b].map(x => Math.round(255 * Math.max(0, Math.min(1, x)))).join(' ')})`;
    const scale = (title, colour, least, most) => {
      const part = element('span', this.legend, {textContent: title + ' ' + least + ' '});
      element('i', part).style.background = `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(share => css(colour(share))).join(', ')})`;
      part.append(' ' + most);
    };
    scale('strings', tensionColour, '0', '5 N');
    scale('patches', pressureColour, '0', '20 kPa');
    element('span', this.legend, {textContent: '○ closed ring: sticks, dashed: slips'});
    element('span', this.legend, {textContent: '→ force: 15 mm per newton; grey: asked of the device'});
    const {poseError, meshError, stride} = this.session.data.view;
    const length = metres => metres < 1e-4 ? `${(1e6 * metres).toPrecision(2)} µm` : `${(1e3 * metres).toPrecision(2)} mm`;
    element('span', this.legend, {textContent: `poses within ${length(poseError)}` + (meshError ? `, meshes within ${length(meshError)}` : '')
      + (stride > 1 ? `, a frame every ${stride} ticks` : '')});
    element('span', this.legend, {textContent: 'Drag to turn, two fingers or the right button to move, shift and wheel or pinch to zoom.'});
    this.legend.hidden = false;
  }

  get now() { return this.session.now; }

  go(time) {
    const {session} = this;
    session.now = Math.max(0, Math.min(session.duration - this.period, time));
    this.view?.show(session.now, index => session.valueAt(index, session.now));
    if (this.isPlaying && (session.now > session.t1 || session.now < session.t0)) session.view(session.now, session.now + session.t1 - session.t0);
    if (!this.isPlaying) this.tell();
    this.wake();
  }

  // Everything but the picture: changed at every frame, the page around it would cost a slow browser more than the picture.
  tell() {
    this.slider.value = SLIDER * this.now / this.session.duration;
    this.session.moveNow();
    this.session.tellValues();
    const tick = Math.round(this.now / this.period), patches = this.view ? `, ${this.view.patches.count} patches` : '';
    this.output.value = `${this.now.toFixed(3)} s, tick ${tick}${patches}`;
  }

  step(ticks) {
    this.play(false);
    this.go((Math.round(this.now / this.period) + ticks) * this.period);
    this.session.draw();
  }

  jump(name, way) {
    this.play(false);
    const times = this.jumps[name], far = 0.5 * this.period;
    const next = way > 0 ? times.find(time => time > this.now + far) : times.findLast(time => time < this.now - far);
    if (next === undefined) {
      this.output.value = times.length ? `no ${name} ${way > 0 ? 'after' : 'before'} this` : `no ${name} in this session`;
      return;
    }
    this.go(next);
    const {session} = this;
    if (next < session.t0 || next > session.t1) session.view(next - (session.t1 - session.t0) / 2, next + (session.t1 - session.t0) / 2);
    session.draw();
  }

  look(name) {
    if (!this.view) return;
    this.view.look(name);
    for (const button of this.cameras.querySelectorAll('button')) button.setAttribute('aria-pressed', button.dataset.camera === name);
    this.wake();
  }

  play(on) {
    if (on && this.now >= this.session.duration - 1.5 * this.period) this.go(0);
    this.isPlaying = on;
    this.playing.textContent = on ? '❚❚' : '▶';
    this.last = null;
    this.told = 0;
    if (on) this.wake(); else this.session.draw();
  }

  // Frames are drawn while it plays or a camera still moves.
  wake() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(at => {
      this.waiting = false;
      if (this.isPlaying) {
        const way = this.last === null ? 0 : (at - this.last) / 1000 * Number(this.speed.value), end = this.session.duration - this.period;
        if (this.last !== null) this.view?.keepPace(at - this.last);
        this.last = at;
        this.go(this.now + way);
        if (at - this.told > TELL_MS) { this.told = at; this.tell(); }
        if (this.now >= end) this.play(false);
      }
      const drew = this.view && this.box.getBoundingClientRect().bottom > 0 && this.view.draw();
      if (drew || this.isPlaying) this.wake();
    });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName) && event.key === ' ') return;
    const box = this.session.section.getBoundingClientRect();
    if (box.top > innerHeight / 2 || box.bottom < innerHeight / 2) return;  // of the session in the middle of the window
    const jump = JUMPS.find(([, key]) => key === event.key.toLowerCase()), camera = CAMERAS.find(([, key]) => key === event.key);
    const act = {' ': () => this.play(!this.isPlaying), ',': () => this.step(-1), '.': () => this.step(1)}[event.key]
      ?? (jump && (() => this.jump(jump[0], event.shiftKey ? -1 : 1))) ?? (camera && this.view && (() => this.look(camera[0])));
    if (!act) return;
    act();
    event.preventDefault();
  }
}
