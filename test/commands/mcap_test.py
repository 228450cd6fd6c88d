#!/usr/bin/python3
"""MCAP: written and read back, read by the format's own library, while it grows, cut short, damaged, replayed, made of a bag."""
import io
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from run_verb import ROOT, Call

sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
sys.path.insert(0, os.path.join(ROOT, "penalty_sim", "session"))
import genpy  # noqa: E402
import mcap_file  # noqa: E402
import npm_modules  # noqa: E402
import rosbag  # noqa: E402

SECONDS, RATE = 2, 1000


def independently(path):
    """What @mcap/core finds in a file."""
    folder = npm_modules.modules()
    done = subprocess.run(["node", os.path.join(ROOT, "test", "commands", "read_mcap.mjs"), folder, path], capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(done.stderr[-1000:])
    return json.loads(done.stdout)


def written(messages, chunk_bytes=2000):
    """The bytes of a file of (topic, time, data)."""
    kept, mcap_file.CHUNK_BYTES = mcap_file.CHUNK_BYTES, chunk_bytes
    file = io.BytesIO()
    writer = mcap_file.Writer(file, "test")
    for topic, time, data in messages:
        channel = writer.channel(topic, "std_msgs/String", "string data", callerid="/me")
        writer.message(channel, time, time, data)
    writer.close()
    mcap_file.CHUNK_BYTES = kept
    return file.getvalue()


class Format(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.path = os.path.join(self.folder, "a.mcap")
        draw = random.Random(1)
        self.sent = [(draw.choice("/a /b /c".split()), 10**18 + i * 1000, draw.randbytes(draw.randrange(300))) for i in range(300)]
        self.bytes = written(self.sent)

    def tearDown(self):
        shutil.rmtree(self.folder)

    def read(self, content):
        with open(self.path, "wb") as file:
            file.write(content)
        return [(topic, at, bytes(data)) for topic, _, _, _, at, data in mcap_file.messages(self.path)]

    def test_messages_come_back(self):
        self.assertEqual(self.read(self.bytes), self.sent)
        self.assertEqual(next(mcap_file.messages(self.path))[1:4], ("std_msgs/String", "string data", {"callerid": "/me"}))

    def test_a_file_of_any_length_gives_what_is_complete(self):
        seen = set()
        for length in range(len(mcap_file.MAGIC), len(self.bytes), 97):
            got = self.read(self.bytes[:length])
            self.assertEqual(got, self.sent[:len(got)])
            seen.add(len(got))
        self.assertGreater(len(seen), 10, "chunk after chunk")
        self.assertIn(0, seen)
        self.assertIn(len(self.sent), seen)

    def test_damage_is_told(self):
        at = self.bytes.index(b"lz4") + 100
        with self.assertRaisesRegex(mcap_file.Damaged, "damaged"):
            self.read(self.bytes[:at] + bytes([self.bytes[at] ^ 255]) + self.bytes[at + 1:])
        at = self.bytes.index(b"lz4") - 8  # the sum stands before the name of the compression
        with self.assertRaisesRegex(mcap_file.Damaged, "sum over a chunk"):
            self.read(self.bytes[:at] + bytes([self.bytes[at] ^ 255]) + self.bytes[at + 1:])
        with self.assertRaisesRegex(mcap_file.Damaged, "no MCAP"):
            self.read(b"something else")

    def test_no_damage_of_a_byte_is_taken_for_a_short_file(self):
        """What a complete file with one wrong byte gives is all, or an error: never less in silence."""
        draw = random.Random(2)
        end = self.bytes.index(mcap_file.record(mcap_file.DATA_END, b"\0\0\0\0"))  # what follows is the index, which is not read
        for _ in range(400):
            at = draw.randrange(len(mcap_file.MAGIC), end)
            try:
                got = self.read(self.bytes[:at] + bytes([self.bytes[at] ^ 1 << draw.randrange(8)]) + self.bytes[at + 1:])
            except mcap_file.Damaged:
                continue
            self.assertEqual(len(got), len(self.sent), at)

    def test_headers_are_seen(self):
        for text, is_one in (("# a\nstd_msgs/Header header\nint32 a", True), ("Header header", True), ("uint8 A = 1\nHeader header", True),
                             ("int32 a\nHeader header", False), ("", False)):
            self.assertEqual(mcap_file.has_header(text), is_one, text)


class Recorded(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.path = os.path.join(cls.folder, "session.mcap")
        cls.call = Call("demo", "--seconds", str(SECONDS), "--record", cls.path)
        assert cls.call.code == 0, cls.call.errors

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def test_replays_bit_for_bit_and_so_does_a_part(self):
        call = Call("replay", self.path)
        self.assertEqual(call.code, 0, call.errors)
        self.assertEqual((call.figures()["replay.steps"], call.figures()["replay.mismatches"]), (SECONDS * RATE, 0))
        part = os.path.join(self.folder, "part.mcap")
        with open(self.path, "rb") as file, open(part, "wb") as out:
            out.write(file.read(os.path.getsize(self.path) * 3 // 4))
        call = Call("replay", part)
        self.assertEqual(call.code, 0, call.errors)
        self.assertGreater(call.figures()["replay.steps"], 100)
        self.assertLess(call.figures()["replay.steps"], SECONDS * RATE)
        self.assertEqual(call.figures()["replay.mismatches"], 0)
        self.assertIn(f"was cut off: {call.figures()['replay.steps']:.0f} ticks", "".join(call.errors))

    def test_stamps_frames_and_numbers_are_such_as_viewers_want(self):
        classes, seen = {}, set()
        for topic, kind, text, about, at, data in mcap_file.messages(self.path):
            if kind not in classes:
                classes.update(genpy.dynamic.generate_dynamic(kind, text))
            message = classes[kind]().deserialize(bytes(data))
            self.assertEqual(len(about["md5sum"]), 32, topic)
            headers = [message.header] if hasattr(message, "header") else [t.header for t in getattr(message, "transforms", ())]
            for header in headers:
                self.assertLess(abs(header.stamp.to_nsec() - at), 60e9, topic)
            if kind.startswith(("geometry_msgs/", "tf2_msgs/", "visualization_msgs/")):
                self.assertNotRegex(str(message), r"\bnan\b|\binf\b", topic)
                self.assertTrue(all(header.frame_id for header in headers), topic)
                seen.add(kind)
        self.assertGreaterEqual(seen, {"geometry_msgs/PoseStamped", "tf2_msgs/TFMessage", "visualization_msgs/MarkerArray"})

    def test_the_layout_names_what_is_there(self):
        with open(os.path.join(self.folder, "session.layout.json"), encoding="utf-8") as file:
            layout = json.load(file)
        classes = {}
        for topic, kind, text, _, _, data in mcap_file.messages(self.path):
            if topic not in classes:
                classes[topic] = genpy.dynamic.generate_dynamic(kind, text)[kind]().deserialize(bytes(data))
        paths = [path["value"] for panel in layout["configById"].values() for path in panel.get("paths", ())]
        self.assertGreater(len(paths), 8)
        for path in paths:
            topic, *fields = path.split(".")
            value = classes[topic]
            for field in fields:
                value = getattr(value, field)
            self.assertIsInstance(value, (int, float), path)
        for topic in layout["configById"]["3D!scene"]["topics"]:
            self.assertIn(topic, classes)
        panels = re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]))
        self.assertEqual(sorted(panels), sorted(layout["configById"]))

    def test_the_formats_own_library_reads_all_of_it(self):
        try:
            seen = independently(self.path)
        except npm_modules.Unavailable as reason:
            self.skipTest(str(reason))
        mine = [topic for topic, *_ in mcap_file.messages(self.path)]
        self.assertEqual((seen["messages"], seen["told"]), (len(mine), len(mine)))
        self.assertEqual(seen["topics"], {topic: mine.count(topic) for topic in set(mine)})
        self.assertEqual((seen["ticks"], seen["ticksMissing"], seen["lost"], seen["early"]), (SECONDS * RATE, 0, {}, 0))
        self.assertEqual({encoding for _, encoding in seen["schemas"]}, {"ros1msg"})
        self.assertEqual(seen["profile"], "ros1")
        self.assertGreater(seen["chunks"], 1)
        self.assertTrue(0 <= seen["waited"] < 0.5, "a message in the middle is found by its time")

    def test_a_bag_becomes_the_same(self):
        bag = os.path.join(self.folder, "made.bag")
        done = subprocess.run([sys.executable, "-B", os.path.join(ROOT, "penalty_sim", "session", "mcap_bag.py"), self.path, bag], check=False)
        self.assertEqual(done.returncode, 0)
        call = Call("export", bag, "--mcap")
        self.assertEqual(call.code, 0, call.errors)
        with rosbag.Bag(bag) as opened:
            kept = [(topic, raw[0], raw[1], at.to_nsec()) for topic, raw, at in opened.read_messages(raw=True)]
        back = [(topic, kind, bytes(data), at) for topic, kind, _, _, at, data in mcap_file.messages(os.path.join(self.folder, "made.mcap"))]
        self.assertEqual(back, kept)
        self.assertEqual(call.figures()["mcap.messages"], len(kept))

    def test_bad_files_get_one_line(self):
        bad = os.path.join(self.folder, "bad.mcap")
        with open(bad, "wb") as file:
            file.write(mcap_file.MAGIC)
        with open(self.path, "rb") as file:
            whole = file.read()
        first = len(mcap_file.MAGIC)
        longer = whole[:first + 1] + b"\xff" * 6 + whole[first + 7:]  # the length of the first record
        for content, said in ((mcap_file.MAGIC, "before its first tick"), (longer, "file is damaged")):
            with open(bad, "wb") as file:
                file.write(content)
            for verb in ("replay", "report"):
                call = Call(verb, bad)
                self.assertNotEqual(call.code, 0)
                self.assertEqual(len(call.errors), 1, call.errors)
                self.assertIn(said, call.errors[0])
        call = Call("export", self.path, "--mcap")
        self.assertIn("an MCAP file already", "".join(call.errors))
        self.assertNotEqual(call.code, 0)


if __name__ == "__main__":
    unittest.main()
