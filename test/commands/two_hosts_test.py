#!/usr/bin/python3
"""Driver, world and loop on one host, a listener on another: two network namespaces with ROS_IP. The other host's loss does
not disturb the loop. Skipped where network namespaces are not permitted."""
import os
import re
import signal
import subprocess
import time
import unittest

from network_hosts import Hosts

PORT = 11399


class TwoHosts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.hosts = Hosts(7, PORT)
        if cls.hosts.why_not:
            raise unittest.SkipTest(f"no network namespaces here: {cls.hosts.why_not}")

    @classmethod
    def tearDownClass(cls):
        cls.hosts.remove()

    def echo(self, host, topic, count, seconds):
        """`count` messages of a topic, as rostopic prints them on that host; what came within the time."""
        return self.hosts.call(host, f"rostopic echo -n {count} {topic}", seconds)

    def ticks(self):
        found = re.findall(r"^ticks: (\d+)$", self.echo("a", "/tick_statistics", 1, 20), re.MULTILINE)
        self.assertTrue(found, "no statistics on the loop's own host")
        return int(found[-1])

    def test_the_other_host_is_lost(self):
        loop = self.hosts.start("a", f"roslaunch -p {PORT} --disable-title --skip-log-check --no-summary haptic_bringup demo.launch rviz:=false")
        listener = None
        try:
            end = time.monotonic() + 60
            while "position" not in self.echo("b", "/spidar/pose/pose", 1, 5) and time.monotonic() < end:
                self.assertIsNone(loop.poll(), "the stack ended")
            self.assertIn("position", self.echo("b", "/spidar/pose/pose", 1, 10), "poses reach the other host")
            listener = self.hosts.start("b", "rostopic hz /spidar/pose")
            time.sleep(2)
            before = self.ticks()
            self.hosts.wire("b", "down")
            end = time.monotonic() + 60
            while self.ticks() < before + 3000:  # three seconds' worth
                self.assertLess(time.monotonic(), end, "the loop ticks on")
            self.assertIsNone(loop.poll())
            self.hosts.wire("b", "up")
            self.assertIn("position", self.echo("b", "/spidar/pose/pose", 1, 30), "the other host is back")
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
