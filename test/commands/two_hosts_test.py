#!/usr/bin/python3
"""Driver, world and loop on one host, a listener on another: two network namespaces with ROS_IP. The other host's loss does
not disturb the loop. Skipped where network namespaces are not permitted."""
import os
import re
import signal
import subprocess
import time
import unittest

from run_verb import ROOT

HOSTS = {"haptic_a": "10.213.7.1", "haptic_b": "10.213.7.2"}
PORT = 11399
SETUP = os.path.join(ROOT, "build", "devel", "setup.sh")


def sh(command):
    return subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)


def remove_hosts():
    for host in HOSTS:
        sh(f"ip netns del {host}")


def make_hosts():
    """Empty when it worked; else why not."""
    remove_hosts()
    steps = [f"ip netns add {host}" for host in HOSTS]
    steps += ["ip link add haptic_va netns haptic_a type veth peer name haptic_vb netns haptic_b"]
    for host, device in (("haptic_a", "haptic_va"), ("haptic_b", "haptic_vb")):
        steps += [f"ip -n {host} addr add {HOSTS[host]}/24 dev {device}", f"ip -n {host} link set {device} up",
                  f"ip -n {host} link set lo up"]
    for step in steps:
        done = sh(step)
        if done.returncode != 0:
            return f"{step}: {done.stderr.strip()}"
    return ""


def on(host, command):
    """Starts a command on a host, as a process group of its own."""
    script = (f". {SETUP}; export ROS_IP={HOSTS[host]} ROS_MASTER_URI=http://{HOSTS['haptic_a']}:{PORT}; exec {command}")
    return subprocess.Popen(["ip", "netns", "exec", host, "sh", "-c", script], stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, start_new_session=True)


def echo(host, topic, count, seconds):
    """`count` messages of a topic, as rostopic prints them on that host; what came within the time."""
    process = on(host, f"timeout {seconds} rostopic echo -n {count} {topic}")
    return process.communicate(timeout=seconds + 20)[0]


class TwoHosts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        why = make_hosts()
        if why:
            remove_hosts()
            raise unittest.SkipTest(f"no network namespaces here: {why}")

    @classmethod
    def tearDownClass(cls):
        remove_hosts()

    def ticks(self):
        found = re.findall(r"^ticks: (\d+)$", echo("haptic_a", "/tick_statistics", 1, 20), re.MULTILINE)
        self.assertTrue(found, "no statistics on the loop's own host")
        return int(found[-1])

    def test_the_other_host_is_lost(self):
        loop = on("haptic_a", f"roslaunch -p {PORT} --disable-title --skip-log-check --no-summary haptic_bringup demo.launch rviz:=false")
        listener = None
        try:
            end = time.monotonic() + 60
            while "position" not in echo("haptic_b", "/spidar/pose/pose", 1, 5) and time.monotonic() < end:
                self.assertIsNone(loop.poll(), "the stack ended")
            self.assertIn("position", echo("haptic_b", "/spidar/pose/pose", 1, 10), "poses reach the other host")
            listener = on("haptic_b", "rostopic hz /spidar/pose")
            time.sleep(2)
            before = self.ticks()
            sh("ip -n haptic_b link set haptic_vb down")
            begin = time.monotonic()
            time.sleep(3)
            after = self.ticks()
            seconds = time.monotonic() - begin
            self.assertGreater(after - before, 0.5 * 1000 * seconds, "the loop ticks on at its rate")
            self.assertIsNone(loop.poll())
            sh("ip -n haptic_b link set haptic_vb up")
            self.assertIn("position", echo("haptic_b", "/spidar/pose/pose", 1, 30), "the other host is back")
        finally:
            for process in filter(None, (listener, loop)):
                os.killpg(process.pid, signal.SIGINT)
            for process in filter(None, (listener, loop)):
                try:
                    process.communicate(timeout=20)
                except subprocess.TimeoutExpired:
                    os.killpg(process.pid, signal.SIGKILL)


if __name__ == "__main__":
    unittest.main()
