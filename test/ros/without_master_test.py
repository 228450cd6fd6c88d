#!/usr/bin/env python3
"""STOP while the master is dead: by its program, by a signal. A new master knows the driver's services and topics again."""
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rosgraph
import rostest
from emulated_boards import EmulatedBoards
from topic_probe import program, wait_until

SERVICES = {"/spidar/driver/" + name for name in ("stop", "enable_force", "recover", "calibrate", "calibrate_wave")}


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class WithoutMaster(unittest.TestCase):
    def setUp(self):
        self.port = free_port()
        self.folder = tempfile.mkdtemp()  # mode 0700, as the driver wants it
        uri = f"http://127.0.0.1:{self.port}"
        self.environment = dict(os.environ, ROS_MASTER_URI=uri, ROS_IP="127.0.0.1", HAPTIC_STOP_FOLDER=self.folder)
        self.graph = rosgraph.Master("/without_master_test", uri)
        self.boards = EmulatedBoards("spidar_g6x5r")
        self.driver = self.master = None
        self.addCleanup(self.end)  # also of a start that fails
        self.master = self.start_master()
        self.driver = subprocess.Popen(
            [program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar", "_device:=spidar_g6x5r",
             "_transport:=file", f"_port:={self.boards.port}", "_rate:=500", "_calibrate_at_start:=true", "_enable_force_at_start:=true"],
            env=self.environment, start_new_session=True)
        wait_until("its services", lambda: SERVICES <= self.services(), 30)
        self.current()

    def end(self):
        for process in filter(None, (self.driver, self.master)):
            if process.poll() is None:
                process.kill()
            process.wait(10)
        self.boards.close()
        shutil.rmtree(self.folder)

    def start_master(self):
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(self.port)], env=self.environment, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, start_new_session=True)
        wait_until("a master", self.graph.is_online, 30)
        return master

    def end_master(self):
        self.master.kill()
        self.master.wait(10)

    def services(self):
        return {name for name, _ in self.graph.getSystemState()[2]}

    def topics(self, kind):
        """0: published, 1: subscribed."""
        return dict(self.graph.getSystemState()[kind])

    def ask(self, service, *request):
        done = subprocess.run(["rosservice", "call", "/spidar/driver/" + service, *request], env=self.environment, check=False,
                              capture_output=True, text=True, timeout=60)
        return "success: True" in done.stdout

    def current(self):
        """A busy machine may keep the boards' process from its core for longer than a board may be silent (20 ms): the driver is
        right to stop then, and is asked to go on."""
        wait_until("current", lambda: self.boards.drive() == "on" or (self.ask("recover") and self.boards.drive() == "on"), 60)

    def stop(self):
        return subprocess.run([program("spidar_driver", "spidar_stop")], env=self.environment, check=False, capture_output=True,
                              text=True, timeout=30)

    def test_stop_needs_no_master_and_services_come_back_with_one(self):
        self.end_master()
        said = self.stop()
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("spidar: STOP, the motors are off", said.stdout)
        self.assertEqual(self.boards.drive(), "off")
        self.master = self.start_master()
        wait_until("the services at the new master", lambda: SERVICES <= self.services(), 30)
        wait_until("the topics", lambda: "/spidar/state" in self.topics(0) and "/spidar/wrench_command" in self.topics(1), 30)
        self.assertEqual(dict(self.graph.getTopicTypes())["/spidar/state"], "haptic_msgs/DeviceState")
        self.assertFalse(self.ask("calibrate"), "the strings may be slack")
        self.current()
        wait_until("a stop", lambda: self.ask("stop"))  # boards that a busy machine silences do not answer it at once
        self.assertEqual(self.boards.drive(), "off")

    def test_a_signal_stops_as_well(self):
        self.end_master()
        self.driver.send_signal(signal.SIGUSR1)
        wait_until("no current", lambda: self.boards.drive() == "off")
        self.assertIsNone(self.driver.poll(), "it goes on without force")

    def test_every_end_passes_through_zero_and_leaves_no_socket(self):
        self.driver.send_signal(signal.SIGINT)
        self.driver.wait(20)
        self.assertEqual(self.boards.drive(), "off")
        self.assertEqual(os.listdir(self.folder), [])
        said = self.stop()
        self.assertEqual(said.returncode, 2)
        self.assertIn("no device of this user runs", said.stderr)

    def test_a_driver_that_was_killed_is_not_waited_for(self):
        self.driver.kill()
        self.driver.wait(10)
        wait_until("no current", lambda: self.boards.drive() == "off")
        self.assertEqual(self.stop().returncode, 2)
        self.assertEqual(os.listdir(self.folder), [])


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "without_master", WithoutMaster, sys.argv)
