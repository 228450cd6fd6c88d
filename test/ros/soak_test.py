#!/usr/bin/env python3
"""The whole stack for a minute (HAPTIC_SOAK_SECONDS: longer): it ticks on, and its memory does not grow."""
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from haptic_msgs.msg import Contacts, TickStatistics
from sensor_msgs.msg import JointState
from topic_probe import Probe, node_pid, threads_of
from visualization_msgs.msg import MarkerArray

SECONDS = float(os.environ.get("HAPTIC_SOAK_SECONDS", "60"))
WARM_UP = 12  # [s] the flight recorder's 5 s and roscpp's buffers fill
# Arenas of malloc grow in steps of 132 kB per thread when messages of another size come; a leak of one message of
# 1 kB per frame would be 1.8 MB per minute.
GROWTH_KB = 1024


def resident_kb(pid):
    with open(f"/proc/{pid}/status", encoding="utf-8") as status:
        return int(next(line for line in status if line.startswith("VmRSS")).split()[1])


class Soak(unittest.TestCase):
    def test_memory_is_constant(self):
        rospy.init_node("soak_test")
        statistics = Probe("/tick_statistics", TickStatistics, keep=20)
        watched = [Probe("/contacts", Contacts, keep=20), Probe("/markers", MarkerArray, keep=20),
                   Probe("/spidar/joint_states", JointState, keep=20)]
        first = statistics.wait(1, timeout=40)
        pid = node_pid("/haptics")
        time.sleep(WARM_UP)
        before, threads = resident_kb(pid), len(threads_of(pid))
        end = time.monotonic() + SECONDS - WARM_UP
        while time.monotonic() < end:
            time.sleep(1)
            statistics.clear()
            statistics.wait(1, timeout=30)
        self.assertLess(resident_kb(pid) - before, GROWTH_KB)
        self.assertLessEqual(len(threads_of(pid)), threads)
        statistics.wait(1, timeout=10 * SECONDS, accept=lambda m: m.simulated_time > first.simulated_time + 0.5 * SECONDS)
        self.assertTrue(all(probe.messages for probe in watched))


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "soak", Soak, sys.argv)
