#!/usr/bin/python3
"""Recordings that end early: what is left is used and said, whatever byte they end at; the recording itself stays as it is."""
import os
import re
import shutil
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"), os.path.join(ROOT, "penalty_sim", "session")]
import genpy  # noqa: E402
import rosbag  # noqa: E402
from haptic_msgs.msg import SessionInfo, TickRecord  # noqa: E402

import cut_recording  # noqa: E402
import mcap_bag  # noqa: E402

RECORDS, TICKS, RATE = 300, 10, 500.0


class CutRecordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.bag, cls.mcap = (os.path.join(cls.folder, "whole." + ending) for ending in ("bag", "mcap"))
        with rosbag.Bag(cls.bag, "w", compression="lz4", chunk_threshold=20000) as bag:
            bag.write("/recorded/session", SessionInfo(rate=RATE, scene_text="x" * 50, world_state=[1.0] * 10), genpy.Time(1))
            for i in range(RECORDS):
                record = TickRecord(first_tick=TICKS * i, ticks=TICKS, counts=[i * 7919] * 800)
                bag.write("/recorded/ticks", record, genpy.Time(1 + 0.02 * i))
        mcap_bag.to_mcap(cls.bag, cls.mcap)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def test_whole_ones_are_taken_as_they_are(self):
        for path in (self.bag, self.mcap):
            self.assertEqual(cut_recording.usable(path, self.folder), (path, ""))

    def test_what_is_left_is_used_and_said(self):
        for whole, name in ((self.bag, "cut.bag"), (self.bag, "run.bag.active"), (self.mcap, "cut.mcap")):
            size, ticks = os.path.getsize(whole), []
            for percent in range(30, 100, 3):
                cut = shutil.copy(whole, os.path.join(self.folder, name))
                os.truncate(cut, size * percent // 100)
                path, said = cut_recording.usable(cut, self.folder)
                self.assertEqual(os.path.getsize(cut), size * percent // 100, "it stays as it is")
                found = re.search(r"was cut off: (\d+) ticks \(([\d.]+) s\) are used; (its last \d+ bytes|its index alone)", said)
                self.assertTrue(found, said)
                ticks.append(int(found.group(1)))
                self.assertAlmostEqual(float(found.group(2)), ticks[-1] / RATE, places=3)
                if path.endswith(".bag"):
                    with rosbag.Bag(path) as bag:
                        read = [m.first_tick for t, m, _ in bag.read_messages() if t == "/recorded/ticks"]
                    self.assertEqual(read, [TICKS * i for i in range(ticks[-1] // TICKS)], "from the beginning, without a gap")
            self.assertEqual(ticks, sorted(ticks))
            self.assertGreater(len(set(ticks)), 2, "chunk after chunk")
            self.assertLessEqual(ticks[-1], RECORDS * TICKS)

    def test_nothing_left_is_one_line(self):
        cut = shutil.copy(self.bag, os.path.join(self.folder, "early.bag"))
        os.truncate(cut, 4200)
        with self.assertRaisesRegex(rosbag.ROSBagException, "^[^\n]*early.bag: is cut before its first tick[^\n]*$"):
            cut_recording.usable(cut, self.folder)


if __name__ == "__main__":
    unittest.main()
