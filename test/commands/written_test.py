#!/usr/bin/python3
"""A verb says that it has written something only where it has: full disks, places that cannot be written, what is removed meanwhile,
names of every kind, two runs at once. HAPTIC_FIGURES: a file for the figure success.claimed_falsely."""
import csv
import os
import subprocess
import tempfile
import threading
import unittest

from run_verb import ROOT, Call

SECONDS = 1
RATE = 1000
NAMES = ["Mein Ordner's \"quoted\" Übung €/größe 触覚 a'b $(arg scene) $HOME `x` ; # &.bag", "-O/--x.bag"]


class Small:
    """A file system of so many bytes; `why_not` says why there is none."""

    def __init__(self, size):
        self.folder = tempfile.mkdtemp()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", self.folder], capture_output=True, text=True, check=False)
        self.why_not = done.stderr.strip()

    def remove(self):
        subprocess.run(["umount", "-l", self.folder], capture_output=True, check=False)
        os.rmdir(self.folder)


class Written(unittest.TestCase):
    claimed_falsely = 0
    cases = 0

    @classmethod
    def tearDownClass(cls):
        if "HAPTIC_FIGURES" in os.environ:
            with open(os.environ["HAPTIC_FIGURES"], "a", encoding="utf-8") as figures:
                figures.write(f"figure success.claimed_falsely {cls.claimed_falsely} of {cls.cases}\n")

    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = place.name

    def small(self, size):
        small = Small(size)
        self.addCleanup(small.remove)
        if small.why_not:
            self.skipTest(f"no file system of its own here: {small.why_not}")
        return small.folder

    def honest(self, call, written, *words):
        """The verb failed with one line that has these words, or it has written."""
        type(self).cases += 1
        type(self).claimed_falsely += call.code == 0 and not written
        self.assertEqual(call.code == 0, written, (call.out, call.errors))
        self.assertEqual(call.left, [])
        if not written:
            self.assertEqual(len(call.errors), 1, call.errors)
            self.assertNotIn("recorded", call.out)
            for word in words:
                self.assertIn(word, call.errors[0])

    def record(self, path):
        return Call("demo", "--seconds", str(SECONDS), "--record", path)

    def test_names_of_every_kind(self):
        for name in NAMES:
            path = os.path.join(self.folder, name)
            os.makedirs(os.path.dirname(path))
            call = self.record(path)
            self.honest(call, True)
            self.assertIn(path, call.out)
            found = [os.path.join(at, file) for at, _, files in os.walk(self.folder) for file in files]
            self.assertEqual(found, [path])
            os.remove(path)

    def test_a_disk_that_is_full(self):
        self.honest(self.record(os.path.join(self.small("512k"), "a.bag")), False, "a.bag", "disk")

    def test_places_that_cannot_be_written(self):
        self.honest(self.record("/proc/a.bag"), False, "/proc/a.bag", "cannot be written")
        self.honest(self.record(os.path.join(self.folder, "none", "a.bag")), False, "no such folder")
        os.mkdir(os.path.join(self.folder, "is.bag"))
        self.honest(self.record(os.path.join(self.folder, "is.bag")), False, "is a folder")

    def test_a_bag_that_is_removed_meanwhile(self):
        path = os.path.join(self.folder, "gone.bag")
        with open(path, "w", encoding="utf-8") as bag:
            bag.write("of an earlier run")  # which must not be taken for this one's
        stop = threading.Event()

        def remove():
            while not stop.wait(0.02):
                if os.path.exists(path + ".active"):
                    os.remove(path + ".active")

        remover = threading.Thread(target=remove)
        remover.start()
        call = self.record(path)
        stop.set()
        remover.join()
        self.honest(call, False, "gone.bag")

    def test_columns_and_pages(self):
        bag = os.path.join(self.folder, "a b.bag")
        self.honest(self.record(bag), True)
        place = os.path.join(self.folder, "Übung €")
        os.mkdir(place)
        self.honest(Call("export", bag, "--csv", "--npz", "--output", os.path.join(place, "c d")), True)
        with open(os.path.join(place, "c d.csv"), encoding="utf-8") as table:
            self.assertEqual(sum(1 for _ in csv.reader(table)), SECONDS * RATE + 1)
        full = self.small("16k")
        for verb in (("export", bag, "--csv", "--output"), ("export", bag, "--npz", "--output"), ("report", bag, "--output")):
            self.honest(Call(*verb, os.path.join(full, "x")), False, "cannot be written")
            for file in os.listdir(full):
                os.remove(os.path.join(full, file))

    def test_two_runs_at_once_have_their_own_figures(self):
        calls = {}

        def run(seconds):
            calls[seconds] = Call("demo", "--seconds", str(seconds))

        threads = [threading.Thread(target=run, args=(seconds,)) for seconds in (1, 2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for seconds, call in calls.items():
            type(self).cases += 1
            wrong = call.code == 0 and call.figures().get("demo.ticks") != seconds * RATE
            type(self).claimed_falsely += wrong
            self.assertEqual(call.code, 0, call.errors)
            self.assertEqual(call.figures()["demo.ticks"], seconds * RATE)
        with open(os.path.join(ROOT, "build", "figures", "demo.csv"), encoding="utf-8") as table:
            rows = [row for row in csv.DictReader(table) if row["name"] == "demo.ticks"]
        self.assertEqual(len(rows), 1)


if __name__ == "__main__":
    unittest.main()
