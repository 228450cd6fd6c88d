#!/usr/bin/env python3
"""The simulation as a node: a pose from a topic moves the pointer, and a wrench comes back."""
import math
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, WrenchStamped
from haptic_msgs.msg import StepReport
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from topic_probe import Probe
from visualization_msgs.msg import MarkerArray

# touch_cube: the pointer (r 5 mm) starts at z = 43 mm, the cube's top is at 30 mm.
HOME_HEIGHT, TOP, RADIUS = 0.043, 0.030, 0.005


class SimulationAlone(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("simulation_alone_test")
        cls.publisher = rospy.Publisher("/spidar/pose", PoseStamped, queue_size=1, tcp_nodelay=True)
        cls.wrench = Probe("/spidar/wrench_command", WrenchStamped)
        Probe("/step_report", StepReport).wait(1)

    def press(self, depth, frame, z0, seconds):
        """Moves the pointer down to `depth` [m] below the cube's top and stays there."""
        bottom = TOP + RADIUS - depth - z0
        start = HOME_HEIGHT - z0
        begin = time.monotonic()
        while (t := time.monotonic() - begin) < seconds:
            share = 0.5 - 0.5 * math.cos(math.pi * min(1.0, 2 * t / seconds))
            position = Point(0, 0, start + share * (bottom - start))
            self.publisher.publish(Header(stamp=rospy.Time.now(), frame_id=frame),
                                   Pose(position, Quaternion(0, 0, 0, 1)))
            time.sleep(0.002)

    def test_grip_pose_gives_a_wrench_in_the_base(self):
        self.wrench.clear()
        self.press(0.0005, "spidar_base", HOME_HEIGHT, 2.0)
        message = self.wrench.messages[-1]
        self.assertEqual(message.header.frame_id, "spidar_base")
        self.assertGreater(message.wrench.force.z, 0.05)
        self.wrench.clear()
        time.sleep(0.5)  # no poses, no wrench: nothing keeps a hand pressed by a hung sender
        self.wrench.clear()
        time.sleep(0.3)
        self.assertEqual(len(self.wrench.messages), 0)

    def test_pointer_pose_in_the_world_gives_a_wrench_in_the_world(self):
        self.wrench.clear()
        self.press(0.0005, "world", 0.0, 2.0)
        message = self.wrench.messages[-1]
        self.assertEqual(message.header.frame_id, "world")
        self.assertGreater(message.wrench.force.z, 0.05)

    def test_what_stands_is_dimmed_and_counted(self):
        def shade(markers, far):
            """How far the cube's colour in `markers` is from a grey, where it comes."""
            colours = [m.color for array in markers.messages for m in array.markers if m.ns == "bodies" and m.header.frame_id == "cube"]
            spread = [max(c.r, c.g, c.b) - min(c.r, c.g, c.b) for c in colours]
            return max(spread) if far else min(spread)

        markers, reports = Probe("/markers", MarkerArray), Probe("/step_report", StepReport)
        self.press(-0.01, "world", 0.0, 1.0)  # 10 mm above it
        reports.wait(1, 20, lambda m: m.standing == 1)
        time.sleep(0.3)
        dimmed = shade(markers, False)
        self.press(0.0005, "world", 0.0, 1.0)
        reports.clear()
        reports.wait(1, 20, lambda m: m.standing == 0)
        time.sleep(0.3)
        self.assertAlmostEqual(dimmed, 0.4 * shade(markers, True), places=6)
        for probe in (markers, reports):
            probe.close()

    def test_links_are_in_tf(self):
        def has_cube(message):
            return any(t.child_frame_id == "cube" and t.header.frame_id == "world" for t in message.transforms)
        Probe("/tf", TFMessage).wait(3, accept=has_cube)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "simulation_alone", SimulationAlone, sys.argv)
