#!/usr/bin/python3
"""Stacks on one master: a second of the same name is refused with one line and the first goes on; in namespaces two run side by
side, each with names of its own."""
import os
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from run_verb import ROOT

SETUP = os.path.join(ROOT, "build", "devel", "setup.sh")
PATIENCE = 120  # [s] for a start or an end on a busy machine


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class OneMaster(unittest.TestCase):
    def setUp(self):
        self.port = free_port()
        self.running = []
        self.master = self.start("roscore")

    def tearDown(self):
        for process in reversed(self.running):
            self.end(process)

    def start(self, command, namespace=""):
        space = f"export ROS_NAMESPACE={namespace};" if namespace else ""
        script = f". {SETUP}; export ROS_IP=127.0.0.1 ROS_MASTER_URI=http://127.0.0.1:{self.port}; {space} exec {command}"
        if command == "roscore":
            script += f" -p {self.port}"
        process = subprocess.Popen(["sh", "-c", script], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True, start_new_session=True)
        self.running.append(process)
        return process

    def end(self, process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        try:
            return process.communicate(timeout=40)[0]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return process.communicate()[0]

    def demo(self, namespace="", **arguments):
        given = " ".join(f"{key}:={value}" for key, value in arguments.items())
        return self.start(f"roslaunch --wait --disable-title --skip-log-check --no-summary haptic_bringup demo.launch rviz:=false {given}",
                          namespace)

    def ask(self, command):
        return self.start(f"timeout 30 {command}").communicate()[0]

    def wait_ticking(self, process, topic):
        until = time.monotonic() + PATIENCE
        while "ticks:" not in self.ask(f"rostopic echo -n 1 {topic}"):
            if process.poll() is not None or time.monotonic() > until:
                self.fail(self.end(process))

    def test_a_second_stack_of_the_same_name_is_refused(self):
        first = self.demo()
        self.wait_ticking(first, "/tick_statistics")
        second = self.demo()
        said = second.communicate(timeout=PATIENCE)[0]
        told = [line for line in said.splitlines() if "runs already on this master" in line]
        self.assertEqual(len(told), 1, said)
        for word in ("/haptics", "process", "ROS_NAMESPACE=robot1"):
            self.assertIn(word, told[0])
        self.assertIsNone(first.poll(), "the first goes on")
        self.wait_ticking(first, "/tick_statistics")

    def test_nothing_of_a_stack_is_listed_after_its_end(self):
        stack = self.demo()
        self.wait_ticking(stack, "/tick_statistics")
        self.assertIn("/haptics", self.ask("rosnode list"))
        self.assertIn("/robot_description", self.ask("rosparam list"))
        self.end(stack)
        self.assertEqual(self.ask("rosnode list").split(), ["/rosout"])
        self.assertNotIn("/robot_description", self.ask("rosparam list"))

    def test_two_stacks_in_namespaces(self):
        with tempfile.TemporaryDirectory() as folder:
            stacks = [(name, self.demo(name, record=f"{folder}/{name}.bag")) for name in ("robot1", "robot2")]
            for name, process in stacks:
                self.wait_ticking(process, f"/{name}/tick_statistics")
            nodes = self.ask("rosnode list").split()
            topics = self.ask("rostopic list").split()
            for name, _ in stacks:
                for node in ("haptics", "spidar/driver", "simulation", "bridge", "record"):
                    self.assertIn(f"/{name}/{node}", nodes)
                self.assertIn(f"/{name}/tf", topics)
            own = [topic for topic in topics if not topic.startswith(("/robot1/", "/robot2/"))]
            self.assertEqual(sorted(set(own) - {"/rosout", "/rosout_agg", "/diagnostics", "/clock"}), [])
            for name, process in stacks:
                answer = self.ask(f"rosservice call /{name}/spidar/driver/enable_force true")
                self.assertIn("success: True", answer)
            for name, process in stacks:
                self.end(process)
                other = "robot2" if name == "robot1" else "robot1"
                info = self.ask(f"rosbag info {folder}/{name}.bag")
                self.assertIn(f"/{name}/recorded/ticks", info)
                self.assertNotIn(f"/{other}/", info)


if __name__ == "__main__":
    unittest.main()
