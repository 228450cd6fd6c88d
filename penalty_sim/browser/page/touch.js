// A scene to touch, or a recorded session once more: the loop runs between two pictures of the screen, in steps of the scene, and gives up
// time that it cannot catch up.
import * as THREE from 'three';
import {View} from '../../session/view3d/main.js';
import {HandInput} from './hand.js';
import {Lead} from './lead.js';
import {Live} from './live.js';
import {Program} from './program.mjs';

const BUDGET = 0.7;        // share of the time since the last picture that ticks may take; what is left over is not caught up: simulated time
                           // goes slower. A fixed time would slow it down wherever pictures take longer than 16 ms to draw
const MOST_MS = 100;       // between two pictures; more was a pause, and is not caught up either
const TOGETHER = 4;        // ticks between two looks at the clock
const ESTIMATE_MS = 500;   // between two estimates of the step's error
const TELL_MS = 100;       // between two changes of the numbers
const SMOOTHING = 0.05;    // of the shown speed, a picture
const DOT = 0.012;         // radius of the dot where the hand is led, of the device's size

const root = document.documentElement, by = id => document.getElementById(id);
const dark = matchMedia('(prefers-color-scheme: dark)');

const inflated = async (stream, format) => new Uint8Array(await new Response(stream.pipeThrough(new DecompressionStream(format))).arrayBuffer());
function block(id) {
  const text = atob(by(id).textContent.trim()), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);  // Uint8Array.from takes five times as long
  return inflated(new Blob([bytes]).stream(), 'deflate');
}

// Two digits that count, but none beyond `places` after the point: a smaller number is told as smaller than the last of them.
function shown(value, places = 2) {
  if (!Number.isFinite(value)) return '–';
  const least = 10 ** -places, size = Math.abs(value);
  if (size < least) return value === 0 ? '0' : `< ${least}`;
  return value.toFixed(Math.max(0, Math.min(places, 1 - Math.floor(Math.log10(size))))).replace('-', '−');
}
const whole = value => Number.isFinite(value) ? Math.round(value).toLocaleString('en') : '–';

class Page {
  constructor(program) {
    Object.assign(this, {program, about: null, replays: false, which: 0, led: null, pending: 0, speed: 1, last: 0, told: 0, estimated: 0});
    this.canvas = by('view');
    this.grip = new THREE.Vector3();
    this.resizes = new ResizeObserver(() => this.view?.resize());
    by('scene').addEventListener('change', () => { this.asTheSceneSays(); this.openScene(); });
    by('again').addEventListener('click', () => this.reopen());
    by('script').addEventListener('click', () => { this.program.letGo(this.which); this.led = null; });
    by('other').addEventListener('click', () => { this.which = (this.which + 1) % this.about.hands.length; this.led = null; });
    by('session').addEventListener('change', () => { if (by('session').files[0]) this.openSession(by('session').files[0]); });
    for (const id of ['stiffness', 'friction']) by(id).addEventListener('input', () => this.tune());
    by('plane').addEventListener('change', () => { if (this.hand) this.hand.overFloor = by('plane').checked; });
    by('theme').addEventListener('click', () => this.theme(root.dataset.theme !== 'dark'));
    dark.addEventListener('change', () => this.theme(dark.matches));
    for (const button of document.querySelectorAll('[data-camera]')) button.addEventListener('click', () => this.look(button.dataset.camera));
    addEventListener('keydown', event => {
      if (event.target.closest?.('select, input') || event.ctrlKey || event.altKey || event.metaKey) return;
      const button = document.querySelector(`[data-key="${CSS.escape(event.key.toLowerCase())}"]`);
      if (button) { event.preventDefault(); button.click(); }
    });
    this.theme(dark.matches);
    requestAnimationFrame(now => this.frame(now));
  }

  reopen() { return this.replays ? this.show(this.bytes, true) : this.openScene(); }

  async openScene() {
    const name = by('scene').value, opening = this.opening = {}, bytes = await block(`scene-${name}`);
    if (this.opening !== opening) return;  // another one was chosen meanwhile
    location.replace(`#${name}`);
    this.show(bytes, false, by('scene').selectedOptions[0]?.dataset.shows ?? '');
  }

  // A file of `./run export BAG --session`.
  async openSession(file) {
    const opening = this.opening = {};
    try {
      const bytes = await inflated(file.stream(), 'gzip');
      if (this.opening === opening) this.show(bytes, true, `Session ${file.name}, replayed here.`);
    } catch {
      by('said').textContent = `${file.name} is no file of ./run export BAG --session`;
    }
  }

  show(bytes, replays, shows = by('shows').textContent) {
    by('said').textContent = '';
    this.about = null;
    this.bytes = bytes;
    this.replays = replays;
    try {
      const about = replays ? this.program.openSession(bytes) : this.program.open(bytes);
      this.draw(about);
    } catch (error) {
      by('said').textContent = /webgl/i.test(error.message) ? 'This browser has no WebGL, in which scenes are drawn.' : error.message;
      return;
    }
    document.body.toggleAttribute('data-replays', replays);
    by('shows').textContent = shows;
    by('certificate').textContent = this.about.about;
    if (replays) by('scene').selectedIndex = -1;  // any choice is a change
    by('other').hidden = replays || this.about.hands.length < 2;
    Object.assign(this, {which: 0, led: null, pending: 0, error: null, felt: undefined});
    if (!replays) this.tune();
  }

  draw(about) {
    const live = new Live(about, visual => this.program.corners(visual));
    live.take(this.program.picture());
    this.freshCanvas();
    this.view = new View(this.canvas, live.data, live);
    this.hand = this.replays ? null : new HandInput(this.view, this.canvas, step => this.lead(step));
    if (this.hand) this.hand.overFloor = by('plane').checked;
    this.mark = new Lead(this.view.scene, DOT * this.view.size);
    Object.assign(this, {live, about});
    this.theme(root.dataset.theme === 'dark');
    this.view.follows = 'all';
    this.view.resize();
    this.view.show(0, series => live.numbers[series]);
    this.look(this.camera ?? 'all');
  }

  // Of a scene's own: what a view leaves behind in the graphics card goes with it.
  freshCanvas() {
    const had = document.activeElement === this.canvas, fresh = this.canvas.cloneNode();
    this.hand?.close();
    this.view?.close();
    this.resizes.disconnect();
    this.canvas.replaceWith(fresh);
    this.canvas = fresh;
    this.resizes.observe(fresh);
    if (had) fresh.focus();
  }

  // The hand leaves the scene's script at the first move; the program holds it within the device's frame.
  lead(step) {
    this.led ??= new THREE.Vector3(...this.program.aimed(this.which).at);
    this.program.aim(this.which, this.led.add(step).toArray());
    this.led.set(...this.program.aimed(this.which).at);
  }

  asTheSceneSays() {
    by('stiffness').value = 0;
    by('friction').value = 1;
  }

  tune() {
    const stiffness = 10 ** Number(by('stiffness').value), friction = Number(by('friction').value);
    by('stiffness-value').textContent = `× ${shown(stiffness)}`;
    by('friction-value').textContent = `× ${shown(friction)}`;
    if (this.about && !this.replays) by('said').textContent = this.program.tune(stiffness, friction);
  }

  look(name) {
    this.camera = name;
    for (const button of document.querySelectorAll('[data-camera]')) button.setAttribute('aria-pressed', button.dataset.camera === name);
    this.view?.look(name);
  }

  theme(isDark) {
    root.dataset.theme = isDark ? 'dark' : 'light';
    this.view?.theme(isDark);
  }

  frame(now) {
    requestAnimationFrame(next => this.frame(next));
    const passed = Math.min(MOST_MS, now - this.last);
    this.last = now;
    if (!this.about || !(passed > 0)) return;
    this.hand?.pass(passed / 1000, this.view.size);
    this.run(passed);
    this.live.take(this.program.picture());
    this.view.show(0, series => this.live.numbers[series]);
    this.view.devices[this.which]?.gripInWorld(this.grip);
    if (!this.replays) this.mark.show(this.program.aimed(this.which), this.grip);
    this.view.draw();
    this.view.keepPace(passed);
    this.feel(now);
    if (!this.replays && now - this.estimated > ESTIMATE_MS) { this.estimated = now; this.error = this.program.estimate(); }
    if (now - this.told > TELL_MS) { this.told = now; this.tell(); }
    if (!performance.getEntriesByName('first frame').length) performance.mark('first frame');
  }

  // Ticks for `passed` ms of the wall's time, as many as the budget allows.
  run(passed) {
    const step = 1000 * this.about.step, begin = performance.now();
    this.pending += passed;
    let done = 0;
    while (this.pending >= step && performance.now() - begin < BUDGET * passed) {
      const count = Math.min(TOGETHER, Math.floor(this.pending / step));
      this.program.ticks(count);
      this.pending -= count * step;
      done += count * step;
    }
    if (this.pending >= step) this.pending = 0;
    this.speed += SMOOTHING * (Math.min(1, done / passed) - this.speed);
  }

  feel(now) {
    const most = this.about.hands[this.which].mostForce, strength = Math.hypot(...this.live.report(this.which).force);
    this.hand?.rumble(strength / most, 2 * Math.abs(strength - (this.felt ?? strength)) / most, now);
    this.felt = strength;
  }

  tell() {
    const hand = this.live.report(this.which), world = this.live.world(), {mostForce} = this.about.hands[this.which];
    const bar = (id, value, most, text) => {
      by(id).style.setProperty('--share', Math.max(0, Math.min(1, value / most)) || 0);
      by(id).toggleAttribute('data-beyond', value > most);
      by(`${id}-value`).textContent = text;
    };
    const strength = Math.hypot(...hand.force), meets = hand.stiffness > 0;
    bar('force', strength, mostForce, `${shown(strength)} N of ${whole(mostForce)}`);
    bar('meets', meets ? hand.stiffness : 0, hand.bound, `${meets ? whole(hand.stiffness) : '–'} of ${whole(hand.bound)} N/m`);
    by('weakened').textContent = !meets ? 'It touches nothing.' : hand.share < 0.999
      ? `Stiffer than a hand can hold: it is given ${Math.round(100 * hand.share)} %.` : 'Held as the scene says.';
    by('error').textContent = this.error ? `${shown(1e6 * this.error.position)} µm, ${shown(1e3 * this.error.force)} mN` : '–';
    by('contacts').textContent = whole(world.contacts);
    by('time').textContent = `${world.time.toFixed(1)} s, ${Math.round(100 * this.speed)} %`;
    by('pad').hidden = !this.hand?.pad();
    if (this.replays) return this.tellBits();
    by('script').disabled = !this.program.aimed(this.which).led;
    if (!world.finite) by('said').textContent = 'The world stopped: its steps had made more energy than there was. Start again with softer contacts.';
    return undefined;
  }

  tellBits() {
    const {ticks, done, compared, same} = this.program.progress();
    by('bits').textContent = compared === same ? `${whole(same)} of ${whole(ticks)} ticks` : `${whole(compared - same)} ticks differ`;
    by('bits').toggleAttribute('data-differ', compared !== same);
    if (done === ticks) by('said').textContent = same === compared && same > 0 ? 'The whole session came to the recorded bits.' : '';
  }
}

async function main() {
  try {
    const [wasm, loader] = await Promise.all([block('wasm'), block('loader')]);
    const make = new Function(`${new TextDecoder().decode(loader)}; return makeTouch`)();
    const page = globalThis.touchPage = new Page(await Program.load(wasm, make));
    const asked = location.hash.slice(1), scene = by('scene');
    if ([...scene.options].some(option => option.value === asked)) scene.value = asked;
    await page.openScene();
  } catch (error) {
    by('said').textContent = `This page cannot run here: ${error.message}`;
  }
}

main();
