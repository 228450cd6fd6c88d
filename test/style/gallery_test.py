#!/usr/bin/python3
"""Each scene that has a hand has a picture, moving ones are of scenes, small enough, with a row."""
import os
import re
import struct
import sys
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "launch", "doc"))

import make_gallery
import take_pictures

LARGEST = 150 * 1024  # [bytes]
LARGEST_MOVING, ALL_MOVING = 600_000, 12_000_000  # [bytes]
LEAST_LASTS, LONGEST_STEP = 8000, 200  # of a picture, and from one frame to the next where something moves [ms]


def frames_of(path):
    """How long each frame of an animated WebP stays [ms]: its chunks ANMF. Frames without a change are one. Raises ValueError for anything else."""
    with open(path, "rb") as file:
        raw = file.read()
    if raw[:4] != b"RIFF" or raw[8:12] != b"WEBP" or len(raw) != 8 + struct.unpack_from("<I", raw, 4)[0]:
        raise ValueError(f"{path} is no whole WebP")
    at, lasts = 12, []
    while at < len(raw):
        kind, size = struct.unpack_from("<4sI", raw, at)
        if kind == b"ANMF":
            lasts.append(int.from_bytes(raw[at + 20:at + 23], "little"))
        at += 8 + size + size % 2
    return lasts


class Gallery(unittest.TestCase):
    def test_scenes_pictures_and_lines_are_the_same(self):
        scenes = set(take_pictures.scenes_with_a_hand())
        self.assertIn("touch_cube", scenes)
        pictures = {name[:-4] for name in os.listdir(take_pictures.PICTURES) if name.endswith(".png")}
        with open(os.path.join(take_pictures.PICTURES, "README.md"), encoding="utf-8") as page:
            rows = re.findall(r"^\| `(\w+)` \| \S.*!\[[^\]]{20,}\]\(\1\.png\) \|$", page.read(), re.MULTILINE)
        self.assertEqual(pictures, scenes, "run launch/doc/take_pictures.py SCENE")
        self.assertEqual(sorted(rows), sorted(scenes), "one line per scene in launch/doc/pictures/README.md")
        for name in pictures:
            self.assertLessEqual(os.path.getsize(os.path.join(take_pictures.PICTURES, name + ".png")), LARGEST, name)

    def test_moving_pictures_are_of_scenes_and_have_a_row(self):
        scenes = make_gallery.scenes()
        self.assertEqual(sorted(make_gallery.SHOWS), scenes, "one sentence per scene in launch/doc/make_gallery.py")
        with open(os.path.join(make_gallery.GALLERY, "README.md"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page, make_gallery.readme(), "run launch/doc/make_gallery.py SCENE, which writes the page")
        pictures = sorted(name[:-5] for name in os.listdir(make_gallery.GALLERY) if name.endswith(".webp"))
        rows = re.findall(r"^\| `(\w+)` \| \S.*\. `\./run demo --scene \1 --rviz` !\[[^\]]{20,}\]\(\1\.webp\) \|$", page, re.MULTILINE)
        self.assertEqual(sorted(rows), pictures)
        self.assertEqual(pictures, scenes, "run launch/doc/make_gallery.py SCENE")
        sizes = []
        for name in pictures:
            path = os.path.join(make_gallery.GALLERY, name + ".webp")
            sizes.append(os.path.getsize(path))
            self.assertLessEqual(sizes[-1], LARGEST_MOVING, name)
            lasts = frames_of(path)
            self.assertGreaterEqual(sum(lasts), LEAST_LASTS, name)
            self.assertLessEqual(min(lasts), LONGEST_STEP, name)
        self.assertLessEqual(sum(sizes), ALL_MOVING)


if __name__ == "__main__":
    unittest.main()
