// The numbers that view_data.py has packed, unpacked.
const PLANES = 4, TRACK = 8;  // bytes of a whole number; series of a track: x, y, z, four of the quaternion, whether there is a pose

export class Stream {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  // `count` whole numbers times `step`, from differences of that order.
  series(count, order, step, Kind = Float32Array) {
    const {bytes, at} = this, out = new Kind(count);
    let first = 0, second = 0;
    for (let i = 0; i < count; ++i) {
      const zigzag = bytes[at + i] | bytes[at + count + i] << 8 | bytes[at + 2 * count + i] << 16 | bytes[at + 3 * count + i] << 24;
      const change = zigzag >>> 1 ^ -(zigzag & 1);
      first = order === 2 ? first + (second += change) : first + change;
      out[i] = first * step;
    }
    this.at += PLANES * count;
    return out;
  }
}

// Poses of a body or grip over time.
class Track {
  constructor(stream, frames, about) {
    this.values = Array.from({length: TRACK}, (_, i) => i === TRACK - 1 ? stream.series(frames, 1, 1, Uint8Array)
      : stream.series(frames, 2, i < 3 ? about.step : about.turn));
  }
  valid(frame) { return this.values[7][frame] === 1; }
  // Between two frames the pose goes straight from one to the other.
  read(frame, share, position, turn) {
    const [x, y, z, a, b, c, d] = this.values, next = Math.min(frame + 1, x.length - 1), mix = v => v[frame] + share * (v[next] - v[frame]);
    position.set(mix(x), mix(y), mix(z));
    turn.set(mix(a), mix(b), mix(c), mix(d)).normalize();
  }
}

// Contact patches over time: rows of runs in which one patch lasts.
class Patches {
  constructor(stream, {count, runs, period, steps}) {
    const column = step => stream.series(count, 1, step), vector = step => [column(step), column(step), column(step)];
    this.period = period;
    this.at = vector(steps.at); this.normal = vector(steps.normal); this.force = vector(steps.force);
    this.radius = column(steps.radius); this.pressure = column(steps.pressure);
    this.sticking = stream.series(count, 1, 1, Uint8Array);
    let row = 0;
    this.runs = runs.map(([first, length]) => { const run = {first, last: first + length - 1, row}; row += length; return run; });
  }
  // Rows of the patches at a time.
  rowsAt(time) {
    const sample = Math.floor(time / this.period + 1e-6), rows = [];
    for (const run of this.runs) if (run.first <= sample && sample <= run.last) rows.push(run.row + sample - run.first);
    return rows;
  }
}

export function unpackView(bytes, data) {
  const stream = new Stream(bytes), tracks = data.tracks.map(about => new Track(stream, data.frames, about));
  const openings = data.devices.map(device => device.opening ? stream.series(data.frames, 2, device.opening) : null);
  const patches = new Patches(stream, data.patches);
  const meshes = data.meshes.map(({vertices, triangles, low, step}) => {
    const axes = low.map(() => stream.series(vertices, 1, step)), points = new Float32Array(3 * vertices);
    for (let i = 0; i < vertices; ++i) for (let axis = 0; axis < 3; ++axis) points[3 * i + axis] = low[axis] + axes[axis][i];
    return {points, corners: stream.series(3 * triangles, 1, 1, Uint32Array)};
  });
  return {tracks, openings, patches, meshes};
}
