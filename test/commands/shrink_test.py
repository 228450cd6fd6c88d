#!/usr/bin/python3
"""./run shrink: seeded faults are reduced, are still shown, and replay bit for bit; what shows none is refused.

With --seeded N, of `./run bench workbench`: N faults seeded in recordings of several scenes, as figures."""
import math
import os
import random
import shutil
import sys
import tempfile
import unittest

from replay_test import rewrite
from run_verb import Call

import rosbag  # noqa: E402 (replay_test has set the path)

SECONDS = 2


def at_tick(tick, change):
    """A change of one recorded tick: `change(message, its index in the message)`."""
    def changed(topic, message):
        if topic.endswith("recorded/ticks") and message.first_tick <= tick < message.first_tick + message.ticks:
            change(message, tick - message.first_tick)
        return message
    return changed


def with_item(name, index, value):
    def change(message, i):
        values = list(getattr(message, name))
        values[index(message, i)] = value(values[index(message, i)])
        setattr(message, name, values)
    return change


def jump(string, counts):
    return with_item("counts", lambda m, i: i * m.channels + string, lambda count: count + counts)


def silent(message, i):
    status = list(message.link_status)
    status[i * message.hands] = status[i * message.hands] & 0xf0 | 2
    message.link_status = status


def lost(periods):
    return with_item("lost_periods", lambda m, i: i, lambda _: periods)


def flipped(message, i):
    hashes = list(message.world_hash)
    hashes[i] ^= 1
    message.world_hash = hashes


# Name for --fault, and what seeds it: a count that jumps, a board that does not answer, a late loop, a hash of another bit.
SEEDS = {"CountRefused": lambda r: jump(r.randrange(8), r.choice((-1, 1)) * r.randrange(3000, 9000)), "SampleStale": lambda _: silent,
         "late": lambda r: lost(r.randrange(2, 9)), "difference": lambda _: flipped}


def ticks_of(bag):
    with rosbag.Bag(bag) as read:
        return [m for t, m, _ in read.read_messages() if t.endswith("recorded/ticks")]


class Shrink(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.bag = os.path.join(cls.folder, "blocks.bag")
        call = Call("demo", "--scene", "blocks", "--seconds", str(SECONDS), "--record", cls.bag)
        assert call.code == 0, call.errors

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def shrunk(self, bag, *words):
        out = os.path.join(self.folder, "out.bag")
        call = Call("shrink", bag, "--output", out, *words)
        self.assertEqual(call.code, 0, call.errors)
        self.assertLess(call.figures()["shrink.ratio"], 0.02, call.out)
        self.assertLess(os.path.getsize(out), 40e3, "a few kilobytes")
        return out, call

    def test_seeded_faults_are_found_in_one_tick_or_two(self):
        for name, seed in SEEDS.items():
            with self.subTest(name):
                target = os.path.join(self.folder, name + ".bag")
                rewrite(self.bag, target, at_tick(1200, seed(random.Random(1))))
                out, call = self.shrunk(target, "--fault", name)
                again = Call("replay", out)
                self.assertLessEqual(again.figures()["replay.steps"], 2)
                self.assertEqual(again.code, int(name == "difference"), again.errors)
                self.assertEqual(again.figures()["replay.mismatches"], int(name == "difference"))
                if name == "difference":
                    self.assertIn("first difference: tick 1200", again.out)

    def test_a_command_of_ones_own(self):
        """The fault is a tick in which a grip button is down, which nothing but the recording knows."""
        def press(message, i):
            buttons = list(message.buttons)
            buttons[i * message.hands] = 4
            message.buttons = buttons
        target, check = os.path.join(self.folder, "button.bag"), os.path.join(self.folder, "check.py")
        rewrite(self.bag, target, at_tick(777, press))
        with open(check, "w", encoding="utf-8") as file:
            file.write("import sys, rosbag\n"
                       "ticks = [m for t, m, _ in rosbag.Bag(sys.argv[1]).read_messages() if t.endswith('recorded/ticks')]\n"
                       "sys.exit(not any(4 in m.buttons for m in ticks))\n")
        out, _ = self.shrunk(target, "--test", f"{sys.executable} -B {check}")
        self.assertEqual([m.first_tick for m in ticks_of(out)], [777])

    def refused(self, *words):
        call = Call("shrink", *words)
        self.assertNotEqual(call.code, 0)
        self.assertEqual(len(call.errors), 1, call.errors)
        return call.errors[0]

    def test_what_shows_no_such_fault_is_refused_in_one_line(self):
        self.assertIn("does not show this fault", self.refused(self.bag, "--fault", "Runaway"))
        self.assertIn("there are: stopped", self.refused(self.bag, "--fault", "Nonsense"))
        self.assertIn("cannot be run", self.refused(self.bag, "--test", os.path.join(self.folder, "none")))
        self.assertIn("does not show this fault", self.refused(self.bag, "--test", "false"))
        self.assertIn("name another file", self.refused(self.bag, "--output", self.bag))
        self.assertEqual([], [name for name in os.listdir(self.folder) if "attempt" in name], "nothing is left behind")


def seeded(count):
    """Figures of faults seeded at random ticks of recordings of several scenes."""
    ratios, minutes = [], []
    scenes = ("touch_cube", "blocks", "door", "conveyor", "c_bin")
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            scene, (name, seed) = scenes[number // len(SEEDS) % len(scenes)], list(SEEDS.items())[number % len(SEEDS)]
            bag, altered = os.path.join(folder, scene + ".bag"), os.path.join(folder, "altered.bag")
            if not os.path.exists(bag):
                Call("demo", "--scene", scene, "--seconds", "5", "--record", bag)
            choice = random.Random(number)
            tick = choice.randrange(500, 4500)
            rewrite(bag, altered, at_tick(tick, seed(choice)))
            call = Call("shrink", altered, "--fault", name, "--output", os.path.join(folder, "out.bag"), limit=600)
            told = [line for line in call.out.splitlines() if "bodies" in line]
            print(f"{scene}, {name} at tick {tick}: {told[0] if told else call.errors}", flush=True)
            ratios.append(call.figures().get("shrink.ratio", 1.0))
            minutes.append(call.figures().get("shrink.minutes", math.inf))
    print(f"figure shrink.ratio {math.exp(sum(map(math.log, ratios)) / count):.3g} 1")
    print(f"figure shrink.minutes_max {max(minutes):.3g} min")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--seeded"]:
        seeded(int(sys.argv[2]))
    else:
        unittest.main()
