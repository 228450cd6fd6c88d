#!/usr/bin/env python3
"""Each process of a stack that runs over topics is killed: nothing hangs, and the force is gone within the age limit."""
import os
import random
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from haptic_msgs.msg import Contacts, DeviceState
from topic_probe import Probe, program

AGE_LIMIT, DECAY = 0.03, 0.02  # [s] of the driver
SLACK = 0.35                   # [s] that the last command may be on its way to the driver on a busy machine
ROUNDS = int(os.environ.get("HAPTIC_KILL_ROUNDS", "4"))


def norm(v):
    return (v.x ** 2 + v.y ** 2 + v.z ** 2) ** 0.5


class Killed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("killed_test")
        cls.processes = {}

    @classmethod
    def tearDownClass(cls):
        for process in cls.processes.values():
            process.send_signal(signal.SIGINT)
        for process in cls.processes.values():
            process.wait(10)

    def start(self, name):
        if name == "driver":
            command = [program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar",
                       "_device:=spidar_g6x3r", "_script:=press"]
        else:
            command = [program("penalty_sim", "penalty_sim_node"), "__name:=simulation", "_scene:=touch_cube", "_rate:=1000"]
        self.processes[name] = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def kill(self, name):
        process = self.processes.pop(name)
        process.kill()
        process.wait(10)

    def test_killed_at_random(self):
        choose = random.Random(5)
        wrench = Probe("/spidar/wrench", WrenchStamped)
        state = Probe("/spidar/state", DeviceState)
        contacts = Probe("/contacts", Contacts)
        for name in ("driver", "simulation"):
            self.start(name)
        for _ in range(ROUNDS):
            wrench.clear()
            wrench.wait(5, timeout=40, accept=lambda m: norm(m.wrench.force) > 0.5)  # the hand presses the cube
            time.sleep(choose.uniform(0, 0.3))
            victim = choose.choice(("driver", "simulation"))
            self.kill(victim)
            killed = rospy.Time.now()
            if victim == "simulation":
                gone = killed + rospy.Duration(AGE_LIMIT + DECAY + SLACK)
                wrench.clear()
                wrench.wait(5, timeout=30, accept=lambda m: m.header.stamp > gone)
                late = [m for m in wrench.messages if m.header.stamp > gone]
                self.assertTrue(all(norm(m.wrench.force) < 0.1 for m in late), "a force outlives its sender")
                state.clear()
                state.wait(1)  # the driver lives
            else:
                contacts.clear()
                contacts.wait(5)  # the simulation lives
                self.assertIsNone(self.processes["simulation"].poll())
            self.start(victim)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "killed", Killed, sys.argv)
