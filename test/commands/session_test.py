#!/usr/bin/python3
"""./run report BAG and ./run export BAG: columns against the topics of the same bag, the page as a reader sees it, bad bags."""
import gzip
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

from run_verb import ROOT, Call

sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
sys.path.insert(0, os.path.join(ROOT, "penalty_sim", "session"))
import numpy as np  # noqa: E402
import rosbag  # noqa: E402
import session_data  # noqa: E402
import session_page  # noqa: E402
import session_series  # noqa: E402
from std_msgs.msg import String  # noqa: E402

SECONDS, RATE = 2, 1000


class Arithmetic(unittest.TestCase):
    def test_spells_begin_and_end_where_the_mask_changes(self):
        mask = np.array([1, 1, 0, 0, 1, 0, 1], dtype=bool)
        self.assertEqual(session_data.spells_of(mask, np.arange(7.0), 1.0), [(0, 2), (4, 5), (6, 7)])
        self.assertEqual(session_data.spells_of(mask[2:4], np.arange(2.0), 1.0), [])

    def test_packed_series_come_back_within_half_a_step(self):
        import base64
        import zlib
        values = np.concatenate([np.random.default_rng(1).normal(size=999) * 7, [np.nan]])
        for per_bin in (1, 3):
            packed = session_series.Packed(len(values), per_bin)
            packed.add(values)
            least, step = packed.ranges[0]
            planes = np.frombuffer(zlib.decompress(base64.b64decode(packed.text())), dtype=np.uint8).reshape(-1, packed.points)
            changes = planes[0::2].astype(np.int32) | planes[1::2].astype(np.int32) << 8
            levels = np.cumsum(changes, axis=1).astype(np.int16)
            back = np.where(levels == session_series.HOLE, np.nan, least + step * (levels + 32767.0))
            bins = np.concatenate([values, np.full(-len(values) % per_bin, np.nan)]).reshape(-1, per_bin)
            for row, oracle in zip(back, (np.fmin, np.fmax)):
                # half a step of rounding, and the rounding of the sum itself
                np.testing.assert_allclose(row, oracle.reduce(bins, axis=1), atol=0.5 * step * (1 + 1e-9), rtol=0)

    def test_lanes_with_too_many_spells_keep_their_ends_and_what_is_long(self):
        count = 4 * session_page.LANE_SPELLS
        short = [(0.001 * i, 0.001 * (i + 1), "stick" if i % 2 else "slip") for i in range(count)]
        end = short[-1][1]
        merged = session_page.merged(short + [(end, end + 10, "stick")], end + 10)
        self.assertLessEqual(len(merged), session_page.LANE_SPELLS + 2)
        self.assertEqual((merged[0][0], merged[-1]), (0, (end, end + 10, "stick")))
        self.assertTrue(all(a[1] == b[0] for a, b in zip(merged, merged[1:])), "nothing is left out")
        self.assertIn("turn", {kind for _, _, kind in merged})
        self.assertEqual(session_page.merged(short[:10], 1.0), short[:10])

    def test_rotation_vectors(self):
        angles = np.array([0, 1e-9, 0.4, 3.0])
        table = {f"q_{a}": v for a, v in zip("xyzw", [np.sin(angles / 2), 0 * angles, 0 * angles, np.cos(angles / 2)])}
        for sign in (1, -1):  # both quaternions of a rotation
            vectors = session_page.rotation_vectors({k: sign * v for k, v in table.items()}, "q")
            np.testing.assert_allclose(vectors[:, 0], angles, rtol=1e-12)

    def test_names_are_those_of_the_header(self):
        header = ""
        for name in ("spidar.h", "device_diagnosis.h"):
            with open(os.path.join(ROOT, "src", "haptic_core", "spidar", name), encoding="utf-8") as file:
                header += file.read()
        flags = re.findall(r"^  k(\w+) = 1u << (\d+)", header, re.M)
        self.assertEqual([name for name, bit in sorted(flags, key=lambda f: int(f[1]))], list(session_data.FLAGS))
        self.assertEqual([int(bit) for _, bit in flags], list(range(len(flags))))
        states = re.findall(r"^  k(\w+),", header[header.index("enum class DeviceState"):header.index("const char* toString")], re.M)
        self.assertEqual([name.upper() for name in states], list(session_data.STATES[:len(states)]))
        self.assertLessEqual(session_data.FAULTS | set(session_data.FLAG_WORDS), set(session_data.FLAGS))


class Recorded(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.bag = os.path.join(cls.folder, "session.bag")
        for _ in range(3):  # ticks are all recorded; a busy machine may connect the recorder to topics when the demo is over
            if os.path.exists(cls.bag):
                os.remove(cls.bag)
            call = Call("demo", "--seconds", str(SECONDS), "--record", cls.bag)
            assert call.code == 0, call.errors
            with rosbag.Bag(cls.bag) as bag:
                counts = [bag.get_message_count("/spidar/" + name) for name in ("pose", "wrench", "twist")]
            if min(counts) > SECONDS * 100:
                break
        cls.page = Call("report", cls.bag)
        assert cls.page.code == 0, cls.page.errors
        cls.export = Call("export", cls.bag, "--csv", "--npz", "--session")
        assert cls.export.code == 0, cls.export.errors
        cls.columns = np.load(os.path.join(cls.folder, "session.npz"))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def test_every_tick_has_a_row_and_every_row_the_same_bits(self):
        np.testing.assert_array_equal(self.columns["tick"], np.arange(SECONDS * RATE))
        np.testing.assert_array_equal(self.columns["same_bits"], 1)
        self.assertEqual(self.export.figures()["session.rows"], SECONDS * RATE)

    def test_poses_and_forces_are_those_of_the_topics(self):
        rows = {name: set(zip(*(self.columns[f"spidar.{column}_{axis}"] for axis in "xyz")))
                for name, column in (("pose", "position"), ("wrench", "achieved_force"), ("twist", "linear"))}
        with rosbag.Bag(self.bag) as bag:
            seen = {name: 0 for name in rows}
            for topic, message, _ in bag.read_messages(["/spidar/" + name for name in rows]):
                name = topic.split("/")[-1]
                vector = {"pose": lambda m: m.pose.position, "wrench": lambda m: m.wrench.force, "twist": lambda m: m.twist.linear}[name](message)
                self.assertIn((vector.x, vector.y, vector.z), rows[name])
                seen[name] += 1
        self.assertGreater(min(seen.values()), SECONDS * 100)

    def test_contacts_are_those_of_the_topic(self):
        touched = 0
        with rosbag.Bag(self.bag) as bag:
            for _, message, _ in bag.read_messages("/contacts"):
                row = int(message.step) - 1
                if not 0 <= row < SECONDS * RATE:
                    continue
                mine = [c for c in message.contacts if "pointer" in (c.link_a, c.link_b)]
                state = 0 if not mine else 1 if all(c.sticking for c in mine) else 2
                self.assertEqual(self.columns["spidar.contact"][row], state)
                self.assertEqual(self.columns["spidar.contact_force"][row], sum(c.normal_force for c in mine))
                touched += bool(mine)
        self.assertGreater(touched, 0, "the hand of touch_cube presses within two seconds")

    def test_spells_add_up_to_the_ticks_in_contact(self):
        mine = ["pointer" in pair for pair in zip(self.columns["contacts.link_a"], self.columns["contacts.link_b"])]
        lasted = self.columns["contacts.end"] - self.columns["contacts.begin"]
        self.assertAlmostEqual(lasted[mine].sum() * RATE, (self.columns["spidar.contact"] > 0).sum(), places=6)

    def test_clock_is_that_of_the_topics(self):
        with rosbag.Bag(self.bag) as bag:
            stamps = [m.header.stamp.to_sec() for _, m, _ in bag.read_messages("/spidar/pose")]
        # A message is made within some milliseconds of its tick; a machine that does something else may take longer.
        self.assertLess(abs(self.columns["unix_time"][-1] - stamps[-1]), 1.0)
        self.assertGreater(np.diff(self.columns["unix_time"]).min(), -0.1)

    def test_csv_says_the_same(self):
        table = np.genfromtxt(os.path.join(self.folder, "session.csv"), delimiter=",", names=True, deletechars="")
        self.assertEqual(len(table), SECONDS * RATE)
        for name in table.dtype.names:
            np.testing.assert_allclose(table[name], self.columns[name], rtol=1e-8, atol=1e-300, err_msg=name)

    def test_a_scene_of_many_bodies(self):
        bag = os.path.join(self.folder, "many.bag")
        self.assertEqual(Call("demo", "--scene", "workshop", "--seconds", "0.2", "--record", bag).code, 0)
        call = Call("report", bag)
        self.assertEqual(call.code, 0, call.errors)
        self.assertEqual(call.figures()["session.ticks"], 200)

    def test_a_file_for_the_browser_holds_every_tick(self):
        with gzip.open(os.path.join(self.folder, "session.session")) as file:
            raw = file.read()
        self.assertTrue(raw.startswith(b"haptic session, packed: "))
        for tick in (SECONDS * RATE // 2, SECONDS * RATE - 1):
            self.assertTrue(struct.pack("<Q", tick) in raw, tick)

    def test_the_page_is_small_and_asks_for_nothing(self):
        with open(os.path.join(self.folder, "session.html"), encoding="utf-8") as file:
            page = file.read()
        program = re.search(r'<script type="text/plain" id="view3d">([^<]*)</script>', page)  # of the 3-D view, the same in every page
        self.assertLess(len(page) - (len(program.group(1)) if program else 0), 3e6 * SECONDS / 60 + 1e5)
        self.assertEqual(re.findall(r"(?:src|href)\s*=|url\(|fetch\(|https?://", page), [])

    def test_headless_chromium_draws_zooms_and_turns_dark(self):
        probe = """<script>const probe = async () => {
          const session = window.sessions[0], rgb = hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16));
          const near = (canvas, hex) => { const d = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data, c = rgb(hex);
            let n = 0; for (let i = 0; i < d.length; i += 4) n += Math.abs(d[i] - c[0]) + Math.abs(d[i + 1] - c[1]) + Math.abs(d[i + 2] - c[2]) < 90;
            return n; };
          const panes = () => session.panes.filter(p => p.traces).map(p => { p.visible = true; p.traces.forEach((t, i) => { t.shown = i === 0; });
            p.draw(); return near(p.canvas, colour('c' + p.traces[0].style)); });
          const seen = {panes: panes(), paper: getComputedStyle(document.body).backgroundColor};
          const late = 0.75 * session.duration; // a busy machine's recorder hears of statistics late
          session.view(late, late + 0.1); seen.zoomed = panes(); seen.span = session.t1 - session.t0;
          document.getElementById('theme').click(); seen.other = getComputedStyle(document.body).backgroundColor; seen.dark = panes();
          seen.width = document.documentElement.scrollWidth - innerWidth; document.title = JSON.stringify(seen); };
          // The panes are unpacked in real time, of which a busy machine needs more than the page's clock shows.
          const wait = () => ((window.sessions ?? [])[0]?.panes?.filter(p => p.traces).length > 10 ? setTimeout(probe, 500) : setTimeout(wait, 20));
          wait();</script>"""
        with open(os.path.join(self.folder, "session.html"), encoding="utf-8") as file:
            page = file.read()
        copy = os.path.join(self.folder, "probe.html")
        with open(copy, "w", encoding="utf-8") as file:
            file.write(page.replace("</body>", probe + "</body>"))
        for width in (1300, 700):
            done = subprocess.run(["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                                   f"--window-size={width},900", "--user-data-dir=" + os.path.join(self.folder, "profile"),
                                   "--virtual-time-budget=600000", "--dump-dom", "file://" + copy],
                                  capture_output=True, text=True, timeout=120, check=False)
            title = re.search(r"<title>(\{.*?\})</title>", done.stdout, re.S)
            self.assertIsNotNone(title, done.stderr[-1000:] + done.stdout[:500])
            seen = json.loads(title.group(1).replace("&quot;", '"'))
            for state in ("panes", "zoomed", "dark"):
                self.assertGreater(len(seen[state]), 10)
                # a line across the plot, less where a dashed one has gaps and a steep one is thin
                self.assertGreater(min(seen[state]), 100, f"a trace is not drawn: {state} {seen[state]}")
            self.assertEqual({seen["paper"], seen["other"]}, {"rgb(255, 255, 255)", "rgb(20, 25, 30)"})
            self.assertAlmostEqual(seen["span"], 0.1, places=9)
            self.assertLessEqual(seen["width"], 0, "the page must not scroll sideways")

    def refuse(self, *words, bag, verbs=(("report",), ("export",), ("export", "--session"))):
        for verb, *options in verbs:
            call = Call(verb, bag, *options)
            self.assertNotEqual(call.code, 0, call.out)
            self.assertEqual(len(call.errors), 1, call.errors)
            for word in words:
                self.assertIn(word, call.errors[0])
            self.assertEqual(call.figures(), {})

    def test_bad_bags_get_one_line(self):
        path = os.path.join(self.folder, "bad.bag")
        self.refuse("none.bag", "no such file", bag=os.path.join(self.folder, "none.bag"))
        exports = (("export", "--session"), ("export", "--mcap"))  # ./run report takes what has no such ending for a scene
        self.refuse(self.folder, "folder", bag=self.folder, verbs=exports)
        self.refuse("session.session", "bag", bag=os.path.join(self.folder, "session.session"), verbs=exports)
        self.refuse("none.bag", "no such file", bag=os.path.join(self.folder, "none.bag"), verbs=exports)
        with open(path, "w", encoding="utf-8") as file:
            file.write("no bag")
        self.refuse("bad.bag", bag=path)
        with rosbag.Bag(path, "w"):
            pass
        self.refuse("bad.bag", "no encoder counts", bag=path)
        with rosbag.Bag(path, "w") as bag:
            bag.write("/chatter", String("hello"))
        self.refuse("bad.bag", "no encoder counts", bag=path)
        shutil.copy(self.bag, path)
        os.truncate(path, 6000)
        self.refuse("bad.bag", "before its first tick", bag=path)
        call = Call("report", self.bag, "--output", "/no/such/folder/a.html")
        self.assertNotEqual(call.code, 0)
        self.assertIn("/no/such/folder/a.html", call.errors[0])


if __name__ == "__main__":
    unittest.main()
