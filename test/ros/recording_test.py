#!/usr/bin/env python3
"""Everything a user can do to a running loop is in its recording: the replay gives the same bits."""
import os
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import dynamic_reconfigure.client
import rosbag
import rospy
import rostest
from haptic_msgs.msg import TickStatistics
from haptic_msgs.srv import Clutch, Grab
from rosgraph_msgs.msg import Log
from std_srvs.srv import SetBool, Trigger
from topic_probe import Probe, load_stack, program, recorded, replay, unload_stack, wait_until


class Recording(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("recording_test")
        cls.folder = tempfile.mkdtemp()
        cls.bag = os.path.join(cls.folder, "session.bag")
        with recorded(cls.bag):
            stack = load_stack(bridge={"record": True})
            cls.use_everything()
            unload_stack(stack)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @classmethod
    def use_everything(cls):
        statistics = Probe("/tick_statistics", TickStatistics)
        # A clutch is refused in contact, and the scene's hand comes down soon.
        statistics.wait(1, timeout=40, accept=lambda m: m.hands and not m.hands[0].in_contact)

        def call(name, kind, **values):
            rospy.wait_for_service(name, 30)
            return rospy.ServiceProxy(name, kind)(**values)

        def some_ticks():
            statistics.clear()
            statistics.wait(4, timeout=20)

        cls.answers = {}
        cls.answers["clutch"] = call("/bridge/clutch", Clutch, device="spidar", hold=True)
        some_ticks()
        call("/bridge/clutch", Clutch, device="", hold=False)
        cls.answers["no hand"] = call("/bridge/clutch", Clutch, device="nobody", hold=True)
        some_ticks()
        cls.answers["grab"] = call("/simulation/grab", Grab, device="spidar", link="cube")
        some_ticks()
        cls.answers["grab back"] = call("/simulation/grab", Grab, device="", link="")
        cls.answers["grab floor"] = call("/simulation/grab", Grab, device="", link="floor")
        some_ticks()
        call("/simulation/reset", Trigger)
        some_ticks()
        call("/simulation/pause", SetBool, data=True)
        some_ticks()
        call("/simulation/pause", SetBool, data=False)
        call("/spidar/driver/enable_force", SetBool, data=False)
        some_ticks()
        call("/spidar/driver/enable_force", SetBool, data=True)
        client = dynamic_reconfigure.client.Client("/bridge", timeout=30)
        cls.changed = client.update_configuration({"stiffness_scale": 0.5, "friction_scale": 0.8, "limit_share": 0.7,
                                                   "passivity": 2, "force_scale": 0.9})
        some_ticks()
        cls.coupled = client.update_configuration({"coupling": 2})
        some_ticks()
        rosout = Probe("/rosout", Log)

        def refuses(message):
            return "parameters refused" in message.msg

        def refused_and_heard():  # a line said before the probe is connected is lost
            cls.refused = client.update_configuration({"coupling_stiffness": 1e5})
            return any(map(refuses, rosout.messages))

        wait_until("a refusal is said", refused_and_heard)
        cls.bounded = [client.update_configuration({name: value}) for name, value in (
            ("friction_scale", 1e9), ("stiffness_scale", 1e308), ("stiffness_scale", 1e-308), ("passivity", 3),
            ("force_scale", float("nan")))]
        rosout.wait(5, accept=lambda m: refuses(m) and ("_scale" in m.msg or "passivity" in m.msg))
        cls.said = [m.msg for m in rosout.messages if refuses(m)]
        client.close()
        some_ticks()

    def test_answers(self):
        self.assertTrue(self.answers["clutch"].success, self.answers["clutch"].message)
        self.assertFalse(self.answers["no hand"].success)
        self.assertIn("spidar", self.answers["no hand"].message)
        self.assertTrue(self.answers["grab"].success, self.answers["grab"].message)
        self.assertTrue(self.answers["grab back"].success, self.answers["grab back"].message)
        self.assertFalse(self.answers["grab floor"].success)

    def test_parameters(self):
        self.assertEqual(self.changed["stiffness_scale"], 0.5)
        self.assertEqual(self.changed["passivity"], 2)
        self.assertEqual(self.coupled["coupling"], 2)
        self.assertEqual(self.refused["coupling_stiffness"], -1, "the pointer and step cannot bear 1e5 N/m")
        for bounded in self.bounded:
            for name, value in (("friction_scale", 0.8), ("stiffness_scale", 0.5), ("passivity", 2), ("force_scale", 0.9)):
                self.assertEqual(bounded[name], value, "a value out of bounds changes nothing")
        for words in (("friction_scale", "is 1e+09", "give 0 to 3"), ("stiffness_scale", "is 1e+308", "0.01 to 10"),
                      ("stiffness_scale", "is 1e-308"), ("passivity", "is 3", "0 to 2"), ("force_scale", "is nan")):
            self.assertTrue(any(all(word in line for word in words) for line in self.said), (words, self.said))

    def test_replay(self):
        with rosbag.Bag(self.bag) as bag:
            kinds = {m.kind for _, m, _ in bag.read_messages("/recorded/events")}
            sessions = [m for _, m, _ in bag.read_messages("/recorded/session")]
        self.assertEqual(len(sessions), 1)
        self.assertTrue({0, 1, 3, 5, 12} <= kinds, f"events of kinds {kinds}")
        figures = replay(self.bag)
        self.assertGreater(figures["replay.steps"], 2000)
        self.assertEqual(figures["replay.mismatches"], 0)


    def test_damaged_bags_are_refused_in_one_line(self):
        """As `./run bench faults` damages them: the library of bags ends in signals at some."""
        with open(self.bag, "rb") as file:
            sound = file.read()
        choose, path = random.Random(3), os.path.join(self.folder, "damaged.bag")
        for i in range(15):
            damaged = bytearray(sound)
            for _ in range(30):
                bit = choose.randrange(8 * len(sound))
                damaged[bit // 8] ^= 1 << bit % 8
            with open(path, "wb") as file:
                file.write(damaged)
            done = subprocess.run([program("penalty_sim", "haptic_replay"), path], capture_output=True, check=False)
            said = (done.stdout + done.stderr).decode(errors="replace")
            if done.returncode == 2:
                self.assertEqual(len(said.splitlines()), 1, said)
                self.assertTrue(said.startswith("replay: "), said)
            else:  # within a message: its ticks come out otherwise, or nobody reads what was altered
                self.assertEqual(done.returncode, int("first difference" in said), f"bag {i}: {said}")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "recording", Recording, sys.argv)
