#!/usr/bin/env python3
"""A driver on emulated motor boards is killed by name, by command line, by group and as a parent, and stopped: the motors are
off each time, and the guard that does it ends with its driver. Its services answer with what happened."""
import os
import re
import signal
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import rosgraph
import rospy
import rostest
from emulated_boards import EmulatedBoards
from haptic_msgs.msg import DeviceState
from std_srvs.srv import SetBool, Trigger
from topic_probe import Probe, program, wait_until

ROUNDS = int(os.environ.get("HAPTIC_GUARD_ROUNDS", "1"))


def guards(port):
    """Processes that watch the motors at a port; other drivers of this machine have theirs."""
    found = []
    for entry in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{entry}/cmdline", "rb") as line:
                if line.read() != b"motor_guard\0":
                    continue
            if any(os.readlink(f"/proc/{entry}/fd/{fd}") == port for fd in os.listdir(f"/proc/{entry}/fd")):
                found.append(int(entry))
        except OSError:
            pass  # it ended between the two lines
    return found


def said(pid, what):
    with open(f"/proc/{pid}/{what}", encoding="utf-8") as text:
        return text.read().replace("\0", " ").strip()


def parent(pid):
    return int(said(pid, "stat").rsplit(")", 1)[1].split()[1])


def kill_all(pids, chosen):
    """SIGKILL to those of `pids` that `chosen` takes, as pkill would; other drivers of this machine are nobody's business."""
    for pid in [pid for pid in pids if chosen(pid)]:
        os.kill(pid, signal.SIGKILL)


class Guard(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("guard_test")

    def setUp(self):
        self.boards = EmulatedBoards("spidar_g6x5r")
        self.driver, self.state = None, Probe("/spidar/state", DeviceState)

    def tearDown(self):
        self.state.close()
        if self.driver and self.driver.poll() is None:
            self.driver.send_signal(signal.SIGCONT)
            self.driver.send_signal(signal.SIGINT)
            self.driver.wait(10)
        for guard in self.guards():  # a test that failed may have left one stopped
            os.kill(guard, signal.SIGCONT)
        wait_until("the guard ends with its driver", lambda: not self.guards())
        self.boards.close()
        rospy.delete_param("/spidar/driver")  # of this test, not of the next

    def start(self, *parameters):
        """A driver in a group of its own, and its guard."""
        self.state.clear()
        command = [program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar", "_device:=spidar_g6x5r",
                   "_transport:=file", f"_port:={self.boards.port}", "_rate:=500", *parameters]
        self.driver = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.state.wait(1, timeout=30)
        wait_until("a guard", lambda: len(self.guards()) == 1)
        return self.guards()[0]

    def guards(self):
        return guards(os.path.realpath(self.boards.port))

    def recover(self):
        return rospy.ServiceProxy("/spidar/driver/recover", Trigger)()

    def wait_for_current(self):
        """A busy machine may keep the boards' process from its core for longer than a board may be silent (20 ms): the driver
        is right to stop then, and is asked to go on."""
        rospy.wait_for_service("/spidar/driver/recover", 20)
        wait_until("current", lambda: self.boards.drive() == "on" or (self.recover() and False), 30)

    def lose_guard(self, how):
        """The guard that was ended or stopped while there was current. Boards that a busy machine silences before stop the force first, and
        then the end of a guard is no fault: it is done again."""
        for _ in range(5):
            self.wait_for_current()
            wait_until("a guard", lambda: len(self.guards()) == 1)
            guard = self.guards()[0]
            self.state.clear()
            os.kill(guard, how)
            fault = self.state.wait(1, accept=lambda m: m.state in (DeviceState.FAULT, DeviceState.DISCONNECTED))
            self.assertFalse(fault.force_enabled)
            if "guard" in fault.message:
                return guard
            if how == signal.SIGSTOP:
                os.kill(guard, signal.SIGCONT)
        return self.fail("the boards were silent each time")

    def test_whatever_kills_the_driver_leaves_no_current(self):
        kills = {
            "its name": lambda d, g: kill_all((d, g), lambda p: said(p, "comm").startswith(("spidar", "nodelet"))),
            "its command line": lambda d, g: kill_all((d, g), lambda p: re.search("driver|nodelet|spidar|boards", said(p, "cmdline"))),
            "its group": lambda d, g: os.killpg(os.getpgid(d), signal.SIGKILL),
            "its session": lambda d, g: kill_all((g, d), lambda p: os.getsid(p) == os.getsid(d)),
            "its children": lambda d, g: kill_all((g, d), lambda p: p == d or parent(p) == d),
            "a crash": lambda d, g: os.kill(d, signal.SIGSEGV),
        }
        for _ in range(ROUNDS):
            for how, kill in kills.items():
                guard = self.start()
                self.wait_for_current()
                kill(self.driver.pid, guard)
                self.driver.wait(10)
                wait_until(f"no current after a kill by {how}", lambda: self.boards.drive() == "off")
                wait_until("the guard ends", lambda guard=guard: guard not in self.guards())

    def test_a_driver_without_its_guard_leaves_no_current(self):
        for how in (signal.SIGKILL, signal.SIGSTOP):
            self.start("_calibrate_at_start:=true", "_enable_force_at_start:=true")
            guard = self.lose_guard(how)
            wait_until("no current without a guard", lambda: self.boards.drive() == "off")
            if how == signal.SIGSTOP:
                os.kill(guard, signal.SIGCONT)
            wait_until("a guard again", lambda: len(self.guards()) == 1)
            time.sleep(0.5)
            self.assertEqual(self.boards.drive(), "off", "a new guard is no reason to pull")
            enable = rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)
            wait_until("force again", lambda: self.recover().success and enable(True).success, 20)
            self.driver.kill()
            self.driver.wait(10)
            wait_until("no current without a driver", lambda: self.boards.drive() == "off")
            wait_until("the guard ends", lambda: not self.guards())

    def test_a_driver_that_stands_still_leaves_no_current(self):
        self.start()
        self.wait_for_current()
        self.driver.send_signal(signal.SIGSTOP)
        wait_until("no current from a stopped driver", lambda: self.boards.drive() == "off")
        self.driver.send_signal(signal.SIGCONT)
        self.state.clear()
        said = self.state.wait(2)
        self.assertIn("the loop stood still", said.wire)
        self.assertNotIn("board", said.wire, "no board is to blame for it")
        self.assertIsNone(self.driver.poll())

    def test_services_answer_with_what_happened(self):
        self.start()
        enable = rospy.ServiceProxy("/spidar/driver/enable_force", SetBool)
        calibrate = rospy.ServiceProxy("/spidar/driver/calibrate", Trigger)
        self.wait_for_current()
        answers = []

        def said(service, part):  # boards that a busy machine silences make another answer; asked to go on, it says this one
            answers.append(service())
            return part in answers[-1].message or (self.recover() and False)
        wait_until("a refusal without a pose", lambda: said(lambda: enable(True), "UNCALIBRATED"))
        self.assertFalse(any(answer.success for answer in answers), answers)
        self.assertIn("calibrate", answers[-1].message)
        # The force that could not be switched on does not come later.
        wait_until("a calibration", lambda: said(calibrate, "READY") and answers[-1].success)
        answers = []

        def enabled():  # a busy machine may keep the boards' process from its core for longer than 20 ms
            answers.append(enable(True))
            if not answers[-1].success:
                self.recover(), calibrate()
            return answers[-1].success
        wait_until("force", enabled, 20)
        self.assertIn("ENABLED", answers[-1].message)
        self.state.clear()  # a busy machine may have silenced the boards before
        self.boards.order("kill 1")
        lost = self.state.wait(1, accept=lambda m: m.state == DeviceState.DISCONNECTED)
        self.assertIn("do not answer", lost.message)
        answer = self.recover()
        self.assertFalse(answer.success, answer.message)
        answer = calibrate()
        self.assertFalse(answer.success, answer.message)
        self.assertIn("nothing was done", answer.message)
        self.boards.order("revive 1")
        back = self.state.wait(1, accept=lambda m: m.state == DeviceState.FAULT, timeout=20)
        self.assertIn("silent", back.message)
        self.assertNotIn("wind", back.message)
        # Without power its counters have lost the lengths: who only recovers is told so, and the force stays off.
        wait_until("a recovery", lambda: calibrate().success and self.recover().success, 20)
        self.state.clear()
        after = self.state.wait(2)
        self.assertNotIn(after.state, (DeviceState.ENABLED, DeviceState.REDUCED))
        self.assertFalse(after.force_enabled, "recover switched the force on")

    def test_nodes_listen_on_loopback(self):
        """The ports of topics and services; ROS 1 cannot do it for the ports of its calls (README.md, Security)."""
        self.start()
        uri = rosgraph.Master("/test").lookupNode("/spidar/driver")
        self.assertIn("127.0.0.1", uri)
        calls = int(uri.rstrip("/").rsplit(":", 1)[1])
        inodes = set()
        for entry in os.listdir(f"/proc/{self.driver.pid}/fd"):
            try:
                inodes.add(os.readlink(f"/proc/{self.driver.pid}/fd/{entry}"))
            except OSError:
                pass
        with open("/proc/net/tcp", encoding="utf-8") as table:
            listening = [line.split() for line in table if line.split()[3] == "0A"]
        own = [line[1].split(":") for line in listening if f"socket:[{line[9]}]" in inodes]
        self.assertTrue(own)
        for address, port in own:
            if int(port, 16) != calls:
                self.assertEqual(address, "0100007F", f"port {int(port, 16)}")


if __name__ == "__main__":
    rostest.rosrun("haptic_tests", "guard", Guard, sys.argv)
