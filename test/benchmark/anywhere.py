"""Sessions seen anywhere: the page in 3-D, MCAP files, the gallery, scenes touched in a browser. `./run bench anywhere`.

    anywhere.py page3d | mcap [FILE.mcap] | gallery | wasm

`wasm` wants what touch_page of launch/verbs/parts/wasm.sh leaves below build/wasm, pack_scenes and scene_hashes.

`mcap` records an hour unless it is given the recording of one. Figures as lines `figure NAME VALUE UNIT`.
"""
import contextlib
import glob
import json
import os
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
for folder in (("test", "commands"), ("penalty_sim", "session"), ("launch", "doc")):
    sys.path.insert(0, os.path.join(ROOT, *folder))
WIDTH, HEIGHT = 1280, 800     # of the window [pixels]
MINUTE, HOUR = 60, 3600       # [s]
PLAYED = 5                    # of the session, while frames are counted [s]
LOADS = 5                     # of the page; the median counts
VIEW = "window.sessions[0].timeline"
REPLAYED = 10                 # of a session that a browser replays [s]
STEPS, ROUNDS = 1000, 5       # of each scene whose hashes are compared; of touch_cube for its step's time
BASELINE = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2"}  # the loader takes the library for any processor


def figure(name, value, unit):
    print(f"figure {name} {value:g} {unit}", flush=True)


def run(*words):
    done = subprocess.run([os.path.join(ROOT, "run"), *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"anywhere: ./run {' '.join(words)}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return {line.split()[1]: float(line.split()[2]) for line in done.stdout.splitlines() if line.startswith("figure ")}


@contextlib.contextmanager
def opened(html, ready="true"):
    """A page in headless Chromium, which draws on the processor, once it has drawn its first frame and `ready` holds. Its `first_frame` [ms];
    at the end its `outside`: addresses that it asked for outside of itself."""
    from browser import Browser
    with Browser(WIDTH, HEIGHT) as page:
        page.open(html)
        page.wait(f"performance.getEntriesByName('first frame').length > 0 && {ready}")
        page.first_frame, page.outside = page.run("performance.getEntriesByName('first frame')[0].startTime"), set()
        yield page
        page.outside |= {url for url in page.requests if not url.startswith(("file:///", "data:", "blob:"))}


def played(page):
    """(CPU ms of all processes of the browser, frames, s) of PLAYED seconds."""
    page.run(f"{VIEW}.go(0.5); {VIEW}.play(true)")
    page.wait("window.sessions[0].now > 2")  # the pixels that this machine manages have settled
    began, used, frames = time.monotonic(), page.processor_seconds(), page.run(f"{VIEW}.view.frames")
    time.sleep(PLAYED)
    count = page.run(f"{VIEW}.view.frames") - frames
    used, lasted = page.processor_seconds() - used, time.monotonic() - began
    page.run(f"{VIEW}.play(false)")
    return 1000 * used, max(count, 1), lasted


def page3d(folder):
    """A minute of touch_cube at 1280 x 800."""
    bag, html = os.path.join(folder, "minute.bag"), os.path.join(folder, "minute.html")
    run("demo", "--scene", "touch_cube", "--seconds", str(MINUTE), "--record", bag)
    said = run("report", bag)
    figure("page3d.kb_per_minute", os.path.getsize(html) / 1000, "kB")
    figure("page3d.pose_error_um", said["session.pose_error_um"], "um")
    firsts, outside, ready = [], set(), "window.sessions[0].series !== null"
    for _ in range(LOADS):
        with opened(html, ready) as page:
            firsts.append(page.first_frame)
        outside |= page.outside
    print(f"first frame after {', '.join(f'{ms:.0f}' for ms in sorted(firsts))} ms")
    figure("page3d.first_frame_ms", sorted(firsts)[LOADS // 2], "ms")
    with opened(html, ready) as page:
        used, count, lasted = played(page)
        pixels = page.run(f"[{VIEW}.canvas.width, {VIEW}.canvas.height]")
        page.run(f"{VIEW}.view.scene.visible = false")
        empty, empty_count, _ = played(page)
    outside |= page.outside
    print(f"played {lasted:.1f} s in {count} frames of {pixels[0]} x {pixels[1]} pixels; CPU time is that of all processes of the browser, and "
          f"{empty / empty_count:.1f} ms a frame when nothing is in the picture")
    figure("page3d.cpu_ms_per_frame", used / count, "ms")
    figure("page3d.asks_outside", len(outside), "1")


def mcap(folder, path=None):
    """An hour of touch_cube as MCAP, by the format's own library and by a replay."""
    import npm_modules
    if path is None:
        path = os.path.join(folder, "hour.mcap")
        run("demo", "--scene", "touch_cube", "--seconds", str(HOUR), "--record", path)
    done = subprocess.run(["node", os.path.join(ROOT, "test", "commands", "read_mcap.mjs"), npm_modules.modules(), path],
                          capture_output=True, text=True, check=False)
    seen = json.loads(done.stdout) if done.returncode == 0 else {}
    print(f"{os.path.getsize(path) / 1e6:.0f} MB, {seen.get('messages', 0)} messages, {seen.get('ticks', 0)} ticks, {seen.get('seconds', 0):.0f} s, "
          f"lost: {seen.get('lost', 'unknown')}")
    if seen.get("seconds", 0) < HOUR - 1:
        sys.exit(f"anywhere: {path} holds no hour: {done.stderr.strip()[-300:]}")
    figure("mcap.reader_errors", int(done.returncode != 0) + int(seen["messages"] != seen["told"]) + seen["early"], "1")
    figure("mcap.messages_lost", sum(seen["lost"].values()) + seen["ticksMissing"], "1")
    figure("mcap.replay_mismatches", run("replay", path)["replay.mismatches"], "1")


def gallery():
    import make_gallery
    sizes = [os.path.getsize(os.path.join(make_gallery.GALLERY, name + ".webp")) for name in make_gallery.scenes()
             if os.path.exists(os.path.join(make_gallery.GALLERY, name + ".webp"))]
    print(f"{len(make_gallery.scenes())} scenes are shipped; largest picture {max(sizes, default=0) / 1000:.0f} kB")
    figure("gallery.scenes", len(sizes), "1")
    figure("gallery.kb", sum(sizes) / 1000, "kB")


def native_hashes(program, environment):
    """Name and hash of each scene, read from its own file."""
    done = subprocess.run([program, str(STEPS)], capture_output=True, text=True, check=True, env={**os.environ, **environment})
    return {os.path.splitext(name)[0]: value for name, value in (line.split(None, 1) for line in done.stdout.splitlines())}


def runs(*command, environment=()):
    """Name -> (hash, median step in µs), as pack_scenes --run and wasm_runs.mjs print them."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **dict(environment)})
    if done.returncode != 0:
        sys.exit(f"anywhere: {command[0]}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return {name: (value, float(time_us)) for name, value, time_us in (line.split() for line in done.stdout.splitlines())}


def wasm(folder):
    """The bits of every packed scene, a step's time against the native one, and the page until it can be touched."""
    build = os.path.join(ROOT, "build")
    scenes = {name[:-len(".scene")]: os.path.join(build, "wasm", "scenes", name)
              for name in sorted(os.listdir(os.path.join(build, "wasm", "scenes")))}
    hashes = glob.glob(os.path.join(build, "bench", "**", "scene_hashes"), recursive=True)[0]
    in_browser = ["node", os.path.join(ROOT, "test", "benchmark", "wasm_runs.mjs"), os.path.join(build, "wasm"), str(STEPS)]
    told = [native_hashes(hashes, BASELINE), native_hashes(hashes, {}),
            {name: value for name, (value, _) in runs(*in_browser, *scenes.values()).items()}]
    differ = [name for name in sorted(set().union(*told)) if len({each.get(name) for each in told}) > 1]
    print(f"{len(told[-1])} scenes, {STEPS} steps: native for any processor, native for this one, WebAssembly; different: {differ or 'none'}")
    figure("wasm.bits_differ", len(differ), "1")
    ratios = []
    for _ in range(ROUNDS):
        native = runs(os.path.join(build, "devel", "lib", "penalty_sim", "pack_scenes"), "--run", scenes["touch_cube"], str(10 * STEPS), environment=BASELINE)
        ratios.append(runs(*in_browser[:-1], str(10 * STEPS), scenes["touch_cube"])["touch_cube"][1] / native["touch_cube"][1])
    print(f"a step of touch_cube, {native['touch_cube'][1]:.2f} µs natively, over native: {', '.join(f'{ratio:.2f}' for ratio in sorted(ratios))}")
    figure("wasm.step_ratio", sorted(ratios)[ROUNDS // 2], "1")
    html = os.path.join(build, "wasm", "touch.html")
    firsts = []
    for _ in range(LOADS):
        with opened(html) as page:
            firsts.append(page.first_frame)
            page.drag((450, 380), (450, 420), (450, 480), (450, 540))
            page.wait("Math.hypot(...touchPage.live.report(0).force) > 1")  # what is led into the cube is held back
        if page.errors or page.outside:
            sys.exit(f"anywhere: the page: {(page.errors + sorted(page.outside))[0]}")
    print(f"first picture of a running scene after {', '.join(f'{ms:.0f}' for ms in sorted(firsts))} ms")
    figure("wasm.ready_ms", sorted(firsts)[LOADS // 2], "ms")
    bag = os.path.join(folder, "short.bag")
    run("demo", "--scene", "touch_cube", "--seconds", str(REPLAYED), "--record", bag)
    run("export", bag, "--session")
    with opened(html) as page:
        page.choose("session", os.path.join(folder, "short.session"))
        page.wait("touchPage.replays && touchPage.about !== null")
        ticks, done, compared, same = page.wait("(p => p.done === p.ticks && [p.ticks, p.done, p.compared, p.same])(touchPage.program.progress())")
    print(f"a session of {ticks} ticks in the browser: {done} replayed, {compared} compared, {same} the same")
    if compared < 1000 * REPLAYED / 2:
        sys.exit("anywhere: the session was not compared")
    figure("wasm.replay_mismatches", compared - same, "1")


def main():
    with tempfile.TemporaryDirectory(prefix="haptic_anywhere_") as folder:
        if sys.argv[1] == "page3d":
            page3d(folder)
        elif sys.argv[1] == "mcap":
            mcap(folder, *sys.argv[2:])
        elif sys.argv[1] == "wasm":
            wasm(folder)
        else:
            gallery()


if __name__ == "__main__":
    main()
