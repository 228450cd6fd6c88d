#!/usr/bin/env python3
"""Faults of wire and boards, injected into the emulated boards while the loop runs: state, silence of the pose, no force."""
import os
import re
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from emulated_boards import EmulatedBoards
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from haptic_msgs.msg import DeviceState
from std_srvs.srv import SetBool, Trigger
from topic_probe import Probe, load_stack, unload_stack, wait_until

RATE = 500  # [Hz]; the boards are a process of their own
NO_FORCE = (DeviceState.FAULT, DeviceState.DISCONNECTED)


class WireFaults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("wire_faults_test")
        cls.boards = EmulatedBoards("spidar_g6x5r")
        cls.stack = load_stack("spidar_g6x5r", RATE, driver=cls.boards.driver_parameters())
        cls.state = Probe("/spidar/state", DeviceState)
        cls.pose = Probe("/spidar/pose", PoseStamped)

    @classmethod
    def tearDownClass(cls):
        unload_stack(cls.stack)
        cls.boards.close()

    def enable(self):
        """Until it is enabled: a busy machine may keep the boards' process from its core for longer than 20 ms."""
        for service in ("recover", "enable_force", "calibrate"):
            rospy.wait_for_service(f"/spidar/driver/{service}", 30)

        def enabled():  # a board that was without power has lost its lengths; the hand rests at home
            rospy.ServiceProxy("/spidar/driver/calibrate", Trigger)()
            rospy.ServiceProxy("/spidar/driver/recover", Trigger)()
            rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)(True)
            time.sleep(0.5)
            return self.state.messages and self.state.messages[-1].state == DeviceState.ENABLED
        wait_until("force", enabled, 30)
        self.state.clear()

    def test_a_dead_board_shows_no_pose(self):
        self.enable()
        self.boards.order("kill 1")
        self.state.wait(1, accept=lambda m: m.state in NO_FORCE)
        time.sleep(0.1)
        self.pose.clear()
        time.sleep(0.5)
        self.assertEqual(self.pose.messages, [], "a pose without counts")
        said = self.state.wait(1, accept=lambda m: m.wire)
        self.assertIn("board 1", said.wire)
        self.boards.order("revive 1")

    def test_a_deaf_board_ends_the_force_and_is_taught_anew(self):
        self.enable()
        self.boards.order("deaf 1")
        self.state.wait(1, accept=lambda m: m.state in NO_FORCE)
        self.state.wait(1, accept=lambda m: "obey" in m.wire)

    def test_a_slow_wire_is_measured_and_refused(self):
        self.enable()
        self.boards.order("latency 12")
        self.state.wait(1, timeout=20, accept=lambda m: m.state in NO_FORCE)
        slow = self.state.wait(1, timeout=20, accept=lambda m: m.wire_delay > 0.01)
        self.assertLess(slow.stable_stiffness, 1000)
        self.boards.order("latency 0")

    def test_a_constant_delay_is_measured_and_bearable(self):
        self.enable()
        self.boards.order("latency 2")
        self.addCleanup(self.boards.order, "latency 0")
        late = self.state.wait(1, timeout=20, accept=lambda m: m.wire_delay > 0.0019)
        self.assertGreater(late.stable_stiffness, 1000)
        self.enable()
        diagnosed = Probe("/diagnostics", DiagnosticArray)
        self.addCleanup(diagnosed.close)

        def measured(message):  # the wire's own part, by the marks: what a busy machine adds is not constant
            told = {v.key: v.value for s in message.status if s.name == "spidar: device" for v in s.values}
            return 1800 < float(told.get("wire delay measured [us]", 0)) < 4000
        diagnosed.wait(1, timeout=20, accept=measured)

    def test_a_delay_without_a_stable_wall_is_refused_with_the_number(self):
        self.enable()
        self.boards.order("latency 8")
        self.addCleanup(self.boards.order, "latency 0")
        self.state.wait(1, timeout=20, accept=lambda m: m.wire_delay > 0.007 and m.state in NO_FORCE)
        answers = []

        def refused():
            rospy.ServiceProxy("/spidar/driver/recover", Trigger)()
            answers.append(rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)(True))
            return not answers[-1].success and re.search(r"delay of \d+\.\d ms leaves walls", answers[-1].message)
        # A busy machine that keeps the boards' process waiting is a fault of its own, told in place of this one while it lasts.
        wait_until("a refusal with the number", refused, 80, lambda: [answer.message for answer in answers[-3:]])
        self.assertFalse(any(answer.success for answer in answers))

    def test_a_brown_out_is_told_and_the_board_taught_anew(self):
        self.enable()
        self.boards.order("reset 1")
        self.state.wait(1, accept=lambda m: m.state in NO_FORCE)
        said = self.state.wait(1, timeout=20, accept=lambda m: "taught anew" in m.wire and m.state == DeviceState.FAULT)
        self.assertRegex(said.wire, "board 1 (had lost its power|started anew)")
        self.assertIn("calibrate", said.message)
        self.enable()
        wait_until("current", lambda: self.boards.drive() == "on")

    def test_stamps_are_those_of_the_counts(self):
        self.enable()
        self.pose.clear()
        stamps = [m.header.stamp for _ in range(3) for m in [self.pose.wait(1)]]
        now = rospy.Time.now()
        self.assertTrue(all(stamp <= now for stamp in stamps))


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "wire_faults", WireFaults, sys.argv)
