#!/usr/bin/env python3
"""The loop on emulated motor boards: a second driver is refused, and a board that dies leaves a flight recording."""
import glob
import os
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rosbag
import rospy
import rostest
from emulated_boards import EmulatedBoards
from haptic_msgs.msg import DeviceState, TickStatistics
from std_srvs.srv import SetBool, Trigger
from topic_probe import Probe, load_stack, program, replay, unload_stack, wait_until

RATE = 500       # [Hz]; the boards are a process of their own: the pseudo-terminal must keep up on a busy machine
KEPT = 5.0       # before a fault [s]
AFTER = 0.2      # and after it [s]
QUIET = 10.0     # between two flight recordings [s]


def is_closed(path):
    """False: the bag is being written."""
    try:
        rosbag.Bag(path).close()
        return True
    except (rosbag.ROSBagException, OSError):
        return False


class MotorBoards(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("motor_boards_test")
        cls.boards = EmulatedBoards("spidar_g6x5r", "touch_cube")
        cls.flights = os.path.join(cls.boards.folder, "flights")
        cls.stack = load_stack("spidar_g6x5r", RATE, bridge={"flight_folder": cls.flights}, driver=cls.boards.driver_parameters())
        cls.statistics = Probe("/tick_statistics", TickStatistics)
        cls.statistics.wait(1, timeout=40, accept=lambda m: m.ticks > 0)

    @classmethod
    def tearDownClass(cls):
        unload_stack(cls.stack)
        cls.boards.close()

    def test_a_second_driver_is_refused(self):
        state = Probe("/spidar/state", DeviceState)
        before = state.wait(1)
        done = subprocess.run([program("spidar_driver", "spidar_driver_node"), "__name:=second", "__ns:=other",
                               "_device:=spidar_g6x5r", "_transport:=file", f"_port:={self.boards.port}"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=20, check=False)
        self.assertNotEqual(done.returncode, 0, done.stdout)
        plain = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout)
        fatal = [line for line in plain.splitlines() if line.startswith("[FATAL]")]
        self.assertEqual(len(fatal), 1, done.stdout)
        self.assertIn("another program holds the port", fatal[0])
        self.assertIn(self.boards.port, fatal[0])
        self.statistics.clear()
        self.statistics.wait(5)
        self.assertEqual(before.state, state.messages[-1].state, "the first driver does not notice")

    def run_without_fault(self, state):
        """Seconds enough for a recording, with the force on. A busy machine may keep the boards' process from its core for
        longer than a board may be silent (20 ms): the driver is right to stop then, and is asked to go on."""
        seconds = KEPT + 3
        for _ in range(6):
            begin = self.statistics.wait(1).simulated_time
            self.statistics.wait(1, timeout=60, accept=lambda m, begin=begin, seconds=seconds: m.simulated_time > begin + seconds)
            if state.messages[-1].state == DeviceState.ENABLED and not glob.glob(self.flights + "/*.bag"):
                return
            wait_until("a finished recording", lambda: all(map(is_closed, glob.glob(self.flights + "/*.bag"))))
            shutil.rmtree(self.flights, ignore_errors=True)
            rospy.ServiceProxy("/spidar/driver/recover", Trigger)()
            rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)(True)
            seconds = QUIET + 1
        self.fail("the boards were never heard without a gap")

    def test_a_dead_board_leaves_the_last_seconds(self):
        state = Probe("/spidar/state", DeviceState)
        state.wait(1)
        self.run_without_fault(state)
        self.boards.order("kill 1")
        wait_until("a flight recording", lambda: glob.glob(self.flights + "/*.bag"), 20)
        path = glob.glob(self.flights + "/*.bag")[0]
        wait_until("the bag is closed", lambda: is_closed(path))
        self.bag = rosbag.Bag(path)
        self.addCleanup(self.bag.close)
        times = [m.header.stamp.to_sec() for _, m, _ in self.bag.read_messages("flight/spidar/pose")]
        self.assertTrue(all(b > a for a, b in zip(times, times[1:])), "one message per tick, in order")
        ticks = len(times)
        self.assertAlmostEqual(ticks, (KEPT + AFTER) * RATE, delta=1)
        for topic in ("flight/spidar/wrench", "flight/spidar/wrench_asked"):
            self.assertEqual(self.bag.get_message_count(topic), ticks)
        what = [m.status[0].message for _, m, _ in self.bag.read_messages("diagnostics")]
        self.assertEqual(len(what), 1)
        self.assertRegex(what[0], "spidar went to FAULT.*, at tick")
        fault_tick = int(what[0].rsplit(" ", 1)[1])
        # The raw input around it, without a gap.
        runs = [(m.first_tick, m.ticks) for _, m, _ in self.bag.read_messages("recorded/ticks")]
        self.assertTrue(all(a + n == b for (a, n), (b, _) in zip(runs, runs[1:])))
        self.assertLessEqual(runs[0][0], fault_tick - 0.9 * KEPT * RATE)
        self.assertGreater(runs[-1][0] + runs[-1][1], fault_tick)
        session = [m for _, m, _ in self.bag.read_messages("recorded/session")]
        self.assertEqual(len(session), 1)
        # It begins in the middle, where the loop's memory was copied, and comes out again bit for bit up to the dead board.
        self.assertEqual(session[0].first_tick, runs[0][0])
        self.assertGreater(session[0].first_tick, 0)
        self.assertGreater(len(session[0].hand_memory), 0)
        figures = replay(path)
        self.assertGreaterEqual(figures["replay.steps"], (KEPT + AFTER) * RATE)
        self.assertEqual(figures["replay.mismatches"], 0)
        done = subprocess.run(["rosbag", "play", "--immediate", "--quiet", path, "--topics", "/nothing"], check=False,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=20)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "motor_boards", MotorBoards, sys.argv)
