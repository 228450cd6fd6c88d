#!/usr/bin/env python3
"""The driver as a node: wrench commands by topic, their frames, their end, and what is refused.

A busy machine may keep a command for longer than the driver lets it live (30 ms): a force that is asked for is there at some
time, one that is refused at none.
"""
import contextlib
import os
import sys
import threading
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from geometry_msgs.msg import PoseStamped, Vector3, Wrench, WrenchStamped
from haptic_msgs.msg import DeviceState
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from topic_probe import Probe, wait_until

LIMIT = 30                     # [s] for anything to happen
AGE_LIMIT, DECAY = 0.03, 0.02  # [s] of the driver: then the wrench is gone
SLACK = 0.35                   # [s] that the last command may be on its way to the driver on a busy machine


def norm(force):
    return (force.x ** 2 + force.y ** 2 + force.z ** 2) ** 0.5


class DriverAlone(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("driver_alone_test")
        cls.state = Probe("/spidar/state", DeviceState)
        cls.wrench = Probe("/spidar/wrench", WrenchStamped)
        cls.publisher = rospy.Publisher("/spidar/wrench_command", WrenchStamped, queue_size=1, tcp_nodelay=True)
        cls.state.wait(1, accept=lambda m: m.state == DeviceState.ENABLED)
        cls.wrench.wait(10)

    def setUp(self):
        self.assert_presented((0, 1, 0), (0, 1, 0), 0.1)  # enabled, past its ramp, and it listens

    @contextlib.contextmanager
    def commands(self, force, frame):
        """Asks for a force all the time; gives a function that says how often it did."""
        done, sent = threading.Event(), []

        def ask():
            while not done.wait(0.005):
                self.publisher.publish(Header(stamp=rospy.Time.now(), frame_id=frame), Wrench(force=Vector3(*force)))
                sent.append(force)
        thread = threading.Thread(target=ask)
        thread.start()
        try:
            yield lambda: len(sent)
        finally:
            done.set()
            thread.join()

    def wait_for_force(self, expected, tolerance):
        def is_there(message):
            force = message.wrench.force
            return all(abs(getattr(force, axis) - value) <= tolerance for axis, value in zip("xyz", expected))
        self.wrench.clear()
        self.wrench.wait(timeout=LIMIT, accept=is_there)

    def assert_presented(self, force, expected, tolerance, frame="spidar_base"):
        self.wait_for_force((0, 0, 0), 0.1)
        with self.commands(force, frame):
            self.wait_for_force(expected, tolerance)

    def assert_refused(self, force, frame="spidar_base"):
        self.wait_for_force((0, 0, 0), 0.1)
        self.wrench.clear()
        with self.commands(force, frame) as sent:
            wait_until("100 commands are sent", lambda: sent() >= 100, LIMIT)
            self.wrench.wait(count=20, timeout=LIMIT)
        for message in self.wrench.messages:
            self.assertLess(norm(message.wrench.force), 0.2)

    def test_command_is_presented_and_ends_with_its_sender(self):
        self.assert_presented((0, 2, 0), (0, 2, 0), 0.1)  # λ of the device file: 3 %
        gone = rospy.Time.now() + rospy.Duration(AGE_LIMIT + DECAY + SLACK)  # by the driver's stamps, however late they come
        self.wrench.clear()
        self.wrench.wait(count=20, timeout=LIMIT, accept=lambda m: m.header.stamp > gone)
        for message in self.wrench.messages:
            if message.header.stamp > gone:
                self.assertLess(norm(message.wrench.force), 0.2)

    def test_frames(self):
        self.assert_presented((2, 0, 0), (0, 2, 0), 0.1, frame="turned")  # its x is the base's y
        self.assert_presented((2, 0, 0), (2, 0, 0), 0.15, frame="spidar_grip")  # hardly turned at rest
        self.assert_refused((0, 2, 0), frame="there_is_none")
        self.assert_refused((0, 2, 0), frame="")

    def test_not_finite_is_refused(self):
        self.assert_refused((0, float("nan"), 2))

    def test_clamp(self):
        self.wrench.clear()
        with self.commands((0, 50, 0), "spidar_base"):
            self.wrench.wait(count=20, timeout=LIMIT, accept=lambda m: norm(m.wrench.force) > 5)
        for message in self.wrench.messages:
            self.assertLess(norm(message.wrench.force), 10.5)

    def test_pose_only_after_calibration(self):
        pose = Probe("/spidar/pose", PoseStamped)
        pose.wait(10)
        rospy.wait_for_service("/spidar/driver/calibrate", 30)
        self.wait_for_force((0, 0, 0), 0.1)  # under force a calibration is refused: the grip may be pushed from its place
        answer = rospy.ServiceProxy("/spidar/driver/calibrate", Trigger)()
        self.assertTrue(answer.success, answer.message)

    def test_state_says_that_nobody_else_holds_it(self):
        message = self.state.wait(1)
        self.assertFalse(message.claimed)
        self.assertEqual(message.header.frame_id, "spidar_base")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "driver_alone", DriverAlone, sys.argv)
