#!/usr/bin/env python3
"""Faults of wire and boards, injected into the emulated boards while the loop runs: state, silence of the pose, no force."""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospkg
import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from haptic_msgs.msg import DeviceState
from std_srvs.srv import SetBool, Trigger
from topic_probe import Probe, load_stack, program, unload_stack, wait_until

RATE = 500  # [Hz]; the boards are a process of their own
NO_FORCE = (DeviceState.FAULT, DeviceState.DISCONNECTED)


class WireFaults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("wire_faults_test")
        cls.folder = tempfile.mkdtemp()
        cls.port, cls.control = os.path.join(cls.folder, "boards"), os.path.join(cls.folder, "control")
        device = os.path.join(rospkg.RosPack().get_path("haptic_description"), "devices", "spidar_g6x5r.yaml")
        cls.boards = subprocess.Popen([program("spidar_driver", "spidar_board_emulator"), "--device", device, "--link", cls.port,
                                       "--control", cls.control, "--hand", "rest"], stdout=subprocess.DEVNULL)
        wait_until("the boards' port", lambda: os.path.exists(cls.port) and os.path.exists(cls.control))
        cls.stack = load_stack("spidar_g6x5r", RATE, driver={"transport": "file", "port": cls.port, "calibrate_at_start": True,
                                                             "enable_force_at_start": True})
        cls.state = Probe("/spidar/state", DeviceState)
        cls.pose = Probe("/spidar/pose", PoseStamped)

    @classmethod
    def tearDownClass(cls):
        unload_stack(cls.stack)
        cls.boards.send_signal(signal.SIGINT)
        cls.boards.wait(10)
        shutil.rmtree(cls.folder)

    def order(self, text):
        with open(self.control, "w", encoding="utf-8") as control:
            control.write(text + "\n")

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
        self.order("kill 1")
        self.state.wait(1, accept=lambda m: m.state in NO_FORCE)
        time.sleep(0.1)
        self.pose.clear()
        time.sleep(0.5)
        self.assertEqual(self.pose.messages, [], "a pose without counts")
        said = self.state.wait(1, accept=lambda m: m.wire)
        self.assertIn("board 1", said.wire)
        self.order("revive 1")

    def test_a_deaf_board_ends_the_force_and_is_taught_anew(self):
        self.enable()
        self.order("deaf 1")
        self.state.wait(1, accept=lambda m: m.state in NO_FORCE)
        self.state.wait(1, accept=lambda m: "obey" in m.wire)

    def test_a_slow_wire_is_measured_and_refused(self):
        self.enable()
        self.order("latency 12")
        self.state.wait(1, timeout=20, accept=lambda m: m.state in NO_FORCE)
        slow = self.state.wait(1, timeout=20, accept=lambda m: m.wire_delay > 0.01)
        self.assertLess(slow.stable_stiffness, 1000)
        self.order("latency 0")

    def test_stamps_are_those_of_the_counts(self):
        self.enable()
        self.pose.clear()
        stamps = [m.header.stamp for _ in range(3) for m in [self.pose.wait(1)]]
        now = rospy.Time.now()
        self.assertTrue(all(stamp <= now for stamp in stamps))


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "wire_faults", WireFaults, sys.argv)
