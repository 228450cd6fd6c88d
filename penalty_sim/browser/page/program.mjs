// The program in WebAssembly: scenes and sessions in, numbers out.
export class Program {
  // `wasm`: its bytes; `make`: Emscripten's loader.
  static async load(wasm, make) {
    const program = new Program();
    program.module = await make({wasmBinary: wasm});
    return program;
  }

  text(pointer) { return this.module.UTF8ToString(pointer); }
  // Valid until the next call; `copied` for longer.
  doubles(pointer, count) { return this.module.HEAPF64.subarray(pointer / 8, pointer / 8 + count); }
  copied(pointer, count) { return this.doubles(pointer, count).slice(); }

  put(bytes) { const room = this.module._haptic_room(bytes.length); this.module.HEAPU8.set(bytes, room); }

  // Opens a packed scene, or a packed session. Both throw an Error with one line.
  open(bytes) { return this.opened(bytes, this.module._haptic_open); }
  openSession(bytes) { return this.opened(bytes, this.module._haptic_open_session); }
  opened(bytes, open) {
    this.put(bytes);
    const refused = this.text(open());
    if (refused) throw new Error(refused);
    return JSON.parse(this.text(this.module._haptic_about()));
  }
  corners(visual) {
    const count = this.module._haptic_corners(visual);
    return this.copied(this.module._haptic_numbers(), count);
  }
  ticks(count) { this.module._haptic_ticks(count); }
  picture() {
    const count = this.module._haptic_picture();
    return this.copied(this.module._haptic_drawn(), count);
  }
  aim(hand, [x, y, z]) { this.module._haptic_aim(hand, x, y, z); }
  letGo(hand) { this.module._haptic_let_go(hand); }
  aimed(hand) {
    const [x, y, z, led] = this.doubles(this.module._haptic_aimed(hand), 4);
    return {at: [x, y, z], led: led > 0};
  }
  tune(stiffness, friction) { return this.text(this.module._haptic_tune(stiffness, friction)); }
  estimate() {
    const [position, force] = this.doubles(this.module._haptic_estimate(), 2);
    return {position, force};
  }
  progress() {
    const [ticks, done, compared, same] = this.doubles(this.module._haptic_progress(), 4);
    return {ticks, done, compared, same};
  }
}
