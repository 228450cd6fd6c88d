// A device: its frame, strings coloured by tension, grip, and the force on the hand. Drawn at the scale of its workspace, so that the
// grip is where the pointer should be.
import * as THREE from 'three';
import {Arrows, Copies, FORCE_COLOUR, setPose} from './bodies.js';
import {cornersOf} from './framing.js';

const FULL_TENSION = 5;  // drawn red [N], as in rviz: the usual range of a hand
export const tensionColour = share => share < 0.5 ? [0.3 + 1.3 * share, 0.65 + 0.3 * share, 1 - 1.4 * share]
  : [0.95, 1.5 - 1.4 * share, 0.55 - 0.5 * share];
const ASKED_COLOUR = [0.55, 0.6, 0.7], up = new THREE.Vector3(0, 0, 1), still = new THREE.Quaternion();

const poseOf = ({pose: [x, y, z, ...turn], scale}) =>
  new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(...turn), new THREE.Vector3().setScalar(scale));

export class Device {
  constructor(scene, data, hand, tracks, openings) {
    this.about = {...data.devices[hand], ...data.drawn[hand]};  // series of the curves: tension, force, asked
    this.bases = data.bases.filter(base => base.hand === hand);
    this.track = this.about.track === null ? null : tracks[this.about.track];
    this.opening = openings[hand];
    this.exits = this.about.strings.map(string => new THREE.Vector3(...string.exit));
    this.knots = this.about.strings.map(string => new THREE.Vector3(...string.knot));
    this.travels = this.about.strings.map(string => new THREE.Vector3(...string.travel));
    this.box = new THREE.Box3().setFromPoints(this.exits);
    this.size = this.box.getSize(new THREE.Vector3()).length() || 0.3;
    this.group = new THREE.Group();
    scene.add(this.group);
    this.line = new THREE.LineBasicMaterial({color: 0x888888});
    const centre = this.box.getCenter(new THREE.Vector3()), sides = new THREE.BoxGeometry(...this.box.getSize(new THREE.Vector3()));
    this.frame = new THREE.LineSegments(new THREE.EdgesGeometry(sides), this.line);
    this.frame.position.copy(centre);
    this.group.add(this.frame);
    const width = 0.0026 * this.size, ball = new THREE.SphereGeometry(1, 14, 10);
    const rod = new THREE.CylinderGeometry(width, width, 1, 6).translate(0, 0.5, 0).rotateX(Math.PI / 2);
    this.strings = new Copies(this.group, rod, 16, {lit: false});
    this.ends = new Copies(this.group, ball, 32);
    this.dot = new THREE.Vector3().setScalar(1.8 * width);
    this.grip = new THREE.Mesh(new THREE.SphereGeometry(this.about.radius, 32, 20),
      new THREE.MeshLambertMaterial({color: 0xe6b333, transparent: true, opacity: 0.35, depthWrite: false}));
    this.group.add(this.grip);
    this.arrows = new Arrows(this.group, 2, 1.2 * width);
  }
  baseAt(time) { return this.bases.findLast(each => each.at <= time + 1e-9) ?? this.bases[0]; }
  // Corners of the frame wherever its base stands in the session, into `points`.
  addFrame(points) {
    for (const base of this.bases) cornersOf(this.box, points, poseOf(base));
  }
  // Corners of the grip's box, in the world.
  gripCorners(frame, time) {
    const grip = new THREE.Box3(), half = new THREE.Vector3().setScalar(this.about.radius), base = this.baseAt(time);
    if (!base || this.track === null || !this.track.valid(frame)) return [];
    this.track.read(frame, 0, grip.max, new THREE.Quaternion());
    grip.min.copy(grip.max).sub(half);
    grip.max.add(half);
    return cornersOf(grip, [], poseOf(base));
  }
  // `values(series)`: of the curves at that time.
  show(time, frame, share, values) {
    const base = this.baseAt(time);
    if (base) { setPose(this.group, base.pose); this.group.scale.setScalar(base.scale); }
    const parts = [this.strings, this.ends, this.arrows], there = this.track !== null && this.track.valid(frame);
    parts.forEach(part => part.clear());
    this.grip.visible = there;
    for (const exit of this.exits) this.ends.add(exit, still, this.dot, [0.6, 0.6, 0.6]);
    if (there) this.showGrip(frame, share, values);
    parts.forEach(part => part.done());
  }
  showGrip(frame, share, values) {
    const turn = new THREE.Quaternion(), scale = new THREE.Vector3(1, 1, 1), open = this.opening ? this.opening[frame] : 0;
    this.track.read(frame, share, this.grip.position, this.grip.quaternion);
    this.knots.forEach((knot, string) => {
      const end = knot.clone().addScaledVector(this.travels[string], open).applyQuaternion(this.grip.quaternion).add(this.grip.position);
      const way = end.clone().sub(this.exits[string]), tension = values(this.about.tension[string]);
      turn.setFromUnitVectors(up, way.clone().normalize());
      this.strings.add(this.exits[string], turn, scale.set(1, 1, way.length()), tensionColour(Math.min(1, Math.max(0, (tension || 0) / FULL_TENSION))));
      this.ends.add(end, still, this.dot, [0.95, 0.95, 0.95]);
    });
    const force = series => new THREE.Vector3(...series.map(each => values(each) || 0));
    this.arrows.add(this.grip.position, force(this.about.asked), ASKED_COLOUR);
    this.arrows.add(this.grip.position, force(this.about.force), FORCE_COLOUR);
  }
  gripInWorld(into) { return this.group.localToWorld(into.copy(this.grip.position)); }
}
