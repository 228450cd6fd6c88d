#!/usr/bin/python3
"""Programs that are stopped for 5 and for 60 s and go on, as in a debugger or behind a laptop's lid: does force come back by itself?

    suspend.returns     runs in which force was on again within WATCHED s without a call that asks for it
    suspend.runs        runs that were judged: all processes, the loop's manager, the driver, the driver's guard; ROUNDS of each and time
    suspend.not_begun   runs left out because the force was not on when the processes were stopped

Real processes on emulated motor boards, a master each; the four kinds beside each other. The device's own topic is the judge.
"""
import argparse
import csv
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "test", "ros"), os.path.join(ROOT, "test", "commands")]

import rosgraph
from emulated_boards import EmulatedBoards
from guard_test import guards
from processes import figure, free_port, PATIENCE
from run_verb import descendants
from topic_probe import program, wait_until

TIMES = (5, 60)  # [s]
WATCHED = 3.5    # [s]: three states at least; the ramp back takes 0.5 s
RATE = 500       # [Hz]; four loops and their boards share the machine


class Run:
    """A device on emulated boards with what drives it, and a log of its states."""

    def __init__(self, kind):
        self.kind, self.folder = kind, tempfile.TemporaryDirectory()
        self.mark = f"{os.getpid()}-{kind}-{time.monotonic_ns()}"
        port = free_port()
        self.environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1",
                                HAPTIC_STOP_FOLDER=self.folder.name, HAPTIC_TEST_CALL=self.mark)
        self.boards, self.started = EmulatedBoards("spidar_g6x5r"), []
        device = ["device:=spidar_g6x5r", "transport:=file", f"port:={self.boards.port}"]
        if kind in ("driver", "guard"):
            self.start("rosmaster", "--core", "-p", str(port))
            wait_until("a master", rosgraph.Master("/bench", self.environment["ROS_MASTER_URI"]).is_online, PATIENCE)
            self.start(program("spidar_driver", "spidar_driver_node"), "__name:=driver", "__ns:=spidar", f"_rate:={RATE}",
                       *("_" + word for word in device), "_calibrate_at_start:=true", "_enable_force_at_start:=true")
        else:
            self.start("roslaunch", "-p", str(port), "haptic_bringup", "demo.launch", "rviz:=false", f"rate:={RATE}", *device,
                       "at_home:=true")
        wait_until("a device that listens", lambda: os.listdir(self.folder.name), PATIENCE)
        self.log = os.path.join(self.folder.name, "states.csv")
        environment = {name: value for name, value in self.environment.items() if name != "HAPTIC_TEST_CALL"}  # it is never stopped
        with open(self.log, "w", encoding="utf-8") as log:
            self.listener = subprocess.Popen(["rostopic", "echo", "-p", "/spidar/state"], env=environment, stdout=log,
                                             stderr=subprocess.DEVNULL)

    def start(self, *words):
        self.started.append(subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                             start_new_session=True))

    def states(self):
        with open(self.log, encoding="utf-8", newline="") as log:
            return list(csv.DictReader(log))

    def enabled(self):
        states = self.states()
        return bool(states) and states[-1]["field.force_enabled"] == "1"

    def ask_for_force(self):
        for call in (["recover"], ["enable_force", "true"]):
            subprocess.run(["rosservice", "call", "/spidar/driver/" + call[0], *call[1:]], env=self.environment, check=False,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=PATIENCE)

    def guard(self):
        return guards(os.path.realpath(self.boards.port))

    def chosen(self):
        """Processes that are stopped."""
        if self.kind == "all":
            return sorted({*descendants("HAPTIC_TEST_CALL=" + self.mark), *self.guard(), self.boards.process})
        if self.kind == "manager":
            return [pid for pid in descendants("HAPTIC_TEST_CALL=" + self.mark) if b"manager" in command_of(pid)]
        return [self.started[1].pid] if self.kind == "driver" else self.guard()

    def close(self):
        for pid in self.guard():
            os.kill(pid, signal.SIGCONT)
        self.listener.kill()
        for pid in descendants("HAPTIC_TEST_CALL=" + self.mark):
            os.kill(pid, signal.SIGKILL)
        for process in [*self.started, self.listener]:
            process.wait(PATIENCE)
        self.boards.close()
        self.folder.cleanup()


def command_of(pid):
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as line:
            return line.read()
    except OSError:
        return b""


def suspend(run, seconds):
    """Whether force came back by itself; None: it was not on."""
    for _ in range(10):
        if run.enabled() and run.guard():
            break
        run.ask_for_force()
        time.sleep(1.5)
    chosen = run.chosen()
    if not run.enabled() or not chosen:
        return None
    for pid in chosen:
        os.kill(pid, signal.SIGSTOP)
    time.sleep(0.3)
    before = len(run.states())
    time.sleep(seconds - 0.3)
    for pid in chosen:
        try:
            os.kill(pid, signal.SIGCONT)
        except ProcessLookupError:
            pass  # a guard that its driver has replaced
    time.sleep(WATCHED)
    # The first state of all processes together may be one that was on its way when they were stopped.
    after = run.states()[before + (run.kind in ("all", "manager", "driver")):]
    return any(state["field.force_enabled"] == "1" for state in after[1 if run.kind == "guard" else 0:])


def lane(kind, rounds, results):
    run = Run(kind)
    try:
        for seconds in TIMES:
            for _ in range(rounds):
                results.append((kind, seconds, suspend(run, seconds)))
    finally:
        run.close()


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--rounds", type=int, default=20)
    rounds, results = arguments.parse_args().rounds, []
    lanes = [threading.Thread(target=lane, args=(kind, rounds, results)) for kind in ("all", "manager", "driver", "guard")]
    for each in lanes:
        each.start()
    for each in lanes:
        each.join()
    for kind in ("all", "manager", "driver", "guard"):
        for seconds in TIMES:
            of = [back for k, s, back in results if (k, s) == (kind, seconds)]
            print(f"# {kind}, {seconds} s: {len(of)} runs, {of.count(True)} came back, {of.count(None)} not begun", flush=True)
    figure("suspend.returns", sum(back is True for _, _, back in results), "1")
    figure("suspend.runs", sum(back is not None for _, _, back in results), "1")
    figure("suspend.not_begun", sum(back is None for _, _, back in results), "1")
    complete = len(results) == 4 * len(TIMES) * rounds
    return 0 if complete and not any(back for _, _, back in results) else 1


if __name__ == "__main__":
    sys.exit(main())
