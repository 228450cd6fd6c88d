#!/usr/bin/env python3
"""Where the device stands: the scene's word, until somebody places its base in tf; then the pointer glides there."""
import os
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
import tf2_ros
import yaml
from geometry_msgs.msg import TransformStamped
from haptic_msgs.msg import TickStatistics
from tf2_msgs.msg import TFMessage
from topic_probe import Probe, wait_until

MOVE = (0.02, -0.03, 0.06)   # up and aside: nothing is touched there [m]
GLIDE = 0.5                  # the bridge's soft start [s]
SILENCE = 3                  # longer than a tracker pauses [s]
FRAME = 1 / 30               # of the simulation's tf [s]


def place(parent, child, p):
    t = TransformStamped()
    t.header.stamp = rospy.Time.now()
    t.header.frame_id, t.child_frame_id = parent, child
    t.transform.translation.x, t.transform.translation.y, t.transform.translation.z = p
    t.transform.rotation.w = 1
    return t


def vector(t):
    return (t.transform.translation.x, t.transform.translation.y, t.transform.translation.z)


def distance(a, b):
    return sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5


class DeviceBase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("device_base_test")
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)

    def where(self, frame):
        return vector(self.buffer.lookup_transform("world", frame, rospy.Time(0), rospy.Duration(10)))

    def heard_by_a_newcomer(self):
        """Static frames as a process hears them that starts now: frame → where it is said to be, once per message."""
        for seconds in (4, 12, 36):  # a busy machine takes long to start it
            frames = self.heard_within(seconds)
            if {"spidar_base", "floor"} <= set(frames):
                break
        return frames

    @staticmethod
    def heard_within(seconds):
        echo = subprocess.run(["timeout", str(seconds), "rostopic", "echo", "/tf_static"], stdout=subprocess.PIPE, text=True, check=False)
        frames = {}
        for message in yaml.safe_load_all(echo.stdout):
            for t in (message or {}).get("transforms", []):
                p = t["transform"]["translation"]
                frames.setdefault(t["child_frame_id"], []).append((p["x"], p["y"], p["z"]))
        return frames

    def test_it_is_followed(self):
        statistics = Probe("/tick_statistics", TickStatistics)
        statistics.wait(1, timeout=40, accept=lambda m: m.hands and m.hands[0].fade > 0.1)
        scene = self.where("spidar_base")
        self.assertEqual({"spidar_base", "floor"}, set(self.heard_by_a_newcomer()))
        wait_until("the pointer is at the grip", lambda: distance(self.where("pointer"), self.where("spidar_grip")) < 2e-3)

        moving = Probe("/tf", TFMessage)
        before = statistics.wait(1)
        statistics.clear()
        broadcaster = tf2_ros.StaticTransformBroadcaster()
        moved = tuple(a + b for a, b in zip(scene, MOVE))
        broadcaster.sendTransform([place("world", "spidar_base", moved)])
        wait_until("the pointer has followed", lambda: distance(self.where("pointer"), moved) < 0.03)
        time.sleep(GLIDE)
        self.assertLess(distance(self.where("spidar_base"), moved), 1e-9)
        self.assertLess(distance(self.where("pointer"), self.where("spidar_grip")), 2e-3)
        heard = list(statistics.messages)

        path = [(t.header.stamp.to_sec(), vector(t)) for m in moving.messages for t in m.transforms
                if t.child_frame_id == "pointer"]
        steps = [(t1 - t0, distance(a, b)) for (t0, a), (t1, b) in zip(path, path[1:])]
        fastest = 15 / 8 * distance(MOVE, (0, 0, 0)) / GLIDE  # of a glide with minimum jerk [m/s]
        self.assertTrue(all(d <= fastest * (dt + FRAME) for dt, d in steps), f"a jump of {max(d for _, d in steps)} m")
        for m in heard:  # each by its own counters: a tick that the machine loses fades the force, and rightly
            if (m.missed_ticks, m.dropped_records) == (before.missed_ticks, before.dropped_records):
                self.assertGreaterEqual(m.hands[0].fade, before.hands[0].fade,
                                        f"the force goes on: flags {m.hands[0].flags:#x}, latest {m.lateness_us_max} us")

        places = self.heard_by_a_newcomer()["spidar_base"]
        self.assertEqual(len(places), 1, "one publisher of a frame")
        self.assertLess(distance(places[0], moved), 1e-9)

        # On a cart that is pushed about, by way of another frame.
        for i in range(30):
            broadcaster.sendTransform([place("world", "cart", (0.001 * i, 0, 0)), place("cart", "spidar_base", moved)])
            time.sleep(0.03)
        end = (moved[0] + 0.029, moved[1], moved[2])
        wait_until("the pointer is with the cart", lambda: distance(self.where("spidar_base"), end) < 1e-9)
        time.sleep(2 * GLIDE)
        self.assertLess(distance(self.where("pointer"), self.where("spidar_grip")), 2e-3)

        # Its tracker dies: the base stays where it was told last, and the force goes on; a new tracker is followed.
        tracker = tf2_ros.TransformBroadcaster()

        def track(x):
            for _ in range(10):
                tracker.sendTransform(place("world", "tracked", (x, 0, 0)))
                time.sleep(0.03)

        broadcaster.sendTransform([place("tracked", "spidar_base", moved)])
        last = (moved[0] + 0.01, moved[1], moved[2])

        def followed():  # it goes on until the bridge, too, has heard of it
            track(0.01)
            return (distance(self.where("spidar_base"), last) < 1e-9 and
                    distance(self.where("pointer"), self.where("spidar_grip")) < 2e-3)

        wait_until("the tracker is followed", followed)
        time.sleep(2 * GLIDE)
        statistics.clear()
        time.sleep(SILENCE)
        self.assertLess(distance(self.where("pointer"), self.where("spidar_grip")), 2e-3)
        self.assertLess(distance(self.where("spidar_grip"), last), 0.03)
        silent = statistics.wait(5)
        self.assertGreater(silent.hands[0].fade, 0)
        track(0.025)
        wait_until("the tracker is followed again",
                   lambda: distance(self.where("pointer"), (moved[0] + 0.025, moved[1], moved[2])) < 0.03)

        # On a body of the scene.
        cube = self.where("cube")
        broadcaster.sendTransform([place("cube", "spidar_base", tuple(a - b + 0.01 for a, b in zip(end, cube)))])
        wait_until("the base is on the cube", lambda: self.where("spidar_base")[2] > end[2] + 5e-3)
        time.sleep(2 * GLIDE)
        self.assertLess(distance(self.where("pointer"), self.where("spidar_grip")), 2e-3)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "device_base", DeviceBase, sys.argv)
