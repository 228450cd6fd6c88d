#!/usr/bin/env python3
"""The calibration services: held at home, then refined from a wave of the grip; the file says when and how well."""
import calendar
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospkg
import rospy
import rostest
import yaml
from haptic_msgs.msg import DeviceState
from std_srvs.srv import Trigger
from topic_probe import Probe

FILE = os.path.join(os.environ.get("ROS_HOME", "/tmp"), "calibration_test.yaml")
# Two hundred samples a second short of the 20 s wave that is good for 0.05 mm; the twin's exits are the file's.
EXIT_TOLERANCE = 0.5e-3  # [m]


def makers_to_rep103(v):
    """x right, y up, z depth (left-handed: into the screen) -> x forward, y left, z up."""
    return [v[2], -v[0], v[1]]


class Calibration(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("calibration_test")
        cls.state = Probe("/spidar/state", DeviceState)
        cls.state.wait(1, accept=lambda m: m.state == DeviceState.ENABLED)
        cls.wave = rospy.ServiceProxy("/spidar/driver/calibrate_wave", Trigger)
        cls.home = rospy.ServiceProxy("/spidar/driver/calibrate", Trigger)
        cls.wave.wait_for_service(10)

    def test_a_wave_refines_and_is_kept(self):
        # The twin's hand rests at home for its first half second only; at the start the driver calibrated it there.
        answer = self.wave()
        self.assertTrue(answer.success, answer.message)
        self.assertIn("8 s", answer.message)
        self.assertFalse(self.wave().success, "one wave at a time")
        self.assertFalse(self.home().success, "not while a wave is recorded")
        done = self.state.wait(1, accept=lambda m: "from a wave" in m.message or "converge" in m.message, timeout=60)
        self.assertIn("calibrated from a wave of 800 samples", done.message)
        with open(FILE, encoding="utf-8") as text:
            saved = yaml.safe_load(text)
        folder = rospkg.RosPack().get_path("haptic_description")
        with open(os.path.join(folder, "devices", "spidar_g6x3r.yaml"), encoding="utf-8") as text:
            nominal = yaml.safe_load(text)
        self.assertEqual(saved["device"], nominal["name"])
        self.assertLess(abs(calendar.timegm(time.strptime(saved["time"], "%Y-%m-%dT%H:%M:%SZ")) -
                            time.time()), 120)
        self.assertLess(saved["residual"], 20e-6)  # one encoder step is 17 um
        self.assertEqual(len(saved["strings"]), len(nominal["strings"]))
        for found, file in zip(saved["strings"], nominal["strings"]):
            for a, b in zip(found["exit"], makers_to_rep103(file["exit"])):
                self.assertAlmostEqual(a, b, delta=EXIT_TOLERANCE)
        # The pose goes on with the new kinematics: no fault, force still there.
        after = self.state.wait(2)
        self.assertEqual(after.state, DeviceState.ENABLED)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "calibration", Calibration)
