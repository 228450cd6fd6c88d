#!/usr/bin/env python3
"""The driver as a node: wrench commands by topic, their frames, their age, and what is refused."""
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from geometry_msgs.msg import PoseStamped, Vector3, Wrench, WrenchStamped
from haptic_msgs.msg import DeviceState
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from topic_probe import Probe

AGE_LIMIT, DECAY = 0.03, 0.02  # [s] of the driver: then the wrench is gone
SLACK = 0.15                   # [s] that python and the topics may add


class DriverAlone(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("driver_alone_test")
        cls.state = Probe("/spidar/state", DeviceState)
        cls.wrench = Probe("/spidar/wrench", WrenchStamped)
        cls.publisher = rospy.Publisher("/spidar/wrench_command", WrenchStamped, queue_size=1, tcp_nodelay=True)
        cls.state.wait(1, accept=lambda m: m.state == DeviceState.ENABLED)
        cls.wrench.wait(10)
        time.sleep(1.0)  # the enable ramp

    def command(self, force, frame="spidar_base", seconds=0.5):
        """Asks for a force for a while; the achieved force at the end."""
        self.wrench.clear()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.publisher.publish(Header(stamp=rospy.Time.now(), frame_id=frame), Wrench(force=Vector3(*force)))
            time.sleep(0.005)
        return self.wrench.wait(5).wrench.force

    def assert_force(self, force, expected, tolerance):
        for axis, value in zip("xyz", expected):
            self.assertAlmostEqual(getattr(force, axis), value, delta=tolerance, msg=f"axis {axis}: {force}")

    def test_command_is_presented_and_ends_with_its_sender(self):
        force = self.command((0, 2, 0))
        self.assert_force(force, (0, 2, 0), 0.1)  # λ of the device file: 3 %
        self.wrench.clear()
        time.sleep(AGE_LIMIT + DECAY + SLACK)
        force = self.wrench.messages[-1].wrench.force
        self.assert_force(force, (0, 0, 0), 0.1)

    def test_frames(self):
        self.assert_force(self.command((2, 0, 0), frame="turned"), (0, 2, 0), 0.1)  # its x is the base's y
        self.assert_force(self.command((2, 0, 0), frame="spidar_grip"), (2, 0, 0), 0.15)  # hardly turned at rest
        self.assert_force(self.command((0, 2, 0), frame="there_is_none"), (0, 0, 0), 0.1)
        self.assert_force(self.command((0, 2, 0), frame=""), (0, 0, 0), 0.1)

    def test_not_finite_is_refused(self):
        self.assert_force(self.command((0, float("nan"), 0)), (0, 0, 0), 0.1)

    def test_clamp(self):
        force = self.command((0, 50, 0))
        self.assertLess((force.x ** 2 + force.y ** 2 + force.z ** 2) ** 0.5, 10.5)

    def test_pose_only_after_calibration(self):
        pose = Probe("/spidar/pose", PoseStamped)
        pose.wait(10)
        rospy.wait_for_service("/spidar/driver/calibrate", 10)
        self.assertTrue(rospy.ServiceProxy("/spidar/driver/calibrate", Trigger)().success)

    def test_state_says_that_nobody_else_holds_it(self):
        message = self.state.wait(1)
        self.assertFalse(message.claimed)
        self.assertEqual(message.header.frame_id, "spidar_base")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "driver_alone", DriverAlone, sys.argv)
