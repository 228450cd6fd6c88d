#!/usr/bin/python3
"""The light configuration of a view is the dark one in other colours, and both load the panel."""
import os
import re
import unittest

VIEWS = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "launch", "rviz")
COLOURS = re.compile(r"^.*Color: .*$", re.MULTILINE)


class Views(unittest.TestCase):
    def test_dark_and_light_differ_in_colours_alone(self):
        names = sorted(name[:-10] for name in os.listdir(VIEWS) if name.endswith("_dark.rviz"))
        self.assertEqual(names, ["demo", "two_hands"])
        for name in names:
            texts = []
            for ground in ("dark", "light"):
                with open(os.path.join(VIEWS, f"{name}_{ground}.rviz"), encoding="utf-8") as file:
                    texts.append(file.read())
                self.assertIn("Class: haptic_bridge/HapticPanel", texts[-1])
                self.assertIn("Name: Following the", texts[-1])
            self.assertNotEqual(*texts)
            self.assertEqual(*(COLOURS.sub("", text) for text in texts))


if __name__ == "__main__":
    unittest.main()
