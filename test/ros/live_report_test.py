#!/usr/bin/env python3
"""The live report comes while somebody listens, adds up, and is not made for nobody."""
import math
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from haptic_msgs.msg import Contacts, LiveReport, TickStatistics
from topic_probe import Probe


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("live_report_test")
        Probe("/tick_statistics", TickStatistics).wait(1, timeout=40)

    def test_its_numbers(self):
        Probe("/contacts", Contacts).wait(1, timeout=30, accept=lambda m: len(m.contacts) > 1)  # the hand is on the cube
        probe = Probe("/live_report", LiveReport)
        last = probe.wait(4, timeout=20)
        probe.close()
        self.assertEqual(last.header.frame_id, "world")
        self.assertEqual((last.step_size, last.pointers), (0.001, ["pointer"]))
        self.assertAlmostEqual(last.time, last.step * last.step_size, places=6)
        self.assertIn(last.order, (1, 2))
        self.assertEqual((len(last.force_error), len(last.torque_error)), (1, 1))
        errors = [last.position_error, last.rotation_error, last.energy_error, last.force_error[0], last.torque_error[0]]
        self.assertTrue(all(math.isfinite(e) and e >= 0 for e in errors), errors)
        self.assertLess(last.position_error, 1e-3)  # 16 ms of a body that moves at some cm/s
        stages = [last.stage_search, last.stage_detection, last.stage_volume, last.stage_force, last.stage_motion]
        self.assertTrue(all(s >= 0 for s in stages), stages)
        self.assertTrue(0 < sum(stages) < 1e-3, "a step of this scene takes some 10 us")
        counts = [m.estimates for m in probe.messages]
        self.assertEqual(counts, list(range(counts[0], counts[0] + len(counts))))
        self.assertLess(probe.rate(), 2.5)  # twice a second; slower on a busy machine

    def test_nothing_is_made_for_nobody(self):
        probe = Probe("/live_report", LiveReport)
        before = probe.wait(1, timeout=20)
        probe.close()
        time.sleep(3)
        again = Probe("/live_report", LiveReport)
        after = again.wait(1, timeout=20)
        again.close()
        self.assertLessEqual(after.estimates - before.estimates, 2, "one that was under way, and this one")
        self.assertGreater(after.step, before.step, "the loop went on")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "live_report", Live, sys.argv)
