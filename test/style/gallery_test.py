#!/usr/bin/python3
"""Each scene that has a hand has a picture, small enough, and a line in the gallery; and nothing else has."""
import os
import re
import sys
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "launch", "doc"))

import take_pictures

LARGEST = 150 * 1024  # [bytes]


class Gallery(unittest.TestCase):
    def test_scenes_pictures_and_lines_are_the_same(self):
        scenes = set(take_pictures.scenes_with_a_hand())
        self.assertIn("touch_cube", scenes)
        pictures = {name[:-4] for name in os.listdir(take_pictures.PICTURES) if name.endswith(".png")}
        with open(os.path.join(take_pictures.PICTURES, "README.md"), encoding="utf-8") as page:
            rows = re.findall(r"^\| `(\w+)` \| \S.*!\[\1\]\(\1\.png\) \|$", page.read(), re.MULTILINE)
        self.assertEqual(pictures, scenes, "run launch/doc/take_pictures.py SCENE")
        self.assertEqual(sorted(rows), sorted(scenes), "one line per scene in launch/doc/pictures/README.md")
        for name in pictures:
            self.assertLessEqual(os.path.getsize(os.path.join(take_pictures.PICTURES, name + ".png")), LARGEST, name)


if __name__ == "__main__":
    unittest.main()
