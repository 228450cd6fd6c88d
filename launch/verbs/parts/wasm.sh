# The page on which scenes are touched in a browser: the core as WebAssembly, packed scenes, and one HTML file of both. Sourced.

build_wasm() {  # below build/wasm: touch.js, touch.wasm
  mkdir -p "$BUILD/wasm"
  export NODE_PATH=/usr/share/nodejs  # Emscripten asks node for acorn there, which another node than Debian's would not find
  configure_and_build wasm "$ROOT/penalty_sim/browser" "$BUILD/wasm" touch \
    -DCMAKE_TOOLCHAIN_FILE=/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake
}

# Why the packages of npm cannot be had; nothing where they are there or were fetched.
npm_reason() {
  (cd penalty_sim/session && python3 -B -c '
import npm_modules
try:
    npm_modules.modules()
except npm_modules.Unavailable as reason:
    print(reason)')
}

# Needs sections run, npm and wasm, and the stack's pack_scenes. Scenes whose robots are not installed are left out, with a line each.
touch_page() {  # OUT.html [LINK_BACK]
  build_wasm
  rm -rf "$BUILD/wasm/scenes" && mkdir -p "$BUILD/wasm/scenes" "$LOGS"
  with_progress_or_log scenes "$LOGS/pack_scenes.log" "$BUILD/devel/lib/penalty_sim/pack_scenes" \
    urdf/devices/spidar_g6x3r.yaml "$BUILD/wasm/scenes" urdf/scenes/*.urdf urdf/scenes/*.yaml
  grep '^left out' "$LOGS/pack_scenes.log"
  python3 -B "$ROOT/penalty_sim/browser/touch_page.py" "$BUILD/wasm" "$BUILD/wasm/scenes" "$@"
}
