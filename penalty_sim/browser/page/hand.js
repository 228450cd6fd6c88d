// Where the hand is led: by mouse, fingers, keys and a gamepad, in the axes of the picture. Relative: nothing jumps at a first touch.
import * as THREE from 'three';

const KEYS = {ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1],
  w: [0, 0, 1], s: [0, 0, -1]};
const SPEED = 0.35;        // by keys or a stick pushed to its end, of the frame's size a second
const DEAD = 0.15;         // of a stick: less is no push
const RUMBLE_MS = 80;      // of one effect; a new one follows before it ends

export class HandInput {
  // `lead(step)`: moves the hand by a vector of the world [m].
  constructor(view, canvas, lead) {
    Object.assign(this, {view, canvas, lead, held: new Set(), finger: null, rumbled: 0});
    this.right = new THREE.Vector3(); this.away = new THREE.Vector3(); this.up = new THREE.Vector3(0, 0, 1); this.step = new THREE.Vector3();
    view.controls.mouseButtons = {LEFT: null, MIDDLE: THREE.MOUSE.DOLLY, RIGHT: THREE.MOUSE.ROTATE};
    view.controls.touches = {ONE: null, TWO: THREE.TOUCH.DOLLY_ROTATE};
    this.events = new AbortController();
    const on = (target, name, act) => target.addEventListener(name, act, {signal: this.events.signal});
    on(canvas, 'pointerdown', event => {
      if (event.button !== 0 || this.finger !== null) { this.finger = null; return; }  // a second finger turns the camera
      this.finger = event.pointerId;
      this.last = [event.clientX, event.clientY];
    });
    on(canvas, 'pointermove', event => { if (event.pointerId === this.finger) this.drag(event); });
    for (const name of ['pointerup', 'pointercancel']) on(canvas, name, event => { if (event.pointerId === this.finger) this.finger = null; });
    on(canvas, 'keydown', event => {
      const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (!(name in KEYS) || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      if (event.shiftKey && name.startsWith('Arrow')) { view.turn(KEYS[name][0], KEYS[name][1]); return; }
      this.held.add(name);
    });
    on(window, 'keyup', event => { this.held.delete(event.key.length === 1 ? event.key.toLowerCase() : event.key); });
    on(window, 'blur', () => { this.held.clear(); });
  }

  close() { this.events.abort(); }

  axes() {
    this.right.setFromMatrixColumn(this.view.camera.matrixWorld, 0).setZ(0).normalize();
    this.away.crossVectors(this.up, this.right);
  }

  // Upright, or with shift over the floor.
  drag(event) {
    const {camera, controls} = this.view, distance = camera.position.distanceTo(controls.target);
    const pixel = 2 * distance * Math.tan(camera.fov * Math.PI / 360) / this.canvas.clientHeight;
    const [x, y] = this.last;
    this.last = [event.clientX, event.clientY];
    this.axes();
    this.step.copy(this.right).multiplyScalar(pixel * (event.clientX - x))
      .addScaledVector(event.shiftKey || this.overFloor ? this.away : this.up, -pixel * (event.clientY - y));
    this.lead(this.step);
  }

  // What keys and a gamepad ask for in `seconds`.
  pass(seconds, size) {
    const push = [0, 0, 0];
    for (const key of this.held) KEYS[key].forEach((share, axis) => { push[axis] += share; });
    const pad = this.pad();
    if (pad) {
      const stick = axis => Math.abs(pad.axes[axis] ?? 0) > DEAD ? pad.axes[axis] : 0;
      push[0] += stick(0); push[1] -= stick(1); push[2] -= stick(3);
    }
    if (!push.some(share => share !== 0)) return;
    this.axes();
    this.step.set(0, 0, 0).addScaledVector(this.right, push[0]).addScaledVector(this.away, push[1]).addScaledVector(this.up, push[2]);
    this.lead(this.step.multiplyScalar(SPEED * size * seconds));
  }

  pad() { return [...navigator.getGamepads?.() ?? []].find(pad => pad && pad.axes.length >= 4) ?? null; }

  // `share` of the greatest force, and how fast it changes: the strong motor turns with the force, the weak one with its changes.
  rumble(share, change, now) {
    const motor = this.pad()?.vibrationActuator;
    if (!motor?.playEffect || now - this.rumbled < RUMBLE_MS / 2 || share + change < 0.01) return;
    this.rumbled = now;
    motor.playEffect('dual-rumble', {duration: RUMBLE_MS, strongMagnitude: Math.min(1, share), weakMagnitude: Math.min(1, change)}).catch(() => {});
  }
}
