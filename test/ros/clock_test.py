#!/usr/bin/env python3
"""/use_sim_time without a clock, a clock that stands still and one that jumps back: a clear message, and the loop, which
runs by the steady clock, does not notice."""
import os
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from haptic_msgs.msg import TickStatistics
from rosgraph_msgs.msg import Clock, Log
from topic_probe import Probe, load_nodelet, unload, wait_until


class SimulatedClock(unittest.TestCase):
    def test_the_loop_goes_on(self):
        rospy.init_node("clock_test")
        log = Probe("/rosout", Log)
        statistics = Probe("/tick_statistics", TickStatistics)
        wrench = Probe("/spidar/wrench", WrenchStamped)
        diagnostics = Probe("/diagnostics", DiagnosticArray)
        clock = rospy.Publisher("/clock", Clock, queue_size=1)
        wait_until("the log is heard", lambda: log._subscriber.get_num_connections() > 0, 30)
        rospy.wait_for_service("/haptics/load_nodelet", 30)
        loader = load_nodelet("haptic_bridge/BridgeNodelet", "/bridge", "/haptics")
        self.addCleanup(unload, loader)

        def told(words):
            log.wait(1, timeout=20, accept=lambda m: words in m.msg)

        def ticks_go_on():
            before = statistics.wait(1, timeout=30)
            statistics.clear()
            after = statistics.wait(5, timeout=20)
            self.assertGreater(after.ticks, before.ticks)
            self.assertGreater(after.simulated_time, before.simulated_time)

        ticks_go_on()
        told("no clock arrives")
        diagnostics.wait(2, timeout=20, accept=lambda m: any("no clock arrives" in s.message for s in m.status))
        for second in (100, 101, 50):
            end = time.monotonic() + 0.5
            while time.monotonic() < end:
                clock.publish(Clock(clock=rospy.Time(second)))
                time.sleep(0.05)
            ticks_go_on()
        told("jumped back")
        diagnostics.clear()
        end = time.monotonic() + 2.5
        while time.monotonic() < end:
            clock.publish(Clock(clock=rospy.Time(60 + time.monotonic() - end)))
            time.sleep(0.05)
        self.assertNotIn("no clock", [s.message for m in diagnostics.messages for s in m.status if "loop" in s.name][-1])
        self.assertTrue(all(abs(m.wrench.force.z) <= 10.5 for m in wrench.messages), "force stays within the limits")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "clock", SimulatedClock, sys.argv)
