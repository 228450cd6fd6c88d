#!/usr/bin/env python3
"""Processes of a run are stopped for more than half a second and go on: the force waits for somebody who asks for it. Whole runs and parts
of them, with the twin in the loop's process and with emulated motor boards. What is judged is what the device says, not when."""
import os
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from emulated_boards import EmulatedBoards
from guard_test import guards
from haptic_msgs.msg import DeviceState
from std_srvs.srv import SetBool, Trigger
from topic_probe import Probe, load_stack, node_pid, program, unload_stack, wait_until

STOPPED = 1.2   # [s]; force comes back by itself from less than half a second
STALE = 2       # states that tell of the time before: on its way, and of the last record before the processes stood
WATCHED = 4     # states that the device publishes afterwards, one a second and one at each change
WAITS = 1 << 29  # DeviceFlag kForceWaits


class Suspend(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("suspend_test")

    def setUp(self):
        self.state = Probe("/spidar/state", DeviceState)
        self.enable = rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)
        self.recover = rospy.ServiceProxy("/spidar/driver/recover", Trigger)

    def tearDown(self):
        self.state.close()

    def force(self):
        """Somebody asks until the force is on: a busy machine may keep the boards' process from its core for longer than they may be silent."""
        rospy.wait_for_service("/spidar/driver/enable_force", 30)
        wait_until("force", lambda: self.enable(True).success or (self.recover() and False), 40,
                   lambda: self.state.messages[-1].message if self.state.messages else "")

    def stop_and_go_on(self, processes):
        for process in processes:
            os.kill(process, signal.SIGSTOP)
        time.sleep(STOPPED)
        self.state.clear()
        for process in reversed(processes):
            os.kill(process, signal.SIGCONT)

    def assert_it_waits(self, what):
        last = self.state.wait(WATCHED)
        after = self.state.messages[STALE:]
        self.assertFalse([m.message for m in after if m.force_enabled], f"{what}: force came back by itself")
        return last

    def test_the_loop_and_its_twin(self):
        stack = load_stack(driver={"transport": "twin"})  # the other test leaves its own on the parameter server
        self.addCleanup(unload_stack, stack)
        self.force()
        self.stop_and_go_on([node_pid("/haptics")])
        said = self.assert_it_waits("the manager")
        self.assertEqual(said.state, DeviceState.READY, said.message)
        self.assertTrue(said.flags & WAITS, said.message)
        self.assertIn("enable_force", said.message)
        self.force()

    def test_a_driver_on_boards_and_its_parts(self):
        boards = EmulatedBoards("spidar_g6x5r")
        driver = subprocess.Popen([program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar", "_rate:=500",
                                   "_device:=spidar_g6x5r", "_transport:=file", f"_port:={boards.port}", "_calibrate_at_start:=true",
                                   "_enable_force_at_start:=true"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        watch = lambda: guards(os.path.realpath(boards.port))
        try:
            self.state.wait(1, timeout=30)
            for name, chosen in {"the driver": lambda: [driver.pid], "the guard": watch,
                                 "all": lambda: [driver.pid, boards.process, *watch()]}.items():
                wait_until("a guard", lambda: len(watch()) == 1)
                self.force()
                self.stop_and_go_on(chosen())
                said = self.assert_it_waits(name)
                # Boards that have not answered for long enough yet are DISCONNECTED.
                self.assertIn(said.state, (DeviceState.READY, DeviceState.FAULT, DeviceState.DISCONNECTED), said.message)
                self.assertIn("enable_force", said.message, name)
                self.assertNotIn("latency timer", said.message, "a program that stood still is no slow wire")
        finally:
            for process in [driver.pid, boards.process, *watch()]:
                os.kill(process, signal.SIGCONT)
            driver.send_signal(signal.SIGINT)
            driver.wait(20)
            boards.close()


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "suspend", Suspend, sys.argv)
