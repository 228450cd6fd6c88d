"""Sessions seen anywhere: the page in 3-D, MCAP files, the gallery. `./run bench anywhere`.

    anywhere.py page3d | mcap [FILE.mcap] | gallery

`mcap` records an hour unless it is given the recording of one. Figures as lines `figure NAME VALUE UNIT`.
"""
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


def figure(name, value, unit):
    print(f"figure {name} {value:g} {unit}", flush=True)


def run(*words):
    done = subprocess.run([os.path.join(ROOT, "run"), *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"anywhere: ./run {' '.join(words)}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")
    return {line.split()[1]: float(line.split()[2]) for line in done.stdout.splitlines() if line.startswith("figure ")}


def page3d(folder):
    """A minute of touch_cube at 1280 x 800 in headless Chromium, which draws on the processor."""
    from browser import Browser
    bag, html = os.path.join(folder, "minute.bag"), os.path.join(folder, "minute.html")
    run("demo", "--scene", "touch_cube", "--seconds", str(MINUTE), "--record", bag)
    said = run("report", bag)
    figure("page3d.kb_per_minute", os.path.getsize(html) / 1000, "kB")
    figure("page3d.pose_error_um", said["session.pose_error_um"], "um")
    firsts, outside = [], set()
    for _ in range(LOADS):
        with Browser(WIDTH, HEIGHT) as page:
            page.open(html)
            page.wait("performance.getEntriesByName('first frame').length > 0")
            firsts.append(page.run("performance.getEntriesByName('first frame')[0].startTime"))
            page.wait("!!window.sessions?.[0]?.series")
            outside |= {url for url in page.requests if not url.startswith(("file:///", "data:"))}
    print(f"first frame after {', '.join(f'{ms:.0f}' for ms in sorted(firsts))} ms")
    figure("page3d.first_frame_ms", sorted(firsts)[LOADS // 2], "ms")
    with Browser(WIDTH, HEIGHT) as page:
        page.open(html)
        page.wait("performance.getEntriesByName('first frame').length > 0 && window.sessions[0].series !== null")
        page.run(f"{VIEW}.go(0.5); {VIEW}.play(true)")
        page.wait("window.sessions[0].now > 2")  # the pixels that this machine manages have settled
        began, used, frames = time.monotonic(), page.processor_seconds(), page.run(f"{VIEW}.view.frames")
        time.sleep(PLAYED)
        count = page.run(f"{VIEW}.view.frames") - frames
        used, lasted = page.processor_seconds() - used, time.monotonic() - began
        pixels = page.run(f"[{VIEW}.canvas.width, {VIEW}.canvas.height]")
        page.run(f"{VIEW}.play(false)")
        outside |= {url for url in page.requests if not url.startswith(("file:///", "data:"))}
    print(f"played {lasted:.1f} s in {count} frames of {pixels[0]} x {pixels[1]} pixels; CPU time is that of all processes of the browser")
    figure("page3d.cpu_ms_per_frame", 1000 * used / max(count, 1), "ms")
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


def main():
    with tempfile.TemporaryDirectory(prefix="haptic_anywhere_") as folder:
        if sys.argv[1] == "page3d":
            page3d(folder)
        elif sys.argv[1] == "mcap":
            mcap(folder, *sys.argv[2:])
        else:
            gallery()


if __name__ == "__main__":
    main()
