#!/usr/bin/env python3
"""A robot's joints over topics: joint_states come out, ~joint_command moves them, what cannot be obeyed is ignored."""
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from sensor_msgs.msg import JointState
from topic_probe import Probe


class Joints(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("joints_test")
        cls.states = Probe("/joint_states", JointState)
        cls.command = rospy.Publisher("/simulation/joint_command", JointState, queue_size=1)
        cls.states.wait(5)
        deadline = time.monotonic() + 10
        while cls.command.get_num_connections() == 0 and time.monotonic() < deadline:
            time.sleep(0.05)

    def last(self):
        return self.states.messages[-1]

    def tell(self, seconds=1.5, **numbers):
        self.command.publish(JointState(name=["hinge"], **numbers))
        time.sleep(seconds)

    def test_states_come_at_their_rate(self):
        self.states.clear()
        time.sleep(2)
        self.assertGreater(len(self.states.messages), 100)  # 100 Hz for two seconds, on a busy machine
        self.assertEqual(self.last().name, ["hinge"])

    def test_positions_and_velocities_are_obeyed(self):
        self.tell(position=[0.5])
        self.assertAlmostEqual(self.last().position[0], 0.5, delta=1e-3)
        self.tell(0.6, velocity=[-0.3])
        self.assertAlmostEqual(self.last().velocity[0], -0.3, delta=1e-2)
        self.tell(position=[0.0])
        self.assertAlmostEqual(self.last().position[0], 0.0, delta=1e-3)

    def test_what_cannot_be_obeyed_is_ignored(self):
        self.tell(position=[0.2])
        self.tell(0.5, position=[float("nan")])
        self.tell(0.5, position=[0.9], velocity=[1.0, 2.0])
        self.command.publish(JointState(name=["hinge", "no_such_joint"], position=[0.9, 0.9]))
        time.sleep(1)
        self.assertAlmostEqual(self.last().position[0], 0.2, delta=1e-3)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "joints", Joints, sys.argv)
