#!/usr/bin/env python3
"""Bodies and a device's base that others lead, when stamps and the system's clock go back, and when a frame falls silent and comes back
elsewhere. HAPTIC_FIGURES: a file for the figure clock_back.follows."""
import os
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PoseStamped, TransformStamped
from haptic_msgs.msg import TickStatistics
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage
from topic_probe import NODELET, Probe, load_stack, program, unload_stack, wait_until

SCENE = os.path.join(os.path.dirname(os.path.realpath(__file__)), "set_clock.urdf")
SPEED, PERIOD = 0.05, 0.02     # of tray and lift [m/s], of their poses [s]
HOUR = 3600
WITHIN = 0.1                   # [s] in which all follow
SEEN = 0.05                    # [s] between two pictures of the simulation, and their way here
STALLED = 0.5                  # [s] within which a silence is said
FASTEST = 0.5 * 25 / 16 + 2 * SPEED  # [m/s] of a body that approaches (led_motion.h) what moves itself
BUSY = float(os.environ.get("HAPTIC_CLOCK_SLACK", "0.4"))  # [s] by which a busy machine may be late


class Sender(threading.Thread):
    """Leads tray and lift along x at SPEED; its stamps are `ahead` of the time of day."""

    def __init__(self):
        super().__init__(daemon=True)
        self.ahead, self.silent, self.jump, self.ends = 0.0, False, 0.0, False
        self.begin = time.monotonic()
        self.frames, self.lift = tf2_ros.TransformBroadcaster(), rospy.Publisher("/lift_pose", PoseStamped, queue_size=1)

    def place(self, when):
        return SPEED * (when - self.begin)

    def stamp(self):
        return rospy.Time.from_sec(time.time() + self.ahead)

    def run(self):
        while not self.ends:
            x = self.place(time.monotonic())
            if not self.silent:
                self.frames.sendTransform(frame_at("tray_frame", x + self.jump, self.stamp()))
            pose = PoseStamped()
            pose.header.stamp, pose.header.frame_id = self.stamp(), "world"
            pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = x, 2, 1
            self.lift.publish(pose)
            time.sleep(PERIOD)


def frame_at(child, x, stamp, y=1.0):
    t = TransformStamped()
    t.header.stamp, t.header.frame_id, t.child_frame_id = stamp, "world", child
    t.transform.translation.x, t.transform.translation.y, t.transform.rotation.w = x, y, 1
    return t


class Places:
    """x of the links that the simulation tells, with the steady time of arrival and the stamp."""

    def __init__(self):
        self.seen = {}
        self.subscriber = rospy.Subscriber("/tf", TFMessage, self.take, queue_size=100, tcp_nodelay=True)

    def take(self, message):
        now = time.monotonic()
        for t in message.transforms:
            self.seen.setdefault(t.child_frame_id, []).append((now, t.header.stamp.to_sec(), t.transform.translation.x))

    def x(self, link):
        return self.seen[link][-1][2] if link in self.seen else float("nan")


class SetClock(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("set_clock_test")

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.clock = os.path.join(self.folder.name, "ahead")
        self.set_clock(0)
        environment = dict(os.environ, LD_PRELOAD=program("haptic_tests", "set_clock.so"), HAPTIC_SET_CLOCK=self.clock)
        self.manager = subprocess.Popen([NODELET, "manager", "__name:=haptics"], env=environment)
        self.addCleanup(self.end_manager)
        self.places, self.log = Places(), Probe("/rosout", Log)
        self.sender = Sender()
        statistics = Probe("/tick_statistics", TickStatistics)
        self.stack = load_stack(scene=SCENE)
        self.addCleanup(unload_stack, self.stack)
        statistics.wait(1, timeout=60, accept=lambda m: m.hands and m.hands[0].fade > 0.1)
        statistics.close()
        self.sender.start()
        self.addCleanup(setattr, self.sender, "ends", True)
        wait_until("tray and lift are with their senders", lambda: all(abs(self.lag(link)) < 0.1 for link in ("tray", "lift")))

    def end_manager(self):
        self.manager.terminate()
        try:
            self.manager.wait(20)
        except subprocess.TimeoutExpired:
            self.manager.kill()
            self.manager.wait(20)

    def set_clock(self, seconds):
        with open(self.clock, "r+b" if os.path.exists(self.clock) else "wb") as file:
            file.write(struct.pack("d", seconds))

    def lag(self, link):
        """How long ago the sender was where the link was seen last [s]."""
        if link not in self.places.seen:
            return float("inf")
        when, _, x = self.places.seen[link][-1]
        return (self.sender.place(when) - x) / SPEED

    def lags(self, seconds):
        """The greatest lag of tray and lift from WITHIN on until `seconds` are over."""
        begin = time.monotonic()
        time.sleep(seconds)
        return max((self.sender.place(when) - x) / SPEED for link in ("tray", "lift") for when, _, x in self.places.seen[link]
                   if when > begin + WITHIN + SEEN)

    def arrivals(self, static, x):
        """Seconds until shelf and pointer are within 2 mm of where static frames put them."""
        static.sendTransform([frame_at("shelf_frame", x, self.sender.stamp(), -1.0), frame_at("spidar_base", x, self.sender.stamp(), 0.0)])
        begin, arrived = time.monotonic(), {}
        places = {"shelf": lambda: x, "pointer": lambda: x + self.places.x("spidar_grip")}

        def all_there():
            for link, place in places.items():
                if link not in arrived and abs(self.places.x(link) - place()) < 2e-3:
                    arrived[link] = time.monotonic() - begin
            return len(arrived) == len(places)

        wait_until("shelf and pointer are where static frames put them", all_there, seen=lambda: f"arrived: {arrived}")
        return arrived

    def test_clocks_that_go_back_are_followed(self):
        static = tf2_ros.StaticTransformBroadcaster()
        steady = self.lags(1)
        for x in (0.01, 0.02):
            before = self.arrivals(static, x)
        followed = []
        for stamps, system in ((-3, 0), (-HOUR, 0), (0, 0), (-HOUR, -HOUR), (-2 * HOUR, -2 * HOUR), (0, 0)):
            x += 0.01
            self.sender.ahead = stamps
            self.set_clock(system)
            lag, after = self.lags(1), self.arrivals(static, x)
            late = [lag - max(steady, 0), after["shelf"] - before["shelf"], after["pointer"] - before["pointer"]]
            followed.append(max(late))
            print(f"# stamps {stamps} s, clock {system} s: later by " + " ".join(f"{t:.3f}" for t in late) + " s (tf and topic, static, base)")
        if "HAPTIC_FIGURES" in os.environ:
            with open(os.environ["HAPTIC_FIGURES"], "a", encoding="utf-8") as figures:
                figures.write(f"figure clock_back.late_s_max {max(followed):.3g} s\n"
                              f"figure clock_back.follows {int(max(followed) <= WITHIN)} 1\n")
        self.assertLess(max(followed), WITHIN + BUSY)

    def test_a_silent_frame_is_said_and_comes_back_without_a_jump(self):
        self.log.clear()
        self.sender.silent = True
        silent = time.monotonic()
        self.log.wait(1, accept=lambda m: "tray_frame has been silent" in m.msg)
        self.assertLess(time.monotonic() - silent, STALLED + BUSY)
        time.sleep(3 - (time.monotonic() - silent))
        self.sender.jump = 0.15
        self.places.seen.clear()
        self.sender.silent = False
        wait_until("the tray is with its frame again", lambda: abs(self.sender.place(time.monotonic()) + 0.15 - self.places.x("tray")) < 0.01)
        self.log.wait(1, accept=lambda m: "tray" in m.msg and "told again" in m.msg)
        path = [(stamp, x) for _, stamp, x in self.places.seen["tray"]]
        fastest = max((b - a) / (t - s) for (s, a), (t, b) in zip(path, path[1:]) if t > s)
        self.assertLess(fastest, FASTEST)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "set_clock", SetClock, sys.argv)
