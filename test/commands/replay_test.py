#!/usr/bin/python3
"""./run demo --record and ./run replay: the same bits again, a difference is told where it begins, bad bags are refused."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from run_verb import ROOT, Call

sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
import rosbag  # noqa: E402

SECONDS, RATE = 2, 1000
# Contacts, friction and joints: a pressed cube, and a door on its hinge.
SCENES = ["touch_cube", "door"]


def rewrite(source, target, change):
    """Copies a bag; `change(topic, message)` may alter a message, or return None to leave it out."""
    with rosbag.Bag(target, "w") as out, rosbag.Bag(source) as bag:
        for topic, message, stamp in bag.read_messages():
            changed = change(topic, message)
            if changed is not None:
                out.write(topic, changed, stamp)


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.bags = {}
        for scene in SCENES:
            bag = os.path.join(cls.folder, scene + ".bag")
            call = Call("demo", "--scene", scene, "--seconds", str(SECONDS), "--record", bag)
            assert call.code == 0, call.errors
            cls.bags[scene] = bag

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @staticmethod
    def session(**values):
        """A change of a recording's session message."""
        def change(topic, message):
            if topic.endswith("recorded/session"):
                for key, value in values.items():
                    setattr(message, key, value)
            return message
        return change

    def altered(self, change, scene="touch_cube"):
        target = os.path.join(self.folder, "altered.bag")
        rewrite(self.bags[scene], target, change)
        return target

    def refuse(self, bag, *words):
        call = Call("replay", bag)
        self.assertNotEqual(call.code, 0, call.out)
        self.assertEqual(len(call.errors), 1, call.errors)
        for word in words:
            self.assertIn(word, call.errors[0])
        self.assertNotIn("replay.mismatches", call.figures())

    def test_same_bits(self):
        for scene, bag in self.bags.items():
            call = Call("replay", bag)
            self.assertEqual(call.code, 0, call.errors + [call.out])
            figures = call.figures()
            self.assertEqual(figures["replay.steps"], SECONDS * RATE, scene)
            self.assertEqual(figures["replay.mismatches"], 0, scene)
            self.assertIn("replay.speedup", figures, scene)

    def test_contains_counts_and_hashes_of_every_tick(self):
        with rosbag.Bag(self.bags["touch_cube"]) as bag:
            runs = [m for _, m, _ in bag.read_messages("/recorded/ticks")]
        self.assertEqual(sum(m.ticks for m in runs), SECONDS * RATE)
        self.assertTrue(all(len(m.counts) == m.ticks * m.channels and m.channels == 8 for m in runs))
        hashes = [h for m in runs for h in m.world_hash]
        self.assertEqual(len(set(hashes)), len(hashes), "every step changes the state")

    def test_one_count_is_found(self):
        def change(topic, message):
            if topic.endswith("recorded/ticks") and message.first_tick <= 700 < message.first_tick + message.ticks:
                counts = list(message.counts)
                counts[(700 - message.first_tick) * message.channels + 2] += 40
                message.counts = counts
            return message

        call = Call("replay", self.altered(change))
        self.assertEqual(call.code, 1, call.errors)
        self.assertGreater(call.figures()["replay.mismatches"], 0)
        self.assertIn("first difference: tick 700, link pointer", call.out)

    def test_another_build_is_replayed_and_judged_by_no_bit(self):
        def another_hash(topic, message):
            message = self.session(build="c++ 4.8", scene_fingerprint=1, world_hash=1)(topic, message)
            if topic.endswith("recorded/ticks"):
                message.world_hash = [1] * len(message.world_hash)
            return message

        for change in (self.session(program="haptic_core 0.0.1"), self.session(build="c++ 4.8"), another_hash):
            call = Call("replay", self.altered(change))
            self.assertEqual(call.code, 0, call.errors)
            self.assertRegex(call.out, r"recorded by .*(haptic_core 0\.0\.1|c\+\+ 4\.8).* another build's")
            self.assertEqual(call.figures()["replay.steps"], 1000 * SECONDS)
        self.assertGreater(call.figures()["replay.mismatches"], 0)

    def test_bad_bags(self):
        def without(end):
            return lambda topic, message: None if topic.endswith(end) else message

        def gap(topic, message):
            return None if topic.endswith("recorded/ticks") and 300 <= message.first_tick < 400 else message

        self.refuse(self.altered(without("recorded/ticks")), "no encoder counts")
        self.refuse(self.altered(without("recorded/session")), "no encoder counts")
        self.refuse(self.altered(self.session(version=99)), "format 99")
        self.refuse(self.altered(self.session(scene_text="<robot name='other'><link name='world'/></robot>")), "touch_cube")
        self.refuse(self.altered(gap), "missing")
        with rosbag.Bag(self.bags["door"]) as bag:
            other = next(m for t, m, _ in bag.read_messages() if t.endswith("recorded/session"))
        self.refuse(self.altered(self.session(scene_file=other.scene_file, scene_text=other.scene_text)), "not the one")

    def test_files_that_are_no_complete_bag(self):
        cut = os.path.join(self.folder, "cut.bag")
        shutil.copy(self.bags["touch_cube"], cut)
        os.truncate(cut, 6000)
        self.refuse(cut, "cut.bag", "before its first tick")
        text = os.path.join(self.folder, "text.bag")
        with open(text, "w", encoding="utf-8") as out:
            out.write("no bag")
        self.refuse(text, "text.bag")
        self.refuse(os.path.join(self.folder, "none.bag"), "none.bag")

    def test_what_a_cut_leaves_is_used_and_said(self):
        whole, size = self.bags["touch_cube"], os.path.getsize(self.bags["touch_cube"])
        for name, share in (("cut.bag", 0.7), ("cut.bag", 0.99), ("touch_cube.bag.active", 0.9)):
            cut = os.path.join(self.folder, name)
            shutil.copy(whole, cut)
            os.truncate(cut, int(share * size))
            before = os.path.getsize(cut)
            call = Call("replay", cut)
            self.assertEqual(call.code, 0, call.errors)
            said = re.search(r"was cut off: (\d+) ticks \(([\d.]+) s\) are used; its (last (\d+) bytes|index)", "\n".join(call.errors))
            self.assertTrue(said, call.errors)
            figures = call.figures()
            self.assertEqual((figures["replay.steps"], figures["replay.mismatches"]), (int(said.group(1)), 0))
            self.assertTrue(0 < figures["replay.steps"] <= 1000 * SECONDS, figures)
            self.assertAlmostEqual(float(said.group(2)), 1e-3 * figures["replay.steps"], delta=1e-3)
            self.assertEqual(os.path.getsize(cut), before, "the recording itself stays as it is")

    def test_standard_tools_read_it(self):
        info = subprocess.run(["rosbag", "info", self.bags["touch_cube"]], capture_output=True, text=True, check=False)
        self.assertEqual(info.returncode, 0, info.stderr)
        for topic in ("/recorded/session", "/recorded/ticks", "/spidar/pose", "/tf"):
            self.assertIn(topic, info.stdout)
        with rosbag.Bag(self.bags["touch_cube"]) as bag:
            topics = bag.get_type_and_topic_info().topics
        self.assertFalse([t for t in topics if t.endswith("wrench_command") and "recorded/" not in t],
                         "a bag that is played must not reach a motor")


if __name__ == "__main__":
    unittest.main()
