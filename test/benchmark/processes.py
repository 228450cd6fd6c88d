#!/usr/bin/python3
"""STOP without a master, and what is left of a run whose parent was killed, on real processes with emulated motor boards.

    hangup.zero_ms_max       the longest of ROUNDS: from SIGHUP to roslaunch to the boards' word that no current flows
    stop.without_master_ms   the longest of ROUNDS: from the start of spidar_stop to the boards' word that no current flows
    orphans.left             processes of a run one second after the end of ./run demo or roslaunch, summed over five signals each
"""
import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "test", "ros"), os.path.join(ROOT, "test", "commands")]

import rosgraph
from emulated_boards import EmulatedBoards
from run_verb import RUN, descendants
from topic_probe import program, wait_until

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGKILL)
PATIENCE = 60


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def figure(name, value, unit):
    print(f"figure {name} {value:.6g} {unit}", flush=True)


class Device:
    """A driver on emulated boards, a master of its own, and current in the motors."""

    def __init__(self, folder):
        self.environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}", ROS_IP="127.0.0.1",
                                HAPTIC_STOP_FOLDER=folder)
        self.boards, self.started = EmulatedBoards("spidar_g6x5r"), []
        self.master = self.start("rosmaster", "--core", "-p", self.environment["ROS_MASTER_URI"].rsplit(":", 1)[1])
        wait_until("a master", rosgraph.Master("/bench", self.environment["ROS_MASTER_URI"]).is_online, PATIENCE)
        self.start(program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar", "_device:=spidar_g6x5r",
                   "_transport:=file", f"_port:={self.boards.port}", "_calibrate_at_start:=true", "_enable_force_at_start:=true")
        # A busy machine may keep the boards' process from its core for longer than a board may be silent: it is asked again.
        wait_until("current", lambda: os.listdir(folder) and (self.boards.drive() == "on" or self.recovered()), PATIENCE)

    def start(self, *words):
        self.started.append(subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        return self.started[-1]

    def recovered(self):
        subprocess.run(["rosservice", "call", "/spidar/driver/recover"], env=self.environment, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, timeout=PATIENCE, check=False)
        return self.boards.drive() == "on"

    def close(self):
        for process in self.started:
            if process.poll() is None:
                process.kill()
            process.wait(PATIENCE)
        self.boards.close()


def stop_time():
    """Milliseconds from the start of spidar_stop to no current, while the master is dead."""
    with tempfile.TemporaryDirectory() as folder:
        device = Device(folder)
        try:
            device.master.kill()
            device.master.wait(PATIENCE)
            start = time.monotonic()
            stop = device.start(program("spidar_driver", "spidar_stop"))
            while device.boards.drive() != "off" and time.monotonic() < start + PATIENCE:
                pass
            took = 1e3 * (time.monotonic() - start)
            return took if stop.wait(PATIENCE) == 0 else float("inf")
        finally:
            device.close()


def hangup_time():
    """Milliseconds from SIGHUP to roslaunch to no current, the loop running on emulated boards."""
    with tempfile.TemporaryDirectory() as folder:
        boards, mark = EmulatedBoards("spidar_g6x5r"), f"{os.getpid()}-{time.monotonic_ns()}"
        environment = dict(os.environ, ROS_IP="127.0.0.1", HAPTIC_STOP_FOLDER=folder, HAPTIC_TEST_CALL=mark)
        parent = subprocess.Popen(["roslaunch", "-p", str(free_port()), "haptic_bringup", "demo.launch", "rviz:=false",
                                   "device:=spidar_g6x5r", "transport:=file", f"port:={boards.port}"], env=environment,
                                  stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                  start_new_session=True, preexec_fn=heed_signals)
        try:
            wait_until("current", lambda: os.listdir(folder) and boards.drive() == "on", PATIENCE)
            time.sleep(1)
            assert boards.drive() == "on"
            start = time.monotonic()
            parent.send_signal(signal.SIGHUP)
            while boards.drive() != "off" and time.monotonic() < start + PATIENCE:
                pass
            took = 1e3 * (time.monotonic() - start)
            parent.wait(PATIENCE)
            return took
        finally:
            for pid in descendants("HAPTIC_TEST_CALL=" + mark):
                os.kill(pid, signal.SIGKILL)
            boards.close()


def heed_signals():
    for each in SIGNALS[:-1]:
        signal.signal(each, signal.SIG_DFL)


def left_by(words, how):
    """Processes of a run that are left a second after its parent has ended by this signal."""
    mark = f"{os.getpid()}-{time.monotonic_ns()}"
    with tempfile.TemporaryDirectory() as folder:
        environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "ROS_MASTER_URI")}
        environment.update(HAPTIC_TEST_CALL=mark, HAPTIC_STOP_FOLDER=folder, ROS_IP="127.0.0.1")
        # A shell that runs this in the background has it ignore SIGINT and SIGQUIT, and a shell below cannot undo that.
        parent = subprocess.Popen(words, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, start_new_session=True, preexec_fn=heed_signals)
        try:
            wait_until("a device that listens", lambda: os.listdir(folder), PATIENCE)
            time.sleep(3)  # the loop runs by then
            parent.send_signal(how)
            parent.wait(PATIENCE)
            time.sleep(1)
        finally:
            left = descendants("HAPTIC_TEST_CALL=" + mark)
            for pid in left:
                try:
                    with open(f"/proc/{pid}/cmdline", encoding="utf-8") as line:
                        print(f"# left by {how.name}: {line.read().replace(chr(0), ' ')[:120]}")
                    os.kill(pid, signal.SIGKILL)
                except OSError:
                    pass  # it has ended since
        return len(left)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--rounds", type=int, default=20)
    rounds = arguments.parse_args().rounds
    times = [stop_time() for _ in range(rounds)]
    print("# STOP [ms]: " + " ".join(f"{t:.1f}" for t in sorted(times)))
    figure("stop.without_master_ms", max(times), "ms")
    hangups = [hangup_time() for _ in range(rounds)]
    print("# SIGHUP [ms]: " + " ".join(f"{t:.1f}" for t in sorted(hangups)))
    figure("hangup.zero_ms_max", max(hangups), "ms")
    left = 0
    for how in SIGNALS:
        of_demo = left_by([RUN, "demo", "--device", "uart", "--seconds", "600"], how)
        of_launch = left_by(["roslaunch", "-p", str(free_port()), "haptic_bringup", "demo.launch", "rviz:=false"], how)
        print(f"# {how.name}: {of_demo} left by ./run demo, {of_launch} by roslaunch", flush=True)
        left += of_demo + of_launch
    figure("orphans.left", left, "1")
    return 0 if left == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
