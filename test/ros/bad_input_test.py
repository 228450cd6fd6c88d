#!/usr/bin/env python3
"""What a user may get wrong: one line that names it and says what to do, exit code not 0, within 5 s."""
import os
import re
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rospy
import rostest
from topic_probe import NODELET, load_nodelet, program

LIMIT = 30.0  # [s] it takes 1 s; a machine that does something else may take long, one that hangs never ends


def fatal_lines(output):
    plain = re.sub(r"\x1b\[[0-9;]*m", "", output)
    return [line for line in plain.splitlines() if line.startswith("[FATAL]")]


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("bad_input_test")

    def run_node(self, package, *parameters):
        begin = time.monotonic()
        done = subprocess.run([program(package, package + "_node"), "__name:=bad"] + [f"_{p}" for p in parameters],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False)
        self.assertLess(time.monotonic() - begin, LIMIT, done.stdout)
        for parameter in parameters:
            key = parameter.split(":=")[0]
            if rospy.has_param(f"/bad/{key}"):
                rospy.delete_param(f"/bad/{key}")
        return done

    def assert_refused(self, package, words, *parameters):
        done = self.run_node(package, *parameters)
        self.assertNotEqual(done.returncode, 0, done.stdout)
        lines = fatal_lines(done.stdout)
        self.assertEqual(len(lines), 1, done.stdout)
        for word in words:
            self.assertIn(word, lines[0])

    def test_driver(self):
        self.assert_refused("spidar_driver", ["no_such_device"], "device:=no_such_device")
        self.assert_refused("spidar_driver", ["/tmp/no_such_device.yaml"], "device:=/tmp/no_such_device.yaml")
        self.assert_refused("spidar_driver", ["/bad/rate", "Hz"], "rate:=0")
        self.assert_refused("spidar_driver", ["/bad/rate", "Hz"], "rate:=1000000")
        self.assert_refused("spidar_driver", ["/bad/rate", "not a number"], "rate:=fast")
        self.assert_refused("spidar_driver", ["/bad/hand", "script, marker, none"], "hand:=left")
        self.assert_refused("spidar_driver", ["/bad/command_age_limit"], "command_age_limit:=10")
        self.assert_refused("spidar_driver", ["/bad/device", "no text"], "device:=5")
        self.assert_refused("spidar_driver", ["/bad/usb_unit", "whole"], "usb_unit:=1.5")
        self.assert_refused("spidar_driver", ["/bad/place_base", "true, false"], "place_base:=perhaps")

    def test_simulation(self):
        self.assert_refused("penalty_sim", ["no_such_scene"], "scene:=no_such_scene")
        self.assert_refused("penalty_sim", ["/tmp/no_such_scene.urdf"], "scene:=/tmp/no_such_scene.urdf")
        self.assert_refused("penalty_sim", ["/bad/rate", "Hz"], "rate:=-5", "scene:=touch_cube")
        self.assert_refused("penalty_sim", ["/bad/alone", "true, false"], "alone:=2", "scene:=touch_cube")
        self.assert_refused("penalty_sim", ["/bad/priority", "98"], "priority:=99", "scene:=touch_cube")
        empty = "/tmp/haptic_bad_input_empty.urdf"
        with open(empty, "w", encoding="utf-8"):
            pass
        try:
            self.assert_refused("penalty_sim", [empty], f"scene:={empty}")
        finally:
            os.remove(empty)

    def test_port_that_never_appears(self):
        begin = time.monotonic()
        manager = subprocess.Popen([NODELET, "manager", "__name:=empty_manager"], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True)
        loader = load_nodelet("haptic_bridge/BridgeNodelet", "/bridge", "/empty_manager", seconds=1)
        try:
            output = manager.communicate(timeout=60)[0]
        finally:
            manager.kill()
            loader.kill()
            loader.stdout.close()
        self.assertLess(time.monotonic() - begin, LIMIT + 1, output)  # one second to start two processes
        lines = fatal_lines(output)
        self.assertEqual(len(lines), 1, output)
        self.assertIn("no world is offered", lines[0])
        self.assertNotIn("figure demo.", output)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "bad_input", BadInput, sys.argv)
