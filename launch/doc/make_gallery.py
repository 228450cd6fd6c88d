#!/usr/bin/env python3
"""Makes the moving pictures of the gallery: each shipped scene as the 3-D view of its session's page shows it.

    launch/doc/make_gallery.py [SCENE...]        (default: all of them; about 30 s each)

A session of each is recorded by `./run demo`, its page written by `./run report` and drawn by headless Chromium, frame by frame.
"""
import glob
import io
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
GALLERY = os.path.join(ROOT, "launch", "doc", "gallery")
WIDTH, HEIGHT = 480, 320        # [pixels]
NEARLY = 0.75                   # where what moves needs more than this share of it, all is shown
FINER = 2                       # pixels are drawn for each that is kept: smooth edges, which a browser without a graphics card does not draw
SECONDS, RATE = 8, 10           # of a picture [s], [1/s]
CLOSER = 0.6                    # the camera stands at this share of the distance from which all is seen, or as far as what moves needs
LARGEST = 380_000               # of a picture [bytes]: all scenes together stay below 12 MB
QUALITIES = (65, 50, 35, 20, 10)
VIEW = "window.sessions[0].timeline"

# Scene and sentence of each row, in order.
SHOWS = {
    "touch_cube": "The default: the hand presses on a cube, slides along its top and pushes it over the floor.",
    "a_cube": "One cube under the hand, the least there is to measure.",
    "allegro_grasp": "The Allegro hand as published holds a block; the hand pushes it into the fingers.",
    "b_stack": "The hand on top of five stacked cubes.",
    "blocks": "The hand presses on a stack of four blocks and pushes the uppermost.",
    "bounce": "A cube falls 10 mm and bounces without friction or damping: its height stays.",
    "box_on_floor": "The hand presses on a box of 1 kg and slides round its middle.",
    "c_bin": "The hand stirs ten convex pebbles of 20 to 100 corners in a bin.",
    "chain": "A chain of ten links is released; its energy stays constant.",
    "city": "A thousand bodies: stacks, a heap, two robots, a door and a drawer. All bodies sleep but those that the hand touches.",
    "conveyor": "A belt on a load cell carries parcels against a gate and slides on below them; the hand pushes one back.",
    "d_two_hands": "Two devices, two hands: they take the uppermost block between them and lift it.",
    "daruma": "A tumbler with its mass low in it rights itself and rocks.",
    "door": "The hand reaches behind the handle of a hinged door, pulls it open and pushes it shut.",
    "double_pendulum": "A double pendulum, released horizontally.",
    "drawer": "The hand pulls a drawer out by its handle and pushes it shut.",
    "eccentric": "A cube whose centre of mass is off the middle: tilt and depth have closed forms.",
    "four_bar": "The hand pushes a four-bar linkage over, and back from the other side.",
    "free_body": "A free body spins about its middle axis without gravity, and flips.",
    "gear": "A small ball is led along the teeth of a gear.",
    "gimbal_top": "The hand presses on the rim of a spinning disc in gimbals, which yields sideways.",
    "grasped_block": "The free block and the ball of `allegro_grasp` without the hand that holds them: they fall.",
    "panda_touch": "The Panda as published holds its pose; the hand pushes a block under its gripper.",
    "pile300": "Three hundred cubes fall into a bin below the hand.",
    "pyramid15": "Fifteen cubes in a pyramid: it stands.",
    "ramp": "A cube on a slope, at nine tenths of the limit of friction: it stays.",
    "resting": "A cube at rest, sunk in by 98 µm, as the formula says.",
    "seam": "A cube slides over the joint of two floor boxes, which is not felt.",
    "spinning_box": "A box slides and spins: its spin takes away from the friction that slows it.",
    "stack15": "Fifteen stacked cubes, each at the depth that carries those above it.",
    "stick_slip": "A spring draws a block over the floor: it sticks and slips in turn.",
    "table_block": "The table, the block and the ball of `panda_touch`, at rest without the robot.",
    "terrain": "A ball, a puck and a cube on a height field: the ball rolls to and fro in a valley without loss.",
    "tilt": "A tilted cube of 2 m falls from its edge onto its face.",
    "top": "A cone spins on its apex and precesses.",
    "workshop": "Thirty tools on a wall and a shelf; the hand presses on one and draws it along.",
}
HEAD = """# Gallery: scenes, moving

Each picture is eight seconds of a real session, in real time, as the 3-D view of its page shows it (`./run report BAG`). The wire
frame is a SPIDAR-G6X3R with its strings, light blue at rest, yellow to red when tense; the yellow ball is the grip. Red arrows are forces, 15 mm per
newton. Rings are contacts, blue to red by pressure: a closed one sticks, a dashed one slips. Where a scene names no hand, a ball is added
that the simulated hand moves.

The command beside a picture runs its scene with rviz; without `--rviz` it needs no display. `launch/doc/make_gallery.py [SCENE...]` makes
the pictures again. Stills in rviz: [pictures of the scenes](../pictures/README.md).

| scene | |
|---|---|
"""


def readme():
    """The gallery's README: a row for each scene that has its picture."""
    there = [name for name in SHOWS if os.path.exists(os.path.join(GALLERY, name + ".webp"))]
    seen = lambda name: SHOWS[name].replace("`", "").rstrip(".")  # noqa: E731
    return HEAD + "".join(f"| `{name}` | {SHOWS[name]} `./run demo --scene {name} --rviz` ![{seen(name)}]({name}.webp) |\n" for name in there)


def scenes():
    """Names of all shipped scenes, the large ones included."""
    folder = os.path.join(ROOT, "urdf", "scenes")
    paths = glob.glob(os.path.join(folder, "*.[uy]*")) + glob.glob(os.path.join(folder, "large", "*.yaml"))
    return sorted(os.path.splitext(os.path.basename(path))[0] for path in paths)


def run(*words):
    done = subprocess.run([os.path.join(ROOT, "run"), *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"./run {' '.join(words)}: {(done.stderr.strip().splitlines() or ['failed'])[-1]}")


def frames(page, count):
    """PNG images of the view, evenly through the session. Ends of strings may leave the picture, and nothing that moves."""
    page.run(f"""(() => {{ const {{view, canvas}} = {VIEW}; canvas.style.cssText = 'position: fixed; inset: 0; z-index: 9; border-radius: 0; '
      + 'width: {WIDTH}px; height: {HEIGHT}px'; view.pixels = {FINER}; view.resize(); {VIEW}.look('all');
      const {{moving, all}} = view.bounds(), close = view.framed(moving), far = view.framed(all);
      view.place(close.distance > {NEARLY} * far.distance ? far : {{focus: close.focus, distance: Math.max(close.distance, {CLOSER} * far.distance)}});
    }})()""")
    for number in range(count):
        yield page.run(f"""(() => {{ const {{view, canvas}} = {VIEW};
          {VIEW}.go({number} / {RATE}); view.dirty = true; view.draw(); return canvas.toDataURL('image/png'); }})()""")


def picture(images):
    """Bytes of a moving WebP within LARGEST, as good as that allows."""
    for quality in QUALITIES:
        out = io.BytesIO()
        images[0].save(out, "WEBP", save_all=True, append_images=images[1:], duration=round(1000 / RATE), loop=0, quality=quality, method=3,
                       minimize_size=False, kmax=30)
        if out.tell() <= LARGEST:
            break
    return out.getvalue(), quality


def make(name, folder):
    from base64 import b64decode
    bag, html = os.path.join(folder, name + ".bag"), os.path.join(folder, name + ".html")
    run("demo", "--scene", name, "--seconds", str(SECONDS + 1), "--record", bag)
    run("report", bag)
    with Browser(WIDTH, HEIGHT) as page:
        page.open(html)
        page.wait("performance.getEntriesByName('first frame').length > 0 && window.sessions[0].series !== null")
        shots = [Image.open(io.BytesIO(b64decode(url.split(",")[1]))).convert("RGB").resize((WIDTH, HEIGHT), Image.BOX)
                 for url in frames(page, SECONDS * RATE)]
    content, quality = picture(shots)
    path = os.path.join(GALLERY, name + ".webp")
    with open(path, "wb") as file:
        file.write(content)
    os.remove(bag)
    print(f"{os.path.relpath(path, ROOT)}: {len(content) / 1000:.0f} kB, {len(shots)} frames, quality {quality}", flush=True)


def main():
    known = scenes()
    names = sys.argv[1:] or known
    for name in names:
        if name not in known:
            sys.exit(f"make_gallery: unknown scene '{name}'; there are {' '.join(known)}")
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            try:
                make(name, folder)
            except RuntimeError as error:
                failed += 1
                print(f"make_gallery: {name}: {error}", file=sys.stderr, flush=True)
    with open(os.path.join(GALLERY, "README.md"), "w", encoding="utf-8") as file:
        file.write(readme())
    sys.exit(failed > 0)


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(ROOT, "test", "commands"))
    try:
        from PIL import Image
    except ImportError:
        sys.exit("make_gallery: needs python3-pil: ./run setup report")
    from browser import Browser
    main()
