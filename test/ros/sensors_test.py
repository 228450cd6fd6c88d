#!/usr/bin/env python3
"""Sensors as topics: each in its frame, all samples, with the values of what stands still; contacts with their details."""
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from haptic_msgs.msg import Contacts
from sensor_msgs.msg import Imu
from topic_probe import Probe

G = 9.8


class Sensors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("sensors_test")

    def test_a_merged_joint_in_its_childs_frame(self):
        wrist = Probe("/sensors/wrist", WrenchStamped).wait(50, timeout=40)
        self.assertEqual(wrist.header.frame_id, "tool")
        # It holds the tool: weight upwards, and its moment at 0.1 m along x.
        self.assertAlmostEqual(wrist.wrench.force.z, 0.25 * G, delta=1e-6)
        self.assertAlmostEqual(wrist.wrench.torque.y, -0.1 * 0.25 * G, delta=1e-6)

    def test_contact_of_a_pair(self):
        under = Probe("/sensors/under_cube", WrenchStamped).wait(1, timeout=40, accept=lambda m: abs(m.wrench.force.z - 0.1 * G) < 1e-4)
        self.assertEqual(under.header.frame_id, "cube")

    def test_inertial_unit(self):
        imu = Probe("/sensors/imu", Imu).wait(50, timeout=40)
        self.assertEqual(imu.header.frame_id, "imu")
        self.assertAlmostEqual(imu.linear_acceleration.z, G, delta=1e-6)
        self.assertAlmostEqual(imu.orientation.z, 0.5 ** 0.5, delta=1e-6)
        self.assertAlmostEqual(imu.angular_velocity_covariance[4], 1e-4, delta=1e-12)
        self.assertLess(abs(imu.angular_velocity.x), 0.1)  # ten deviations

    def test_every_sample_at_its_rate(self):
        every = Probe("/sensors/wrist", WrenchStamped, keep=20000, queue=5000)
        slow = Probe("/sensors/slow_wrist", WrenchStamped, queue=5000)
        slow.wait(150, timeout=60)
        stamps = [m.header.stamp.to_sec() for m in slow.messages][50:]
        every.wait(1, timeout=10, accept=lambda m: m.header.stamp.to_sec() >= stamps[-1])  # it has come as far, over its own connection
        between = [m for m in every.messages if stamps[0] <= m.header.stamp.to_sec() < stamps[-1]]
        # One sample a step, ten of them between two of 100 Hz. A queue that ran over while this machine was busy lacks some of both in a
        # row: nine of ten and the slow one between them leave eleven.
        counts = [sum(a <= m.header.stamp.to_sec() < b for m in between) for a, b in zip(stamps, stamps[1:])]
        self.assertGreater(counts.count(10), 0.8 * len(counts), counts)
        self.assertEqual(len({m.header.stamp for m in between}), len(between))

    def test_contacts_say_more(self):
        def stands(message):
            return [c for c in message.contacts if {c.link_a, c.link_b} == {"floor", "cube"}]

        contact = stands(Probe("/contacts", Contacts).wait(20, timeout=40, accept=stands))[0]
        self.assertTrue(contact.sticking)
        self.assertAlmostEqual(contact.centre_of_pressure.x, 0.5, delta=1e-6)
        self.assertLess(abs(contact.slip_velocity.x), 1e-6)
        xs = sorted(p.x for p in contact.polygon)
        self.assertAlmostEqual(xs[0], 0.45, delta=1e-6)
        self.assertAlmostEqual(xs[-1], 0.55, delta=1e-6)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "sensors", Sensors, sys.argv)
