#!/usr/bin/python3
"""The 3-D view of a session's page: its numbers against the session's own, and in headless Chromium by events and by pixels."""
import json
import os
import shutil
import sys
import tempfile
import unittest
import zlib

from browser import Browser
from run_verb import ROOT, Call

sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
sys.path.insert(0, os.path.join(ROOT, "penalty_sim", "session"))
import numpy as np  # noqa: E402
import npm_modules  # noqa: E402
import session_data  # noqa: E402
import view_data  # noqa: E402
import view_program  # noqa: E402

SECONDS, RATE = 3, 1000
PROGRAM = os.path.join(ROOT, "build", "devel", "lib", "penalty_sim", "session_table")
VIEW = "window.sessions[0].timeline"


def random_rotations(count, rng):
    q = rng.normal(size=(count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


class Arithmetic(unittest.TestCase):
    def test_whole_numbers_come_back(self):
        rng = np.random.default_rng(1)
        for order in (1, 2):
            for levels in (rng.integers(-10**8, 10**8, 500), np.cumsum(rng.integers(-3, 4, 500)), np.zeros(3, int), np.array([7])):
                np.testing.assert_array_equal(view_data.back(view_data.planes(levels, order), len(levels), order), levels)

    def test_every_point_of_a_body_stays_within_the_error(self):
        """Points on the sphere that a body fills, moved by the pose and by the pose of the page: a second way to the same distance."""
        rng = np.random.default_rng(2)
        for radius in (0.005, 0.05, 1.0):
            count = 400
            position, turn = rng.normal(size=(count, 3)), view_data.continuous(random_rotations(count, rng))
            table = {f"body.position_{axis}": column for axis, column in zip("xyz", position.T)}
            table.update({f"body.orientation_{axis}": column for axis, column in zip("xyzw", turn.T)})
            poses = view_data.Poses(count, 1)
            poses.add(table, "body", ("position", "orientation"), radius)
            about = poses.tracks[0]
            columns = [view_data.back(raw, count, 2) for raw in poses.bytes[:7]]
            position_back = np.stack(columns[:3], axis=1) * about["step"]
            turn_back = np.stack(columns[3:], axis=1) * about["turn"]
            turn_back /= np.linalg.norm(turn_back, axis=1, keepdims=True)
            points = rng.normal(size=(count, 3))
            points *= radius / np.linalg.norm(points, axis=1, keepdims=True)
            off = np.linalg.norm(position + view_data.rotated(turn, points) - position_back - view_data.rotated(turn_back, points), axis=1)
            self.assertLessEqual(off.max(), poses.worst * (1 + 1e-6))
            self.assertLessEqual(poses.worst, view_data.POSE_ERROR)
            self.assertGreater(poses.worst, 0.3 * view_data.POSE_ERROR, "the bound is not far above what happens")

    def test_signs_of_quaternions_do_not_jump(self):
        angles = np.linspace(0, 30, 500)
        turns = np.stack([np.sin(angles / 2), 0 * angles, 0 * angles, np.cos(angles / 2)], axis=1)
        flipped = turns * np.where(np.arange(500) % 7 < 3, -1, 1)[:, None]
        np.testing.assert_allclose(view_data.continuous(flipped) * np.sign(flipped[0] @ turns[0]), turns, atol=1e-15)

    def test_runs_of_patches_are_the_patches(self):
        rng = np.random.default_rng(3)
        rows = sorted((tick, pair) for tick in range(0, 400) for pair in (0, 0, 1, 2) if rng.random() < 0.7)
        patches = np.zeros(len(rows), view_data_patch())
        patches["tick"], patches["a"] = np.array(rows).T
        patches["b"] = 9
        patches["at"][:, 0] = np.arange(len(rows))
        for most in (10**6, len(rows) // 3):
            kept, runs, every = view_data.patch_tracks(patches, most)
            self.assertLessEqual(len(kept), most)
            at, seen = 0, []
            for first, length, a, _ in runs:
                np.testing.assert_array_equal(kept["tick"][at:at + length], every * np.arange(first, first + length))
                np.testing.assert_array_equal(kept["a"][at:at + length], a)
                seen += list(kept["at"][at:at + length, 0])
                at += length
            self.assertEqual(sorted(seen), sorted(patches["at"][patches["tick"] % every == 0][:, 0]))

    def test_coarse_meshes_stay_within_their_error(self):
        n = 60
        u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(0.1, np.pi - 0.1, n))
        points = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=2).reshape(-1, 3)
        index = np.arange(n * n).reshape(n, n)
        triangles = np.concatenate([np.stack([index[:-1, :-1], index[1:, :-1], index[:-1, 1:]], axis=2).reshape(-1, 3),
                                    np.stack([index[1:, 1:], index[1:, :-1], index[:-1, 1:]], axis=2).reshape(-1, 3)])
        left, corners, shift = view_data.coarse(points, triangles, 1000)
        self.assertLessEqual(len(corners), 1000)
        self.assertGreater(len(corners), 100)
        distances = np.abs(np.linalg.norm(left, axis=1) - 1)  # from the sphere
        self.assertLessEqual(distances.max(), shift)
        self.assertEqual(view_data.coarse(points, triangles, 10**6)[2], 0)


def view_data_patch():
    return session_data.PATCH


def page_without_npm(bag, target):
    """The page as a machine without npm gets it."""
    import session_report
    sessions = session_data.read(bag, PROGRAM, with_view=True)
    content, *_ = session_report.page(sessions, bag, "", "The 3-D view is left out: npm is not here")
    session_report.write(target, content)


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.bag, cls.html = (os.path.join(cls.folder, "session." + end) for end in ("bag", "html"))
        try:
            view_program.bundle()
        except npm_modules.Unavailable as reason:
            raise unittest.SkipTest(str(reason))
        call = Call("demo", "--seconds", str(SECONDS), "--record", cls.bag)
        assert call.code == 0, call.errors
        cls.call = Call("report", cls.bag)
        assert cls.call.code == 0, cls.call.errors
        cls.session = session_data.read(cls.bag, PROGRAM)[0]
        cls.wide = cls.browser(1280, 800)

    @classmethod
    def browser(cls, *size, **options):
        browser = Browser(*size, *options.pop("arguments", ()), **options)
        cls.addClassCleanup(browser.__exit__, None, None, None)
        return browser.__enter__()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def open(self, page=None, path=None):
        page = page or self.wide
        page.open(path or self.html)
        page.wait("!!window.sessions?.[0].series")
        if path is None:
            page.wait("performance.getEntriesByName('first frame').length > 0")
        return page

    def pixels(self, page, colour, near=60):
        """How many pixels of the view are of about a colour."""
        return page.run(f"""(async () => {{
          const view = {VIEW}.view; view.dirty = true; view.draw();
          const copy = document.createElement('canvas'); copy.width = view.canvas.width; copy.height = view.canvas.height;
          const g = copy.getContext('2d'); g.drawImage(view.canvas, 0, 0);
          const d = g.getImageData(0, 0, copy.width, copy.height).data, c = {json.dumps(colour)};
          let n = 0; for (let i = 0; i < d.length; i += 4) n += Math.abs(d[i] - c[0]) + Math.abs(d[i + 1] - c[1]) + Math.abs(d[i + 2] - c[2]) < {near};
          return n; }})()""")

    def test_the_view_shows_the_poses_of_the_session(self):
        page = self.open()
        table = self.session.table
        for tick in (0, 1234, SECONDS * RATE - 1):
            page.run(f"{VIEW}.go({tick / RATE})")
            grip, cube = page.run(f"(({{view}}) => [view.devices[0].grip.position.toArray(), "
                                  f"view.links[view.data.links.findIndex(l => l.name === 'cube')].position.toArray()])({VIEW})")
            for seen, name in ((grip, "spidar"), (cube, "body.cube")):
                real = [table[f"{name}.position_{axis}"][tick] for axis in "xyz"]
                self.assertLess(np.linalg.norm(np.array(seen) - real), view_data.POSE_ERROR)  # float32 adds 4e-9
        self.assertEqual(page.errors, [])
        self.assertEqual([url for url in page.requests if not url.startswith(("file:///", "data:"))], [])

    def test_keys_mouse_and_one_time_line(self):
        page = self.open()
        now = "window.sessions[0].now"
        page.key(".")
        self.assertAlmostEqual(page.run(now), 1 / RATE, places=9)
        page.key(",")
        self.assertEqual(page.run(now), 0)
        page.key("c")
        first = min(spell["begin"] for spell in self.session.spells if spell["begin"] > 0.0005)
        self.assertAlmostEqual(page.run(now), first, places=4)
        page.key("f")
        self.assertIn("no fault", page.run(f"{VIEW}.output.value"))
        # A click on a curve goes there, and the line of all curves stands there.
        page.run("document.querySelector('.pane canvas').scrollIntoView({block: 'center'})")
        x, y, width = page.run("(b => [b.left, b.top + b.height / 2, b.width])(document.querySelector('.pane canvas').getBoundingClientRect())")
        page.drag((x + width / 2, y))
        self.assertAlmostEqual(page.run(now), SECONDS / 2, delta=0.05 * SECONDS)
        line = page.run("document.querySelector('.pane .now').getBoundingClientRect().left")
        self.assertAlmostEqual(line, x + width / 2, delta=2)
        page.run("scrollTo(0, 0)")
        page.run(f"{VIEW}.speed.value = 0.25")  # a busy machine draws few frames: the session must not end between two keys
        page.run(f"{VIEW}.go(0)")
        page.key(" ")
        page.wait(f"{now} > 0.02")
        page.key(" ")
        stood = page.run(now)
        self.assertFalse(page.run(f"{VIEW}.isPlaying"))
        self.assertEqual(page.run(now), stood)
        slider = f"({VIEW}.slider.value = 5000, {VIEW}.slider.dispatchEvent(new Event('input')), {now})"
        self.assertAlmostEqual(page.run(slider), SECONDS / 2, places=9)

    def test_cameras_turn_zoom_and_follow(self):
        page = self.open()
        camera = f"{VIEW}.view.camera.position.toArray()"
        before = page.run(camera)
        box = page.run(f"(b => [b.left, b.top, b.width, b.height])({VIEW}.canvas.getBoundingClientRect())")
        middle = (box[0] + box[2] / 2, box[1] + box[3] / 2)
        page.drag(middle, (middle[0] + 80, middle[1] + 20), (middle[0] + 120, middle[1] + 20))
        page.wait(f"Math.hypot(...{camera}.map((x, i) => x - {before}[i])) > 0.05")
        page.run(f"{VIEW}.go(1.5)")
        page.key("2")
        away = f"(view => view.controls.target.distanceTo(view.devices[0].gripInWorld(view.target.clone())))({VIEW}.view)"
        page.wait(f"{away} < 0.001")
        self.assertEqual(page.run("document.querySelector('[data-camera=grip]').getAttribute('aria-pressed')"), "true")
        page.key("1")
        page.run(f"{VIEW}.canvas.focus()")
        before = page.run(camera)
        page.key("ArrowLeft")
        page.wait(f"Math.hypot(...{camera}.map((x, i) => x - {before}[i])) > 0.01")

    def test_the_camera_of_all_sees_what_moves_at_all_times(self):
        """The session's own poses through the camera's matrices: a chain that swings far below where it and the device begin."""
        bag, html = (os.path.join(self.folder, "chain." + end) for end in ("bag", "html"))
        for words in (("demo", "--scene", "chain", "--seconds", str(SECONDS), "--record", bag), ("report", bag)):
            call = Call(*words)
            self.assertEqual(call.code, 0, call.errors)
        table = session_data.read(bag, PROGRAM)[0].table
        columns = lambda name, axes: np.stack([table[f"{name}_{axis}"] for axis in axes], axis=1)[::25]  # noqa: E731
        points = [columns("spidar.position", "xyz")]
        for link in range(1, 11):
            position, turn = columns(f"body.link{link}.position", "xyz"), columns(f"body.link{link}.orientation", "xyzw")
            points += [position + view_data.rotated(turn, np.tile((x, y, z), (len(turn), 1))) for x in (0, 0.1) for y in (-0.01, 0.01) for z in (-0.01, 0.01)]
        page = self.open(path=html)
        page.wait("performance.getEntriesByName('first frame').length > 0")
        base = page.run(f"{VIEW}.view.devices[0].about && {VIEW}.view.data.bases[0].pose.slice(0, 3)")
        points[0] = points[0] + base  # this device stands as the world does
        view, projection = (np.array(page.run(f"{VIEW}.view.camera.{name}.elements")).reshape(4, 4).T for name in ("matrixWorldInverse", "projectionMatrix"))
        seen = np.concatenate(points) @ (projection @ view)[:, :3].T + (projection @ view)[:, 3]
        self.assertTrue((seen[:, 3] > 0).all())
        shares = np.abs(seen[:, :3] / seen[:, 3:])
        self.assertLessEqual(shares.max(), 1, "of half the picture's width, height and depth")
        self.assertGreater(shares[:, :2].max(), 0.7, "the camera stands no farther away than it must")

    def test_pixels_of_both_themes(self):
        page = self.open()
        light = self.pixels(page, (243, 245, 247), 12)
        self.assertGreater(light, 10000, "the ground of the view")
        page.run("document.getElementById('theme').click()")
        self.assertGreater(self.pixels(page, (29, 36, 43), 12), 10000)
        page.run("document.getElementById('theme').click()")
        # The force on the hand is an arrow of this red; free of contact there is next to none.
        table = self.session.table
        force = np.linalg.norm([table[f"spidar.achieved_force_{axis}"] for axis in "xyz"], axis=0)
        counts = []
        for tick in (int(force.argmin()), int(force.argmax())):
            page.run(f"{VIEW}.go({tick / RATE})")
            counts.append(self.pixels(page, (230, 51, 51), 90))
        self.assertGreater(counts[1], counts[0] + 30)

    def test_fingers_and_a_narrow_screen(self):
        page = self.open(self.browser(390, 800, scale=2, touch=True))
        self.assertLessEqual(page.run("document.documentElement.scrollWidth - innerWidth"), 0, "the page must not scroll sideways")
        page.run(f"{VIEW}.canvas.scrollIntoView({{block: 'center'}})")
        x, y, width, height = page.run(f"(b => [b.left, b.top, b.width, b.height])({VIEW}.canvas.getBoundingClientRect())")
        middle = (x + width / 2, y + height / 2)
        camera, distance = f"{VIEW}.view.camera.position.toArray()", f"(v => v.camera.position.distanceTo(v.controls.target))({VIEW}.view)"
        before = page.run(camera)
        page.fingers([middle], [(middle[0] + 30, middle[1])], [(middle[0] + 60, middle[1])])
        page.wait(f"Math.hypot(...{camera}.map((x, i) => x - {before}[i])) > 0.02")
        far = page.run(distance)
        page.fingers([(middle[0] - 20, middle[1]), (middle[0] + 20, middle[1])], [(middle[0] - 40, middle[1]), (middle[0] + 40, middle[1])],
                     [(middle[0] - 60, middle[1]), (middle[0] + 60, middle[1])])
        page.wait(f"{distance} < 0.8 * {far}")

    def test_without_webgl_or_npm_the_curves_go_on(self):
        page = self.open(self.browser(1280, 800, arguments=["--disable-gpu", "--disable-3d-apis"]), self.html)
        page.wait(f"{VIEW}.said.textContent.includes('no WebGL')")
        other = os.path.join(self.folder, "plain.html")
        page_without_npm(self.bag, other)
        self.assertLess(os.path.getsize(other), os.path.getsize(self.html) - 150000)
        plain = self.open(path=other)
        self.assertNotIn("first frame", plain.run("performance.getEntriesByType('mark').map(mark => mark.name)"))
        plain.wait(f"{VIEW}.said.textContent.includes('npm is not here')")
        for each in (page, plain):
            each.key(".")
            self.assertAlmostEqual(each.run("window.sessions[0].now"), 1 / RATE, places=9)
            self.assertGreater(each.run("window.sessions[0].panes.length"), 8)
            self.assertTrue(each.run(f"{VIEW}.canvas.hidden"))
            self.assertEqual(each.errors, [])

    def test_the_page_says_its_errors(self):
        with open(self.html, encoding="utf-8") as file:
            page = file.read()
        self.assertLess(float(page.split('"poseError":')[1].split(",")[0]), view_data.POSE_ERROR)
        self.assertLessEqual(self.call.figures()["session.pose_error_um"], 1e6 * view_data.POSE_ERROR)
        packed = page.split('id="view3d">')[1].split("<")[0]
        import base64
        self.assertIn("Copyright", zlib.decompress(base64.b64decode(packed)).decode(), "three.js's licence goes along")


if __name__ == "__main__":
    unittest.main()
