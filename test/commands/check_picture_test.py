#!/usr/bin/python3
"""Pictures of `./run check --picture`: a device's against the reach that the check finds in another way, a scene's against its words. The page
of `./run check DEVICE --report`: against what the check finds by trying directions."""
import json
import os
import re
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

from run_verb import ROOT, Call

sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
sys.path.insert(0, os.path.join(ROOT, "penalty_sim", "scene"))
import check_picture  # noqa: E402
import haptic  # noqa: E402

AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]  # the directions of the check's reach
PLACE = os.path.join(tempfile.gettempdir(), "haptic_check_page.html")  # never written
SVG = "{http://www.w3.org/2000/svg}"


class Pictures(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.picture = os.path.join(holder.name, "check.svg")

    def check(self, *words):
        call = Call("check", *words, "--picture", self.picture)
        self.assertEqual(call.code, 0, call.errors)
        root = xml.parse(self.picture).getroot()
        self.assertEqual(root.get("aria-label"), root.find(SVG + "title").text)
        return call.out, [text.text for text in root.iter(SVG + "text")], root

    def test_a_device_presents_1_n_as_far_as_the_check_says(self):
        """The check searches along each axis with λ → 0 (spidar/device_check.cpp); the picture asks for the tensions of the driver."""
        for name in ("spidar_g6x3r", "spidar_4"):
            said, words, root = self.check(name)
            device = haptic.Device(os.path.join(ROOT, "urdf", "devices", name + ".yaml"))
            reach = re.search(r"workspace \[mm\].*?: (.*)", said).group(1)
            for axis, (least, most) in enumerate(re.findall(r"(-?\d+) to (-?\d+)", reach)):
                for end in (float(least), float(most)):
                    # The driver blurs the border (border_lambda), which costs up to a fifth of the way; it presents nothing beyond it.
                    for share, presents in ((0.8, True), (1.05, False)):
                        point = [1e-3 * share * end * (axis == other) for other in range(3)]
                        self.assertEqual(check_picture.band(device, point, AXES) >= 1, presents, (name, axis, end, share))
            self.assertEqual(len(list(root.iter(SVG + "circle"))), 3 * device.strings + 1, "an exit in each section, and one in the legend")
            self.assertEqual(sum("[mm]" in text for text in words), 6, "both axes of each section have a unit")

    def test_a_certificate_has_the_numbers_of_its_text(self):
        said, words, _ = self.check("touch_cube")
        limit = re.search(r"velocity Verlet to ([\d.]+) ms", said).group(1)
        met, held = re.search(r"PASS, ([\d.]+) N/mm when.* relaxed hand ([\d.]+)", said).groups()
        self.assertIn(f"1 of {limit} ms: velocity Verlet is stable too", words)
        self.assertIn(f"{met} of {held} N/mm: a relaxed hand holds it", words)

    def test_wrong_words_get_one_line(self):
        for words, says in ((("touch_cube", "--picture"), "--picture"), (("touch_cube", "--picture", "/no/such/folder/a.svg"), "/no/such/folder")):
            call = Call("check", *words)
            self.assertNotEqual(call.code, 0)
            self.assertEqual(len(call.errors), 1, call.errors)
            self.assertIn(says, call.errors[0])


class Pages(unittest.TestCase):
    def test_a_page_of_two_devices_agrees_with_the_check_and_asks_for_nothing_from_outside(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "page.html")
            call = Call("check", "spidar_g6x3r", "--report", path, "--beside", "spidar_4", "--force", "2")
            self.assertEqual(call.code, 0, call.errors)
            with open(path, encoding="utf-8") as page:
                text = page.read()
        self.assertIsNone(re.search(r'(src|href)=|https?://', text))
        devices = json.loads(re.search(r'id="data">(.*?)</script>', text).group(1))
        self.assertEqual([(device["name"], len(device["regions"])) for device in devices], [("SPIDAR-G6X3R", 2), ("SPIDAR-4", 1)])
        # The check tries 26 directions and lets 2 % of a force be lost; the page has the worst of all.
        force, torque = map(float, re.search(r"presentable at home in every direction: ([\d.]+) N, ([\d.]+)", call.out).groups())
        for name, tried in (("force", force), ("torque", torque)):
            self.assertLess(devices[0]["home"][name], 1.03 * tried)
            self.assertGreater(devices[0]["home"][name], 0.7 * tried)
        for device in devices:
            for region in device["regions"]:
                self.assertLess(region["undecided"], 0.02)
                self.assertGreater(region["inside"], 0)

    def test_wrong_words_get_one_line(self):
        for words, says in ((("spidar_4", "--beside", "spidar_g6x3r"), "--report"), (("spidar_4", "--report", "/no/such/folder/a.html"), "folder"),
                            (("spidar_4", "--report", PLACE, "--torque", "1"), "point grip"), (("touch_cube", "--report", PLACE), "--report")):
            call = Call("check", *words)
            self.assertNotEqual(call.code, 0)
            self.assertEqual(len(call.errors), 1, call.errors)
            self.assertIn(says, call.errors[0])


if __name__ == "__main__":
    unittest.main()
