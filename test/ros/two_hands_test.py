#!/usr/bin/env python3
"""Two devices in namespaces of their own hold one block; when one is lost, the other goes on as if nothing had been."""
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from haptic_msgs.msg import Contacts, DeviceState, TickStatistics
from topic_probe import Probe, load_nodelet, unload


class TwoHands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("two_hands_test")
        rospy.wait_for_service("/haptics/load_nodelet", 20)
        cls.loaders = {}
        for name in ("left", "right"):
            cls.loaders[name] = load_nodelet("spidar_driver/DriverNodelet", f"/{name}/driver", "/haptics",
                                             device="spidar_g6x3r", rate=1000, alone=False)
        cls.loaders["world"] = load_nodelet("penalty_sim/SimulationNodelet", "/simulation", "/haptics", scene="d_two_hands",
                                            rate=1000, alone=False)
        cls.loaders["bridge"] = load_nodelet("haptic_bridge/BridgeNodelet", "/bridge", "/haptics")

    @classmethod
    def tearDownClass(cls):
        for name in ("bridge", "world", "right", "left"):
            if name in cls.loaders:
                unload(cls.loaders[name])

    def test_both_hold_the_block_and_one_survives_the_other(self):
        statistics = Probe("/tick_statistics", TickStatistics)
        contacts = Probe("/contacts", Contacts)
        poses = {name: Probe(f"/{name}/pose", PoseStamped) for name in ("left", "right")}
        # Forces are on; on a busy machine missed ticks keep the fade below 1.
        both = statistics.wait(1, timeout=40, accept=lambda m: len(m.hands) == 2 and all(h.fade > 0.1 for h in m.hands))
        self.assertEqual([h.device for h in both.hands], ["left", "right"])
        self.assertEqual([h.pointer for h in both.hands], ["left_pointer", "right_pointer"])
        for name, probe in poses.items():
            self.assertEqual(probe.wait(10).header.frame_id, f"{name}_base")

        def held(message):
            pairs = [{c.link_a, c.link_b} for c in message.contacts]
            return {"held", "left_pointer"} in pairs and {"held", "right_pointer"} in pairs

        contacts.wait(3, timeout=40, accept=held)

        statistics.clear()  # before the loss: what it did to the other hand's force is over when it has been unloaded
        statistics.wait(2)
        self.assertEqual(unload(self.loaders.pop("left")), 0)
        poses["right"].clear()
        after = statistics.wait(10, timeout=20, accept=lambda m: len(m.hands) == 1)
        self.assertEqual([h.device for h in after.hands], ["right"])
        # The fade is of a tick up to 16 ticks older than the count of missed ones: that is looked for over two messages.
        messages = [m for m in statistics.messages if m.hands]
        for earlier, before, m in zip(messages, messages[1:], messages[2:]):
            self.assertTrue(m.hands[-1].fade >= before.hands[-1].fade or m.missed_ticks > earlier.missed_ticks,
                            "the other hand's force does not fade when one is lost; missed ticks alone may do that")
        self.assertGreater(after.ticks, both.ticks)
        poses["right"].wait(100)
        state = Probe("/right/state", DeviceState).wait(1)
        self.assertEqual(state.state, DeviceState.ENABLED)
        self.assertTrue(state.claimed)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "two_hands", TwoHands, sys.argv)
