#!/usr/bin/python3
"""Who is on another machine and not allowed moves no motor, calls no service and ends no node; this machine and an allowed one do.

Two network namespaces: the driver's host has the master and a driver on the network, the stranger's host attacks. Skipped where
network namespaces are not permitted. HAPTIC_STRANGERS: wrenches per attack; HAPTIC_FIGURES: a file for the figures."""
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest

from network_hosts import Hosts
from run_verb import ROOT

HERE = os.path.dirname(os.path.abspath(__file__))
MEGABYTES = 2000  # of a flood; it ends when nothing is taken
MOST_MB = 20     # that a flood may take of any process's memory
COUNT = int(os.environ.get("HAPTIC_STRANGERS", "40"))
PATIENCE = 120  # [s] for a start on a busy machine
NODE = "/haptics"


def end(process, how=signal.SIGINT):
    """Its output, once it has ended."""
    if process.poll() is None:
        os.killpg(process.pid, how)
    try:
        return process.communicate(timeout=30)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()[0]


def memory(pid, what):
    """VmRSS or VmHWM of a process [MB]."""
    with open(f"/proc/{pid}/status", encoding="utf-8") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(what)) / 1024


class Stack:
    """Master and driver on host `a`; what it took is counted from `watch` to `seen`."""

    def __init__(self, hosts, variables=""):
        self.hosts = hosts
        self.roslaunch = hosts.start("a", f"env {variables} roslaunch -p {hosts.port} --disable-title --skip-log-check --no-summary "
                                          f"{HERE}/strangers.launch")
        self.wait_for("success: True", "rosservice call /spidar/driver/calibrate")

    def wait_for(self, words, command):
        until = time.monotonic() + PATIENCE
        while words not in self.hosts.call("a", command, 20):
            if time.monotonic() > until or self.roslaunch.poll() is not None:
                raise AssertionError(end(self.roslaunch))
            time.sleep(0.2)

    def watch(self):
        self.witness = self.hosts.start("a", f"python3 -B {HERE}/witness.py", subprocess.DEVNULL)
        assert self.witness.stdout.readline().strip() == "ready"

    def seen(self):
        """(wrenches accepted, pulses of force, largest force [N]) since `watch`."""
        words = end(self.witness).split()
        return int(words[1]), int(words[3]), float(words[5])

    def attack(self, host, kind, count=COUNT, node="", patience=0.05):
        """What the driver took, how often it connected, and the attacker's output; `patience`: for each connection [s]."""
        self.watch()
        said = self.hosts.call(host, f"env STRANGER_WAIT={patience} python3 -B {HERE}/stranger.py {kind} {count} {node}", 60 + count)
        time.sleep(0.2)  # for what is under way
        connected = re.search(r"^connected (\d+)$", said, re.MULTILINE)
        assert connected, said
        return self.seen(), int(connected.group(1)), said

    def end(self):
        return end(self.roslaunch)


class Strangers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.hosts = Hosts(8, 11398)
        if cls.hosts.why_not:
            raise unittest.SkipTest(f"no network namespaces here: {cls.hosts.why_not}")
        cls.stack = Stack(cls.hosts)

    @classmethod
    def tearDownClass(cls):
        cls.stack.end()
        cls.hosts.remove()

    def service(self, host, *call):
        return self.hosts.call(host, f"python3 -B {HERE}/stranger.py service " + " ".join(call), 60)

    def alive(self):
        self.assertIsNone(self.stack.roslaunch.poll())
        self.assertIn("Pid:", self.hosts.call("a", f"rosnode info {NODE}", 30))

    def test_1_the_test_itself_hears_this_machine(self):
        (accepted, pulses, force), connected, _ = self.stack.attack("a", "announced", 10, patience=5)
        self.assertGreaterEqual(connected, 8)
        self.assertGreaterEqual(accepted, 5)
        self.assertGreater(pulses, 0)
        self.assertGreater(force, 0.5)
        # Its pulse has died away before the next test counts: command_age_limit and decay are below 0.1 s.
        time.sleep(0.5)

    def test_2_no_wrench_of_a_stranger_is_heard(self):
        moved = connections = 0
        for kind, node in (("announced", ""), ("linger", ""), ("told", NODE)):
            (accepted, pulses, _), connected, _ = self.stack.attack("b", kind, COUNT, node)
            moved += max(accepted, pulses)
            connections += connected
        if "HAPTIC_FIGURES" in os.environ:
            with open(os.environ["HAPTIC_FIGURES"], "a", encoding="utf-8") as figures:
                figures.write(f"figure gate.accepted_from_strangers {moved} of {3 * COUNT}\n")
        self.assertEqual((moved, connections), (0, 0), "wrenches that acted, connections to the stranger")
        self.alive()

    def test_3_the_parameter_server_gives_no_permission(self):
        self.hosts.call("b", "rosparam set /spidar/driver/allowed_addresses \"['10.213.8.2']\"", 30)
        name = "/spidar/driver".encode()
        unload = (len(name).to_bytes(4, "little") + name).hex()
        for call in (("/haptics/unload_nodelet", unload), ("/haptics/load_nodelet",), ("/haptics/list",), ("/spidar/driver/calibrate",),
                     ("/spidar/driver/recover",), ("/spidar/driver/enable_force", "01")):
            answer = self.service("b", *call)
            self.assertNotIn("success True", answer, call)
            self.assertIn("another machine", answer, call)
            self.assertIn("/etc/haptics/allowed_addresses", answer, call)
        self.assertIn("success True", self.service("a", "/spidar/driver/calibrate"))

    def test_4_less_force_is_asked_for_from_anywhere(self):
        self.assertIn("success True", self.service("b", "/spidar/driver/enable_force", "00"))
        self.assertIn("success False", self.service("b", "/spidar/driver/enable_force", "01"))
        self.assertIn("success True", self.service("a", "/spidar/driver/enable_force", "01"))

    def test_5_a_stranger_ends_no_node_and_looks(self):
        said = self.hosts.call("b", f"python3 -B {HERE}/stranger.py shutdown 3 {NODE}", 60)
        self.assertIn("another machine", said)
        self.hosts.call("b", f"rosnode kill {NODE}", 30)
        self.hosts.call("b", f"python3 -B {HERE}/stranger.py multicall 1 {NODE}", 60)
        self.alive()
        self.assertIn("position", self.hosts.call("b", "rostopic echo -n 1 /spidar/pose/pose", 30))

    def grown(self, host, kind, count):
        """Megabytes by which the process of ours that grew most did, at its highest, and what the attacker said."""
        before = {}
        for pid in subprocess.run(["ip", "netns", "pids", self.hosts.name["a"]], capture_output=True, text=True, check=True).stdout.split():
            with open(f"/proc/{pid}/cmdline", encoding="utf-8") as line:
                if not any(name in line.read() for name in ("nodelet", "motor_guard", "spidar")):
                    continue
            with open(f"/proc/{pid}/clear_refs", "w", encoding="utf-8") as peak:
                peak.write("5")
            before[pid] = memory(pid, "VmRSS")
        said = self.hosts.call(host, f"python3 -B {HERE}/stranger.py {kind} {count} {NODE}", 300)
        return max(memory(pid, "VmHWM") - resident for pid, resident in before.items()), said

    def test_5b_strangers_take_no_memory(self):
        grown = {}
        for host in "ba":
            grown[host], said = self.grown(host, "flood", MEGABYTES)
            self.assertEqual(said.count("sent "), 5, said)
            self.alive()
        if "HAPTIC_FIGURES" in os.environ:
            with open(os.environ["HAPTIC_FIGURES"], "a", encoding="utf-8") as figures:
                figures.write(f"figure stranger.memory_mb_max {max(grown.values()):.1f} MB\n")
        self.assertLess(max(grown.values()), MOST_MB, grown)
        for host in "ba":
            self.hosts.call(host, f"python3 -B {HERE}/stranger.py deep 40000 {NODE}", 60)
            self.alive()

    def test_5c_a_name_that_nobody_knows_keeps_no_call_waiting(self):
        asked = self.hosts.start("b", f"python3 -B {HERE}/silent_names.py")
        try:
            self.assertEqual(asked.stdout.readline().strip(), "ready")
            for name in ("no.such.host", "x" * 1000000):
                said = self.hosts.call("a", f"python3 -B {HERE}/stranger.py names {len(name)} {NODE}", 120)
                self.assertLess(float(re.search(r"^slowest ([0-9.]+)$", said, re.MULTILINE).group(1)), 2, said)
            self.alive()
        finally:
            end(asked)

    def test_6_a_launch_file_that_sets_addresses_is_told_where_they_go(self):
        self.hosts.call("a", f"rosnode kill {NODE}", 30)  # from this machine a node can be ended
        output = self.stack.roslaunch.communicate(timeout=60)[0]
        told = [line for line in output.splitlines() if "allowed_addresses is not heard" in line]
        self.assertEqual(len(told), 1, output)
        self.assertIn("/etc/haptics/allowed_addresses", told[0])


class Allowed(unittest.TestCase):
    def setUp(self):
        self.hosts = Hosts(9, 11397)
        if self.hosts.why_not:
            self.skipTest(f"no network namespaces here: {self.hosts.why_not}")
        self.addCleanup(self.hosts.remove)

    def file(self, text, mode=0o600):
        handle = tempfile.NamedTemporaryFile("w", suffix=".addresses")
        self.addCleanup(handle.close)
        handle.write(text)
        handle.flush()
        os.chmod(handle.name, mode)
        return handle.name

    def test_the_file_of_the_machine_gives_permission(self):
        path = self.file(f"# the desk\n{self.hosts.address['b']}  # and its screen\n")
        stack = Stack(self.hosts, f"HAPTICS_ALLOWED_ADDRESSES={path}")
        try:
            (accepted, _, force), connected, said = stack.attack("b", "announced", 10, patience=5)
            self.assertGreaterEqual(connected, 8, said)
            self.assertGreaterEqual(accepted, 5)
            self.assertGreater(force, 0.5)
            self.assertIn("success: True", self.hosts.call("b", "rosservice call /spidar/driver/enable_force true", 60))
        finally:
            stack.end()

    def test_a_file_that_others_may_write_is_refused(self):
        program = os.path.join(ROOT, "build", "devel", "lib", "spidar_driver", "spidar_driver_node")
        master = self.hosts.start("a", f"roscore -p {self.hosts.port}")
        try:
            for path, words in ((self.file("10.0.0.1\n", 0o666), ["others", "may write it"]),
                                (self.file("10.0.0.1\n10.0.0\n"), [":2", "'10.0.0' is no address"]),
                                ("/no/such/file", ["/no/such/file", "cannot be read"])):
                said = self.hosts.call("a", f"env HAPTICS_ALLOWED_ADDRESSES={path} {program} __ns:=spidar", 60)
                lines = [line for line in said.splitlines() if "FATAL" in line]
                self.assertEqual(len(lines), 1, said)
                for word in words:
                    self.assertIn(word, lines[0])
        finally:
            end(master)


if __name__ == "__main__":
    unittest.main()
