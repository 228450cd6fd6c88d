#!/usr/bin/python3
"""Saved states, recordings and robots that are damaged: each is refused in one line, within PATIENCE seconds.

    damaged.accepted         files of all three kinds that were not refused so: taken although what they hold differs, more lines than one, a
                             crash, or no end in time
    damaged.tried            how many there were
    damaged.refused_s_max    the longest until a refusal

A state has one bit flipped, a recording has bits flipped, is cut, or has two parts exchanged, a robot has 200 000 attributes. A recording
whose damage touches nothing that a replay reads replays as the sound one does, line by line: it is not counted.
"""
import argparse
import os
import random
import re
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "test", "ros"), os.path.join(ROOT, "test", "commands")]

import rosgraph
from processes import figure, free_port
from topic_probe import program, wait_until

PATIENCE = 5  # [s] for a refusal; a replay of a file that is sound may take longer
STATES, BAGS = 200, 240
WAIT = 60     # [s] for nodes on a busy machine


class Tally:
    def __init__(self):
        self.tried = self.accepted = 0
        self.slowest = 0.0

    def note(self, what, refused, seconds, said):
        self.tried += 1
        self.slowest = max(self.slowest, seconds) if refused else self.slowest
        if not refused or seconds > PATIENCE:
            self.accepted += 1
            print(f"# {what}: {'after' if refused else 'not refused, after'} {seconds:.1f} s: {said[:300]!r}", flush=True)


class Node:
    """A simulation with a master of its own."""

    def __init__(self, folder):
        port = free_port()
        self.environment = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1", HAPTIC_STOP_FOLDER=folder)
        quiet = {"env": self.environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.started = [subprocess.Popen(["rosmaster", "--core", "-p", str(port)], **quiet)]
        wait_until("a master", rosgraph.Master("/bench", self.environment["ROS_MASTER_URI"]).is_online, WAIT)
        self.started.append(subprocess.Popen([program("penalty_sim", "penalty_sim_node"), "__name:=simulation", "_scene:=touch_cube"], **quiet))
        os.environ.update(ROS_MASTER_URI=self.environment["ROS_MASTER_URI"], ROS_IP="127.0.0.1")
        import rospy
        from haptic_msgs.srv import StateFile
        self.calls = [rospy.ServiceProxy(f"/simulation/{name}", StateFile) for name in ("save", "restore")]
        for call in self.calls:
            call.wait_for_service(WAIT)

    def close(self):
        for process in reversed(self.started):
            process.terminate()
        for process in self.started:
            process.wait(WAIT)


def states(tally, folder, choose):
    node = Node(folder)
    try:
        path = os.path.join(folder, "saved.state")
        save, restore = node.calls
        saved = save(path)
        assert saved.success, saved.message
        assert restore(path).success
        with open(path, "rb") as file:
            sound = file.read()
        for _ in range(STATES):
            bit = choose.randrange(8 * len(sound))
            damaged = bytearray(sound)
            damaged[bit // 8] ^= 1 << bit % 8
            with open(path, "wb") as file:
                file.write(damaged)
            begin = time.monotonic()
            answer = restore(path)
            refused = not answer.success and path in answer.message and "\n" not in answer.message
            tally.note(f"state, bit {bit}", refused, time.monotonic() - begin, answer.message)
    finally:
        node.close()


def run(words, limit):
    """(exit code, None: not in time; output; seconds)"""
    begin = time.monotonic()
    try:
        done = subprocess.run(words, capture_output=True, timeout=limit, check=False)
        return done.returncode, (done.stdout + done.stderr).decode(errors="replace"), time.monotonic() - begin
    except subprocess.TimeoutExpired:
        return None, "", time.monotonic() - begin


def told(output):
    """What a replay says, without how fast it was."""
    return re.sub(r"figure replay.speedup.*\n", "", output)


def recording(folder):
    path = os.path.join(folder, "sound.bag")
    words = [os.path.join(ROOT, "run"), "demo", "--scene", "touch_cube", "--seconds", "2", "--record", path]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return path


def damage(sound, choose):
    """(how, bytes)"""
    how, damaged = choose.choice(("bit", "bits", "cut", "exchanged", "head", "index")), bytearray(sound)
    if how in ("bit", "head", "index"):
        first, last = {"bit": (0, len(sound)), "head": (0, 5000), "index": (len(sound) - 3000, len(sound))}[how]
        bit = choose.randrange(8 * max(first, 0), 8 * last)
        damaged[bit // 8] ^= 1 << bit % 8
    elif how == "bits":
        for _ in range(30):
            bit = choose.randrange(8 * len(sound))
            damaged[bit // 8] ^= 1 << bit % 8
    elif how == "cut":
        del damaged[choose.randrange(len(sound)):]
    else:
        at = choose.randrange(len(sound) - 600)
        damaged[at:at + 600] = damaged[at + 300:at + 600] + damaged[at:at + 300]
    return how, damaged


def bags(tally, folder, choose, path):
    replay = program("penalty_sim", "haptic_replay")
    with open(path, "rb") as file:
        sound = file.read()
    code, truth, took = run([replay, path], WAIT)
    assert code == 0, truth
    path = os.path.join(folder, "damaged.bag")
    for i in range(BAGS):
        how, damaged = damage(sound, choose)
        with open(path, "wb") as file:
            file.write(damaged)
        code, output, seconds = run([replay, path], PATIENCE + 10 * took)
        if code == 0 and told(output) == told(truth):
            continue
        # Ticks that come out otherwise are told by the replay: its first difference and its figures.
        differs = code == 1 and "first difference" in output
        lines = output.strip().splitlines()
        refused = differs or (code == 2 and len(lines) == 1 and lines[0].startswith("replay: "))
        tally.note(f"recording {i}, {how}, code {code}", refused, 0 if differs else seconds, output)


def robots(tally, folder):
    path = os.path.join(folder, "attributes.urdf")
    many = " ".join(f'a{i}="1"' for i in range(200000))
    for where in (f'<robot name="r" {many}><link name="a"/></robot>', f'<robot name="r"><link name="a" {many}/></robot>'):
        with open(path, "w", encoding="utf-8") as file:
            file.write('<?xml version="1.0"?>\n' + where)
        code, output, seconds = run([program("penalty_sim", "scene_check"), path], 60)
        lines = [line for line in output.strip().splitlines() if line]
        tally.note(f"robot, code {code}", code not in (0, None) and code > 0 and len(lines) == 1, seconds, output)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--bag", help="a recording that is sound; else one is made")
    bag, tally, choose = arguments.parse_args().bag, Tally(), random.Random(7)
    with tempfile.TemporaryDirectory() as folder:
        bags(tally, folder, choose, bag or recording(folder))
        robots(tally, folder)
        states(tally, folder, choose)
    figure("damaged.accepted", tally.accepted, "1")
    figure("damaged.tried", tally.tried, "1")
    figure("damaged.refused_s_max", tally.slowest, "s")
    return 1 if tally.accepted else 0


if __name__ == "__main__":
    sys.exit(main())
