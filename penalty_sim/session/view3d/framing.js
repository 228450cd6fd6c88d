// Where the camera stands for everything to be in its picture: bodies and grips at all times of the session, and the devices' frames.
import * as THREE from 'three';

const LOOKS = 80;           // times at which bodies are asked for their places, evenly over the session
const MUCH_LARGER = 2.5;    // than what moves: a body that stands and is so large is seen near what moves only, or it would leave that small
const LOST = 3;             // times the extent at the start: what went farther fell off, and is let go
const BESIDE = 0.1;         // share of the extent of what moves, within which a large body that stands is seen
const MARGIN = 1.04;        // around everything
const ROUNDS = 20;          // of centring; three bring the focus within a pixel

// Corners of a box that stands at `pose`, a matrix, appended to `into`.
export function cornersOf({min, max}, into = [], pose = new THREE.Matrix4()) {
  for (let corner = 0; corner < 8; ++corner) {
    into.push(new THREE.Vector3(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z).applyMatrix4(pose));
  }
  return into;
}

// Box of a link's visuals, in the link's frame.
function boxOf(link) {
  const box = new THREE.Box3();
  for (const mesh of link.children) {
    mesh.updateMatrix();
    if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
    box.union(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrix));
  }
  return box;
}

// Corners [m], in the world: of bodies and grips that move, at all times of the session; and of everything. `view`: a View.
export function bounds(view) {
  const frames = [...new Set(Array.from({length: LOOKS}, (_, look) => Math.round(look * (view.data.frames - 1) / (LOOKS - 1))))];
  const fixed = [], carried = [], still = [];  // corners of devices; of each body by time; of bodies that stand
  for (const device of view.devices) device.addFrame(fixed);
  view.data.links.forEach((link, index) => {
    const box = boxOf(view.links[index]), moved = view.links[index].clone(false);
    if (box.isEmpty()) return;
    const corners = () => { moved.updateMatrix(); return cornersOf(box, [], moved.matrix); };
    if (link.track === null) still.push(corners());
    else carried.push(frames.map(frame => { view.tracks[link.track].read(frame, 0, moved.position, moved.quaternion); return corners(); }));
  });
  for (const device of view.devices) carried.push(frames.map(frame => device.gripCorners(frame, frame * view.data.period)));
  const start = new THREE.Box3().setFromPoints([...fixed, ...carried.flatMap(times => times[0])]);
  const middle = start.getCenter(new THREE.Vector3()), far = LOST * start.getSize(new THREE.Vector3()).length();
  const moving = carried.flat().filter(corners => corners.every(corner => corner.distanceTo(middle) < far)).flat(), all = [...fixed, ...moving];
  const around = new THREE.Box3().setFromPoints(all), length = around.getSize(new THREE.Vector3()).length();
  around.expandByScalar(BESIDE * length);
  for (const corners of still) {
    const box = new THREE.Box3().setFromPoints(corners);
    if (box.getSize(new THREE.Vector3()).length() <= MUCH_LARGER * length) all.push(...corners);
    else if (box.intersectsBox(around)) cornersOf(box.intersect(around), all);
  }
  return {moving: moving.length ? moving : all, all};
}

// The point to look at and the distance from it, seen along −`look`, at which all points just fit into the picture: the focus moves until left
// and right, above and below are as full. `tangent`: of half the vertical field.
export function fit(points, look, up, tangent, aspect) {
  const focus = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
  const right = new THREE.Vector3().crossVectors(up, look).normalize(), above = new THREE.Vector3().crossVectors(look, right);
  const seen = points.map(point => { const way = point.clone().sub(focus); return [way.dot(right), way.dot(above), way.dot(look)]; });
  const slopes = [tangent * aspect, tangent], shift = [0, 0];
  let distance = 0;
  for (let round = 0; round < ROUNDS; ++round) {
    distance = 0;
    for (const each of seen) for (let axis = 0; axis < 2; ++axis) distance = Math.max(distance, each[2] + Math.abs(each[axis] - shift[axis]) / slopes[axis]);
    for (let axis = 0; axis < 2; ++axis) {
      let least = Infinity, most = -Infinity;
      for (const each of seen) {
        const share = (each[axis] - shift[axis]) / (distance - each[2]);
        least = Math.min(least, share);
        most = Math.max(most, share);
      }
      shift[axis] += distance * (least + most) / 2;
    }
  }
  return {focus: focus.addScaledVector(right, shift[0]).addScaledVector(above, shift[1]), distance: MARGIN * distance};
}
