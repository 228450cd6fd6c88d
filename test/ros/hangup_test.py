#!/usr/bin/env python3
"""roslaunch has been asked to end and has not asked its nodes yet: its log says so, and the driver takes the current. Here the test is
the parent, has a log as roslaunch's, and asks nobody."""
import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rostest
from emulated_boards import EmulatedBoards
from topic_probe import program, wait_until


class Hangup(unittest.TestCase):
    def test_the_log_of_roslaunch_takes_the_current(self):
        boards = EmulatedBoards("spidar_g6x5r")
        self.addCleanup(boards.close)
        with tempfile.TemporaryDirectory() as folder, \
                open(os.path.join(folder, "roslaunch-here-1.log"), "w", encoding="utf-8", buffering=1) as log:
            log.write("[roslaunch.pmon][INFO] of before: ProcessMonitor.shutdown\n")
            driver = subprocess.Popen([program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar",
                                       "_device:=spidar_g6x5r", "_transport:=file", f"_port:={boards.port}", "_calibrate_at_start:=true",
                                       "_enable_force_at_start:=true", "_end_with_parent:=true"],
                                      env=dict(os.environ, HAPTIC_STOP_FOLDER=folder))
            self.addCleanup(driver.wait, 30)
            self.addCleanup(driver.terminate)
            wait_until("current", lambda: boards.drive() == "on")
            log.write("[roslaunch.pmon][INFO] process has died\n")
            self.assertEqual(boards.drive(), "on")
            log.write("[roslaunch.pmon][INFO] Process")
            log.flush()
            log.write("Monitor.shutdown <ProcessMonitor>\n")
            wait_until("no current", lambda: boards.drive() == "off")
            self.assertIsNone(driver.poll(), "the rest is roslaunch's")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "hangup", Hangup, sys.argv)
