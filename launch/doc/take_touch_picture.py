#!/usr/bin/env python3
"""Takes the picture of the page on which scenes are touched, launch/doc/touch/page.png: the hand presses on the cube.

    launch/doc/take_touch_picture.py [PAGE]        (default: build/docs/html/touch.html, which ./run docs makes)
"""
import io
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PICTURE = os.path.join(ROOT, "launch", "doc", "touch", "page.png")
WIDTH, HEIGHT = 1100, 700   # of the window [pixels]
FINER = 2                   # pixels are drawn for each that is kept: smooth edges, which a browser without a graphics card does not draw
COLOURS = 192               # of the palette, as take_pictures.py has it
LEAD = (0, 0, -0.022)      # of the hand, from home into the cube below it [m]
PRESSED = 2                 # force on the hand at which the picture is taken [N]


def main():
    page_file = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else os.path.join(ROOT, "build", "docs", "html", "touch.html")
    if not os.path.isfile(page_file):
        sys.exit(f"take_touch_picture: {page_file}: no such file; ./run docs makes it")
    with Browser(WIDTH, HEIGHT) as page:
        page.open(page_file)
        page.wait("performance.getEntriesByName('first frame').length > 0")
        page.run("document.activeElement.blur()")
        page.run(f"touchPage.view.keepPace = () => {{}}; touchPage.view.pixels = {FINER}; touchPage.view.resize()")
        page.run(f"touchPage.led = null; touchPage.lead(new touchPage.grip.constructor({', '.join(map(str, LEAD))}))")
        page.wait(f"Math.hypot(...touchPage.live.report(0).force) > {PRESSED} && touchPage.error && touchPage.live.world().time > 2")
        raw = page.picture()
    image = Image.open(io.BytesIO(raw)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    image.save(PICTURE, optimize=True)
    print(f"{os.path.relpath(PICTURE, ROOT)}: {os.path.getsize(PICTURE) / 1000:.0f} kB")


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(ROOT, "test", "commands"))
    try:
        from PIL import Image
    except ImportError:
        sys.exit("take_touch_picture: needs python3-pil: ./run setup report")
    from browser import Browser
    main()
