// The numbers of a running scene (picture.h) as the 3-D view asks for those of a recording: tracks of poses, patches, series by their place.
const POSE = 7;

export class Live {
  // `about`: pictureText; `cornersOf(visual)`: its triangles.
  constructor(about, cornersOf) {
    const {layout, links, hands} = about;
    this.layout = layout;
    let at = layout.head + POSE * links.length;
    this.handsAt = hands.map(hand => { const from = at; at += layout.perHand + hand.strings.length; return from; });
    this.patchesAt = at;
    const column = () => new Float64Array(layout.mostPatches), vector = () => [column(), column(), column()];
    this.patches = {at: vector(), normal: vector(), force: vector(), radius: column(), pressure: column(), sticking: column(),
      rowsAt: () => Array.from({length: this.count}, (_, row) => row)};
    this.count = 0;
    this.tracks = [...links.map((_, link) => layout.head + POSE * link), ...this.handsAt].map(from => ({
      valid: () => true,
      read: (_frame, _share, position, turn) => { position.fromArray(this.numbers, from); turn.fromArray(this.numbers, from + 3).normalize(); }}));
    this.openings = hands.map(() => null);
    this.meshes = about.visuals.map((visual, index) => visual.shape === 'mesh' ? meshOf(cornersOf(index)) : null);
    const three = from => [from, from + 1, from + 2];
    this.data = {frames: 1, period: 1, links: links.map((link, index) => ({...link, track: link.moves ? index : null})),
      visuals: about.visuals, bases: hands.map((hand, index) => ({hand: index, at: 0, pose: hand.pose, scale: hand.scale})),
      devices: hands.map((hand, index) => ({strings: hand.strings, radius: hand.radius, track: links.length + index})),
      drawn: this.handsAt.map((from, index) => ({asked: three(from + 7), force: three(from + 10),
        tension: hands[index].strings.map((_, string) => from + layout.perHand + string)}))};
  }

  // `numbers`: Picture::draw.
  take(numbers) {
    this.numbers = numbers;
    this.count = numbers[3];
    const {at, normal, force, radius, pressure, sticking} = this.patches;
    for (let row = 0; row < this.count; ++row) {
      const from = this.patchesAt + row * this.layout.patchNumbers;
      for (let axis = 0; axis < 3; ++axis) {
        at[axis][row] = numbers[from + axis];
        normal[axis][row] = numbers[from + 3 + axis];
        force[axis][row] = numbers[from + 6 + axis];
      }
      [radius[row], pressure[row], sticking[row]] = [numbers[from + 9], numbers[from + 10], numbers[from + 11]];
    }
  }

  // Of the whole.
  world() {
    const [time, , , , contacts, , finite] = this.numbers;
    return {time, contacts, finite: finite > 0};
  }
  // Of a hand.
  report(hand) {
    const from = this.handsAt[hand], at = offset => this.numbers[from + offset];
    return {force: [at(10), at(11), at(12)], stiffness: at(13), bound: at(14), share: at(15), touching: at(16) > 0, enabled: at(17) > 0};
  }
}

// Three corners a triangle, each its own.
function meshOf(corners) {
  return {points: Float32Array.from(corners), corners: Uint32Array.from({length: corners.length / 3}, (_, i) => i)};
}
