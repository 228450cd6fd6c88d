// The 3-D view of a session: bodies, patches and devices at a time, seen by one of three cameras. Drawn when something has changed.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {ContactPatches, makeBodies} from './bodies.js';
import {Device} from './device.js';
import {bounds, fit} from './framing.js';

export {pressureColour} from './bodies.js';
export {tensionColour} from './device.js';
export {unpackView} from './stream.js';

const FIELD = 40;                 // of view, vertical [°]
const NEAREST = 0.002, FARTHEST = 50;  // that is drawn, of the distance from which everything is seen
const FOLLOW = 0.12;              // share of the way that a following camera catches up in a frame
const CLOSE = {grip: 0.45, contact: 0.3};  // distance of a camera that follows, times the device's size
const PATCHES = 5;                // least distance to a patch, of its radius
const MOST_PIXELS = 2;            // per CSS pixel
const SLOW = 40, LEAST_PIXELS = 0.6;  // frames that come less often [ms] are drawn with fewer pixels, down to so many per CSS pixel
const SMOOTHING = 0.1, SETTLE = 10;   // of the time between frames; frames after a change of pixels that do not count
const TURN = Math.PI / 24;        // of the camera, by a key [rad]
const axis = new THREE.Vector3(1, 0, 0);
const look = new THREE.Vector3(0.62, -0.72, 0.42).normalize();  // from what is seen towards the camera: no edge of a frame stands before the grip

// Does a processor draw in place of a graphics card? Only a context knows, and a browser that names no renderer is taken for a fast one.
function drawsOnProcessor() {
  const probe = document.createElement('canvas').getContext('webgl2'), about = probe?.getExtension('WEBGL_debug_renderer_info');
  const name = about ? probe.getParameter(about.UNMASKED_RENDERER_WEBGL) : '';
  probe?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|basic render|software/i.test(name);
}

export class View {
  // The last is what unpackView gives, or what answers as that does: a recording, or a world that runs now. Throws where there is no WebGL.
  constructor(canvas, data, {tracks, openings, patches, meshes}) {
    // Smoothed edges take a processor longer than the rest of the picture.
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !drawsOnProcessor(), powerPreference: 'low-power'});
    this.data = data;
    this.canvas = canvas;
    this.scene = new THREE.Scene();
    this.light = new THREE.HemisphereLight(0xffffff, 0x8a8f99, 2.2);
    this.light.position.set(0, 0, 1);
    this.sun = new THREE.DirectionalLight(0xffffff, 1.6);
    this.sun.position.set(0.4, -0.6, 1);
    this.scene.add(this.light, this.sun);
    this.tracks = tracks;
    this.links = makeBodies(this.scene, data, meshes);
    this.devices = data.devices.map((_, hand) => new Device(this.scene, data, hand, tracks, openings));
    this.size = Math.max(...this.devices.map(device => device.size));
    this.patches = new ContactPatches(this.scene, patches, 0.0022 * this.size);
    this.camera = new THREE.PerspectiveCamera(FIELD, 1);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => { this.dirty = true; });
    canvas.addEventListener('webglcontextrestored', () => { this.dirty = true; });
    this.target = new THREE.Vector3();
    this.pixels = Math.min(devicePixelRatio || 1, MOST_PIXELS);
    this.frames = 0;
    this.pace = {between: 0, settle: SETTLE};
    this.dirty = true;
    this.values = () => NaN;
  }

  show(time, values = this.values) {
    this.time = time;
    this.values = values;
    const at = Math.max(0, Math.min(this.data.frames - 1, time / this.data.period + 1e-6)), frame = Math.floor(at);
    const share = at - frame < 1e-4 ? 0 : at - frame;
    this.data.links.forEach((link, index) => {
      if (link.track !== null) this.tracks[link.track].read(frame, share, this.links[index].position, this.links[index].quaternion);
    });
    for (const device of this.devices) device.show(time, frame, share, values);
    this.patches.show(time);
    this.dirty = true;
  }

  theme(dark) {
    this.renderer.setClearColor(dark ? 0x1d242b : 0xf3f5f7);
    for (const device of this.devices) device.line.color.set(dark ? 0x8a97a3 : 0x77828c);
    this.dirty = true;
  }

  // all, grip or contact.
  look(name) {
    this.follows = name;
    const whole = this.framed(this.bounds().all), way = this.camera.position.clone().sub(this.controls.target);
    this.camera.near = NEAREST * whole.distance;
    this.camera.far = FARTHEST * whole.distance;
    this.camera.updateProjectionMatrix();
    if (name === 'all') {
      this.place(whole);
    } else if (this.whereTo(this.target)) {
      if (way.lengthSq() < 1e-12) way.copy(look);
      this.controls.target.copy(this.target);
      this.camera.position.copy(this.target).addScaledVector(way.normalize(), this.closeTo(name));
    }
    this.controls.update();
    this.dirty = true;
  }

  // Distance of a following camera: a share of the device's size, more where a patch would not be seen whole.
  closeTo(name) {
    const {strongest} = this.patches, device = CLOSE[name] * this.size * (this.devices[0].group.scale.x || 1);
    return name === 'contact' && strongest ? Math.max(device, PATCHES * strongest.radius) : device;
  }

  // What a following camera looks at.
  whereTo(point) {
    const {strongest} = this.patches;
    if (this.follows === 'contact' && strongest) { point.copy(strongest.position); return true; }
    const hand = this.devices.find(device => device.grip.visible);
    if (!hand || this.follows === 'contact' && this.held) return false;
    hand.gripInWorld(point);
    return true;
  }

  // Corners of what moves and of everything, at all times of the session.
  bounds() { return bounds(this); }

  // {focus, distance} from which all `points` are seen.
  framed(points) { return fit(points, look, this.camera.up, Math.tan(FIELD * Math.PI / 360), this.camera.aspect); }

  place({focus, distance}) {
    this.controls.target.copy(focus);
    this.camera.position.copy(focus).addScaledVector(look, distance);
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.dirty = true;
  }

  // By steps of TURN about the target: to the right, upwards.
  turn(right, above) {
    const way = this.camera.position.clone().sub(this.controls.target), seen = new THREE.Spherical().setFromVector3(way.applyAxisAngle(axis, -Math.PI / 2));
    seen.theta += right * TURN;
    seen.phi -= above * TURN;
    way.setFromSpherical(seen.makeSafe()).applyAxisAngle(axis, Math.PI / 2);
    this.camera.position.copy(this.controls.target).add(way);
    this.controls.update();
    this.dirty = true;
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(this.pixels);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.follows === 'all' && !this.frames) this.look('all');
    this.dirty = true;
  }

  // Draws if something has changed; true if it did.
  draw() {
    if (this.follows && this.follows !== 'all' && this.whereTo(this.target)) {
      const step = this.target.sub(this.controls.target).multiplyScalar(FOLLOW);
      if (step.length() > 1e-5) {
        this.controls.target.add(step);
        this.camera.position.add(step);
        this.dirty = true;
      }
    }
    this.controls.update();
    if (!this.dirty) return false;
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
    ++this.frames;
    return true;
  }

  // Another view may take its place.
  close() {
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  // Told the time between two frames while it plays [ms]: a processor that draws in place of a graphics card gets fewer pixels.
  keepPace(between) {
    const {pace} = this;
    if (pace.settle > 0) { --pace.settle; pace.between = 0; return; }
    pace.between = pace.between ? pace.between + SMOOTHING * (between - pace.between) : between;
    if (pace.between < SLOW || this.pixels <= LEAST_PIXELS) return;
    this.pixels = Math.max(LEAST_PIXELS, this.pixels / 1.3);
    pace.settle = SETTLE;
    this.resize();
  }
}
