// Bodies, contact patches and contact forces.
import * as THREE from 'three';

const FULL_PRESSURE = 2e4;       // drawn red [Pa], as in rviz: 1 N on 0.5 cm²
const METRES_PER_NEWTON = 0.015, LONGEST = 0.3, LEAST_FORCE = 0.02;  // of an arrow, as in rviz [m/N], [m], [N]
const LEAST_RING = 0.004;        // radius of a ring that can still be seen [m]
const RING = [1.03, 1.16];       // inner and outer radius of a ring, of its patch's: it covers little of a body
const MOST = 64;                 // patches at once
export const FORCE_COLOUR = [0.9, 0.2, 0.2];

// Blue through yellow to red: told apart by brightness too, on dark and on light ground.
export const pressureColour = share => share < 0.5 ? [0.1 + 1.6 * share, 0.4 + 0.7 * share, 1 - 1.8 * share]
  : [0.9, 1.4 - 1.3 * share, 0.1];

export const colourOf = ([r, g, b], into = new THREE.Color()) => into.setRGB(r, g, b, THREE.SRGBColorSpace);
const up = new THREE.Vector3(0, 0, 1), matrix = new THREE.Matrix4(), turn = new THREE.Quaternion(), place = new THREE.Vector3();
const direction = new THREE.Vector3(), size = new THREE.Vector3(), tint = new THREE.Color();

export function setPose(object, [x, y, z, a, b, c, d]) {
  object.position.set(x, y, z);
  object.quaternion.set(a, b, c, d);
}

function geometryOf(visual, meshes) {
  if (visual.shape === 'box') return new THREE.BoxGeometry(...visual.size);
  if (visual.shape === 'sphere') return new THREE.SphereGeometry(0.5, 32, 20).scale(...visual.size);
  if (visual.shape === 'cylinder') return new THREE.CylinderGeometry(0.5, 0.5, 1, 40).rotateX(Math.PI / 2).scale(...visual.size);
  const mesh = meshes[visual.mesh], indexed = new THREE.BufferGeometry();
  indexed.setAttribute('position', new THREE.BufferAttribute(mesh.points, 3));
  indexed.setIndex(new THREE.BufferAttribute(mesh.corners, 1));
  return indexed.toNonIndexed();
}

// A mesh of many triangles is round, or was made coarser: its edges say nothing.
const hasEdges = (visual, geometry) => visual.shape !== 'sphere' && !(visual.shape === 'mesh' && geometry.attributes.position.count > 3 * 400);

export function makeBodies(scene, data, meshes) {
  const links = data.links.map(link => { const group = new THREE.Group(); setPose(group, link.pose); scene.add(group); return group; });
  const shared = new Map();
  for (const visual of data.visuals) {
    const key = visual.shape === 'mesh' ? visual.mesh : JSON.stringify([visual.shape, visual.size]);
    if (!shared.has(key)) {
      const geometry = geometryOf(visual, meshes);
      if (visual.shape === 'mesh') geometry.computeVertexNormals();  // flat: no two triangles share a vertex
      shared.set(key, {geometry, edges: hasEdges(visual, geometry) ? new THREE.EdgesGeometry(geometry, 30) : null});
    }
    const {geometry, edges} = shared.get(key), alpha = visual.colour[3];
    const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({
      color: colourOf(visual.colour), transparent: alpha < 1, opacity: alpha, side: visual.shape === 'mesh' ? THREE.DoubleSide : THREE.FrontSide,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1}));
    setPose(mesh, visual.pose);
    links[visual.link].add(mesh);
    if (edges) mesh.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({color: 0x000000, transparent: true, opacity: 0.35})));
  }
  return links;
}

// Many of one shape, each with a place, a size and a colour. `over`: seen through what stands before it.
export class Copies {
  constructor(scene, geometry, most, {opacity = 1, over = false, lit = true, order = 0, side = THREE.FrontSide} = {}) {
    const Material = lit ? THREE.MeshLambertMaterial : THREE.MeshBasicMaterial;
    const material = new Material({transparent: opacity < 1 || over, opacity, depthTest: !over, depthWrite: !over, side});
    this.mesh = new THREE.InstancedMesh(geometry, material, most);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = order;
    this.mesh.setColorAt(0, tint);  // the colours' place is made now
    this.most = most;
    this.clear();
    scene.add(this.mesh);
  }
  clear() { this.mesh.count = 0; }
  add(position, quaternion, scale, colour) {
    if (this.mesh.count === this.most) return;
    this.mesh.setMatrixAt(this.mesh.count, matrix.compose(position, quaternion, scale));
    this.mesh.setColorAt(this.mesh.count++, colourOf(colour, tint));
  }
  done() { this.mesh.instanceMatrix.needsUpdate = this.mesh.instanceColor.needsUpdate = true; }
}

export class Arrows {
  constructor(scene, most, width) {
    this.width = width;
    const along = geometry => geometry.translate(0, 0.5, 0).rotateX(Math.PI / 2), over = {over: true, order: 3};
    this.shafts = new Copies(scene, along(new THREE.CylinderGeometry(1, 1, 1, 10)), most, over);
    this.heads = new Copies(scene, along(new THREE.ConeGeometry(1, 1, 14)), most, over);
  }
  clear() { this.shafts.clear(); this.heads.clear(); }
  add(from, force, colour, scale = 1) {
    const strength = force.length();
    if (!(strength > LEAST_FORCE)) return;
    const length = Math.min(LONGEST, METRES_PER_NEWTON * strength) * scale, head = Math.min(length / 2, 4 * this.width);
    direction.copy(force).divideScalar(strength);
    turn.setFromUnitVectors(up, direction);
    this.shafts.add(from, turn, size.set(this.width, this.width, length - head), colour);
    place.copy(direction).multiplyScalar(length - head).add(from);
    this.heads.add(place, turn, size.set(2.4 * this.width, 2.4 * this.width, head), colour);
  }
  done() { this.shafts.done(); this.heads.done(); }
}

function dashedRing(inner, outer) {
  const positions = [];
  for (let dash = 0; dash < 6; ++dash) {
    const part = new THREE.RingGeometry(inner, outer, 4, 1, dash * Math.PI / 3, Math.PI / 6).toNonIndexed();
    positions.push(...part.attributes.position.array);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
  return geometry;
}

// Discs of the patches' areas, coloured by pressure; a closed ring sticks, a dashed one slides.
export class ContactPatches {
  constructor(scene, patches, width) {
    this.patches = patches;
    const flat = {over: true, lit: false, side: THREE.DoubleSide};
    this.discs = new Copies(scene, new THREE.CircleGeometry(1, 36), MOST, {...flat, opacity: 0.5, order: 1});
    this.closed = new Copies(scene, new THREE.RingGeometry(...RING, 40), MOST, {...flat, order: 2});
    this.dashed = new Copies(scene, dashedRing(...RING), MOST, {...flat, order: 2});
    this.arrows = new Arrows(scene, MOST, width);
    this.strongest = null;
  }
  show(time) {
    const {at, normal, force, radius, pressure, sticking} = this.patches, parts = [this.discs, this.closed, this.dashed, this.arrows];
    parts.forEach(part => part.clear());
    let most = -1;
    this.strongest = null;
    this.count = 0;
    for (const row of this.patches.rowsAt(time)) {
      const vector = ([x, y, z]) => new THREE.Vector3(x[row], y[row], z[row]);
      const position = vector(at), push = vector(force), colour = pressureColour(Math.min(1, pressure[row] / FULL_PRESSURE));
      turn.setFromUnitVectors(up, direction.copy(vector(normal)).normalize());
      const facing = turn.clone(), ring = Math.max(LEAST_RING, radius[row]);
      this.discs.add(position, facing, size.setScalar(Math.max(radius[row], 1e-4)), colour);
      (sticking[row] ? this.closed : this.dashed).add(position, facing, size.setScalar(ring), colour);
      this.arrows.add(position, push, FORCE_COLOUR);
      ++this.count;
      if (push.length() > most) { most = push.length(); this.strongest = {position, radius: ring}; }
    }
    parts.forEach(part => part.done());
  }
}
