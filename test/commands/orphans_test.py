#!/usr/bin/python3
"""Whatever kills ./run demo or roslaunch: nothing of the run goes on, the master and the recorder included."""
import os
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from run_verb import ROOT, RUN, Call, descendants

PATIENCE = 60  # [s] for a busy machine; the benchmark `faults` counts what is left after one second

# A loader that waits for its manager hears no SIGINT: a busy machine has one while the demo starts.
WITH_A_DEAF_NODE = """<launch>
  <include file="$(find haptic_bringup)/launch/demo.launch"><arg name="rviz" value="false"/></include>
  <node pkg="nodelet" type="nodelet" name="deaf" args="load penalty_sim/SimulationNodelet not_there"/>
</launch>
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_until(what, condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"not within {PATIENCE} s: {what}")
        time.sleep(0.1)


def command(pid):
    try:
        with open(f"/proc/{pid}/cmdline", encoding="utf-8") as line:
            return line.read().replace("\0", " ")
    except OSError:
        return ""


class Orphans(unittest.TestCase):
    def start(self, words, **environment):
        """A run in a session of its own, and what finds its processes, once its loop ticks."""
        marker = f"HAPTIC_TEST_CALL={os.getpid()}-{time.monotonic_ns()}"
        folder = tempfile.mkdtemp()
        self.addCleanup(subprocess.run, ["rm", "-rf", folder], check=True)
        variables = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "ROS_MASTER_URI")}
        variables.update(environment, HAPTIC_TEST_CALL=marker.split("=")[1], HAPTIC_STOP_FOLDER=folder)
        process = subprocess.Popen(words, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        self.addCleanup(lambda: [os.kill(pid, signal.SIGKILL) for pid in descendants(marker)])
        wait_until("the driver listens", lambda: os.listdir(folder))
        wait_until("the bridge is loaded", lambda: any("BridgeNodelet" in command(pid) for pid in descendants(marker)))
        before = None
        while before != (before := {pid for pid in descendants(marker) if "__name:=" in command(pid)}):
            time.sleep(2)  # a node that is just born is not known to the others yet
        return process, marker

    def killed(self, words, how, **environment):
        process, marker = self.start(words, **environment)
        os.kill(process.pid, how)
        process.wait(PATIENCE)
        wait_until(f"nothing is left after {how.name}", lambda: not descendants(marker))

    def test_the_demo_is_killed(self):
        for how in (signal.SIGKILL, signal.SIGQUIT, signal.SIGHUP):
            self.killed([RUN, "demo", "--seconds", "600"], how)

    def test_roslaunch_is_killed(self):
        self.assertEqual(Call("demo", "--seconds", "0.1").code, 0)  # builds what is missing
        with tempfile.NamedTemporaryFile("w", suffix=".launch") as file:
            file.write(WITH_A_DEAF_NODE)
            file.flush()
            self.roslaunch_is_killed(file.name)

    def roslaunch_is_killed(self, file):
        launch = f'. "{ROOT}/build/devel/setup.sh"; exec roslaunch -p {free_port()} {file}'
        for how in (signal.SIGKILL, signal.SIGQUIT):
            self.killed(["sh", "-c", launch], how, ROS_IP="127.0.0.1")


if __name__ == "__main__":
    unittest.main()
