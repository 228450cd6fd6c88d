#!/usr/bin/env python3
"""A hand on a switch: without fresh word that it is held no force is on, whoever enables it."""
import os
import signal
import subprocess
import sys
import threading
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from haptic_msgs.msg import DeviceState
from sensor_msgs.msg import Joy
from std_srvs.srv import SetBool
from topic_probe import Probe, program, wait_until

BUTTON = 2


class DeadMan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("dead_man_test")

    def setUp(self):
        self.state = Probe("/spidar/state", DeviceState)
        # The age limit is the longest that there is: a busy machine must not let go of the switch. What is judged is which state
        # follows, not when.
        self.driver = subprocess.Popen([program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar",
                                        "_script:=rest", "_dead_man:=joy", f"_dead_man_button:={BUTTON}", "_dead_man_age_limit:=1.0"])
        self.pedal = rospy.Publisher("/spidar/dead_man", Joy, queue_size=1)
        self.held, self.ends = None, threading.Event()
        self.thread = threading.Thread(target=self.press)
        self.thread.start()
        wait_until("the switch's connection", lambda: self.pedal.get_num_connections() > 0, 30)

    def tearDown(self):
        self.ends.set()
        self.thread.join()
        self.driver.send_signal(signal.SIGINT)
        self.driver.wait(20)
        self.state.close()

    def press(self):
        """`held`: index of the button that is pressed; -1: none; None: the pedal says nothing."""
        while not self.ends.wait(0.02):
            held = self.held
            if held is not None:
                self.pedal.publish(Joy(buttons=[int(i == held) for i in range(4)]))

    def wait_for(self, state, switch):
        self.state.clear()
        return self.state.wait(1, timeout=30, accept=lambda m: m.state == state and m.dead_man == switch)

    def test_force_is_on_while_the_switch_is_held(self):
        released = self.wait_for(DeviceState.READY, DeviceState.SWITCH_RELEASED)
        self.assertIn("dead-man switch is not held", released.message)
        enable = rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)
        answer = enable(True)
        self.assertTrue(answer.success, "it waits for the hand")
        self.assertIn("dead-man switch is not held", answer.message)
        self.held = BUTTON + 1
        rospy.sleep(0.5)
        self.wait_for(DeviceState.READY, DeviceState.SWITCH_RELEASED)
        for let_go in (-1, None):  # by its word, and by its silence
            self.held = BUTTON
            self.assertTrue(self.wait_for(DeviceState.ENABLED, DeviceState.SWITCH_HELD).force_enabled)
            self.held = let_go
            self.assertFalse(self.wait_for(DeviceState.READY, DeviceState.SWITCH_RELEASED).force_enabled)
        self.held = BUTTON
        self.wait_for(DeviceState.ENABLED, DeviceState.SWITCH_HELD)
        self.assertTrue(enable(False).success)
        self.wait_for(DeviceState.READY, DeviceState.SWITCH_HELD)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "dead_man", DeadMan, sys.argv)
