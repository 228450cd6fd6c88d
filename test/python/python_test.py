#!/usr/bin/python3
"""The package haptic: closed forms, views without copies, the same bits again, errors, and that its stubs are complete."""
import ast
import os
import sys
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
os.environ["ROS_PACKAGE_PATH"] = ROOT + ":" + os.environ.get("ROS_PACKAGE_PATH", "")
import numpy as np  # noqa: E402

try:
    import haptic
except ModuleNotFoundError as missing:
    if missing.name not in ("haptic", "haptic._haptic"):
        raise
    sys.exit("python_test: the package haptic is not built: install pybind11-dev and build again")

EPS = np.finfo(float).eps
SCENES = ("touch_cube", "blocks", "door", "gear")
BALL = """<robot name="fall" xmlns:haptic="https://haptic/urdf"><haptic:scene step="0.001"/><link name="world"/>
<link name="ball"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
</link><joint name="free" type="floating"><origin xyz="0.1 0.2 2"/><parent link="world"/><child link="ball"/></joint></robot>"""


def turned(axis, angle, position=(0, 0, 0)):
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    X = np.eye(4)
    X[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    X[:3, 3] = position
    return X


class Worlds(unittest.TestCase):
    def ball(self):
        import tempfile
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(BALL)
            file.flush()
            scene = haptic.Scene(file.name)
        return scene

    def test_free_fall_is_a_parabola(self):
        scene = self.ball()
        scene.gravity = [0.5, 0, -9.8]
        world, n, h = haptic.World(scene), 300, scene.step
        q, v = world.coordinates["ball"]
        world.v[v][3:] = [1, 0, 2]  # written in place, before the first step
        world.step(n)
        fallen = np.array([0.1, 0.2, 2]) + n * h * np.array([1, 0, 2]) + (n * h) ** 2 / 2 * scene.gravity
        np.testing.assert_allclose(world.q[q][:3], fallen, rtol=0, atol=4 * n * EPS * 3)  # two roundings of numbers below 3 a step
        np.testing.assert_allclose(world.pose("ball")[:3, 3], fallen, rtol=0, atol=5 * n * EPS * 3)
        self.assertAlmostEqual(world.time, n * h, places=12)

    def test_a_wrench_acts_for_its_time(self):
        scene = self.ball()
        scene.gravity = [0, 0, 0]
        world, n, h = haptic.World(scene), 100, scene.step
        world.apply_wrench("ball", [0, 0, 2e-4, 0.3, 0, -0.1], n * h, point=[0, 0, 0], frame="link")
        world.step(2 * n)
        np.testing.assert_allclose(world.twist("ball")[3:], n * h / 0.1 * np.array([0.3, 0, -0.1]), rtol=0, atol=5e-3)  # it turns meanwhile
        world = haptic.World(scene)
        world.apply_wrench("ball", [0, 0, 2e-4, 0.3, 0, -0.1], n * h)
        world.step(2 * n)
        np.testing.assert_allclose(world.twist("ball"), n * h * np.array([0, 0, 2, 3, 0, -1]), rtol=0, atol=100 * n * EPS)
        for bad in (dict(link="ball", wrench=[0] * 6, duration=-1), dict(link="ball", wrench=[0] * 6, duration=1, frame="map"),
                    dict(link="nothing", wrench=[0] * 6, duration=1)):
            with self.assertRaises(haptic.SetupError):
                world.apply_wrench(**bad)

    def test_bodies_are_put_and_gravity_changes(self):
        world = haptic.World(self.ball())
        world.step(10)
        world.set_body_pose("ball", turned([0, 0, 1], 0.4, [1, 2, 3]), [0, 0, 1, 0.5, 0, 0])
        np.testing.assert_allclose(world.pose("ball"), turned([0, 0, 1], 0.4, [1, 2, 3]), rtol=0, atol=10 * EPS)
        world.gravity = [0, 0, 2]
        np.testing.assert_array_equal(world.gravity, [0, 0, 2])
        world.step(100)
        np.testing.assert_allclose(world.twist("ball"), [0, 0, 1, 0.5, 0, 0.2], rtol=0, atol=1000 * EPS)
        door = haptic.World("door")
        for bad in (lambda: door.set_joint_positions({"no_such_joint": 0}), lambda: world.set_body_pose("ball", np.zeros((4, 4))),
                    lambda: setattr(world, "gravity", [0, 0, 1e9]), lambda: world.lead("ball", np.eye(4), 1)):
            with self.assertRaises(haptic.SetupError):
                bad()

    def test_views_are_the_memory_itself(self):
        for scene in SCENES:
            for accuracy in (0.03, 0.003):
                loaded = haptic.Scene(scene)
                loaded.accuracy = accuracy
                world = haptic.World(loaded)
                world.step(5)
                views = {name: getattr(world, name) for name in ("q", "v", "positions", "rotations")}
                before = {name: view.copy() for name, view in views.items()}
                world.step(200)
                for name, view in views.items():
                    self.assertIsNotNone(view.base, name)
                    again = getattr(world, name)
                    self.assertEqual(view.ctypes.data, again.ctypes.data, f"{scene} {accuracy}: {name} moved")
                    np.testing.assert_array_equal(view, again)
                self.assertEqual(views["q"].flags.writeable, True)
                self.assertEqual(views["positions"].flags.writeable, False)
                del before

    def test_positions_and_rotations_are_the_poses(self):
        world = haptic.World("door")
        world.step(300)
        for index, name in enumerate(world.links):
            np.testing.assert_array_equal(world.pose(name)[:3, :3], world.rotations[index])
            np.testing.assert_array_equal(world.pose(name)[:3, 3], world.positions[index])

    def test_what_is_written_acts(self):
        scene = haptic.Scene("touch_cube")
        world = haptic.World(scene)
        world.step(100)
        q, v = world.coordinates["cube"]
        world.q[q.start + 2] += 0.05
        lifted = world.pose("cube")[2, 3]
        self.assertAlmostEqual(lifted, world.q[q.start + 2], places=9)
        world.v = np.zeros_like(world.v)
        world.step(10)
        # free fall of ten steps; nothing touches a cube 50 mm up
        self.assertAlmostEqual(world.pose("cube")[2, 3], lifted - 9.8 * 1e-6 * 50, places=9)

    def test_same_bits_again_after_restore(self):
        for scene in SCENES:
            world = haptic.World(scene)
            world.step(50)
            start = world.save()
            world.step(150)
            there = world.hash()
            world.restore(start)
            world.step(150)
            self.assertEqual(world.hash(), there, scene)

    def test_reading_changes_nothing(self):
        worlds = [haptic.World("blocks"), haptic.World("blocks")]
        for _ in range(100):
            for world in worlds:
                world.step()
            worlds[0].q, worlds[0].positions, worlds[0].contacts, worlds[0].save(), worlds[0].energy.balance
        self.assertEqual(worlds[0].hash(), worlds[1].hash())

    def test_contacts_carry_the_weight(self):
        world = haptic.World("touch_cube")
        world.step(2000)
        cube = world.link("cube")
        resting = world.contacts[(world.contacts["link_a"] == cube) | (world.contacts["link_b"] == cube)]
        sign = np.where(resting["link_b"] == cube, 1.0, -1.0)
        # 0.1 kg at rest; what is left of its settling is below 1e-6 N after two seconds
        np.testing.assert_allclose((sign[:, None] * resting["force"]).sum(axis=0), [0, 0, 0.98], atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(resting["normal"], axis=1), 1, atol=1e-12)
        self.assertTrue(resting["sticking"].all())
        self.assertEqual(len(world.contacts), world.report.contacts)
        self.assertIsNotNone(world.contacts.base)

    def test_sensors(self):
        import tempfile
        arm = """<robot name="arm" xmlns:haptic="https://haptic/urdf"><link name="world"/><link name="arm"><inertial><origin xyz="0.2 0 0"/>
<mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="0.1"/></joint>
<haptic:sensor name="base" type="wrench" joint="hinge"/><haptic:sensor name="imu" type="imu" link="arm"/></robot>"""
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(arm)
            file.flush()
            world = haptic.World(file.name)
        self.assertEqual(world.sensors, ["base", "imu"])
        self.assertEqual(world.readings["step"].tolist(), [0, 0])
        self.assertTrue(np.isnan(world.readings["force"]).all())
        world.step(10)
        readings = world.readings
        self.assertEqual(readings["step"].tolist(), [10, 10])
        self.assertIsNotNone(readings.base)
        # Its axis is upright: it stands still, and the hinge carries it.
        np.testing.assert_allclose(readings["force"][0], [0, 0, 2 * 9.8], atol=100 * EPS)
        np.testing.assert_allclose(readings["torque"][0], [0, -0.2 * 2 * 9.8, 0], atol=100 * EPS)
        np.testing.assert_allclose(readings["specific_force"][1], [0, 0, 9.8], atol=100 * EPS)
        np.testing.assert_allclose(readings["orientation"][1], [0, 0, 0, 1])
        self.assertTrue(np.isnan(readings["force"][1]).all())
        self.assertEqual(world.joint_efforts.shape, (1,))
        self.assertEqual(world.drive_efforts[0], 0)

    def test_contacts_say_more(self):
        world = haptic.World("touch_cube")
        world.step(2000)
        n = len(world.contacts)
        self.assertEqual((world.centres_of_pressure.shape, world.slips.shape), ((n, 3), (n, 3)))
        across = np.cross(world.contacts["normal"], world.contacts["torque"]) / world.contacts["normal_force"][:, None]
        np.testing.assert_allclose(world.centres_of_pressure - world.contacts["point"], across, atol=1e-12)
        self.assertLess(np.abs(world.slips).max(), 1e-6)  # it stands
        corners = world.patch(0)
        area = 0.5 * np.dot(world.contacts["normal"][0], np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0))
        self.assertAlmostEqual(area / world.contacts["area"][0], 1, delta=1e-6)  # it moves by less than that
        with self.assertRaises(haptic.SetupError):
            world.patch(n)

    def test_certificate(self):
        certificate = haptic.certify("touch_cube")
        self.assertEqual(len(certificate.limits), len(certificate.islands))
        self.assertIn("cube", sum(certificate.islands, []))
        self.assertGreater(min(certificate.limits), 0)


class Devices(unittest.TestCase):
    def test_lengths_and_structure(self):
        for name in ("spidar_g6x3r", "spidar_4"):
            device = haptic.Device(name)
            np.testing.assert_allclose(device.lengths(), np.linalg.norm(device.exits - device.knots, axis=1), rtol=4 * EPS)
            X = turned([1, 2, 3], 0.2 if device.dof >= 6 else 0.0, [0.01, -0.02, 0.005])
            structure, d = device.structure(X), 1e-6
            for column in range(min(device.dof, 3)):
                moved = [X.copy(), X.copy()]
                moved[0][column, 3] += d
                moved[1][column, 3] -= d
                slope = (device.lengths(moved[0]) - device.lengths(moved[1])) / (2 * d)
                # curvature: third derivative of a length, about 1/l², times d²; rounding of lengths over d
                np.testing.assert_allclose(-slope, structure[:, column], atol=1e3 * d * d + 10 * EPS / d)

    def test_pose_from_lengths(self):
        device = haptic.Device()
        X = turned([1, -1, 2], 0.3, [0.01, 0.02, -0.015])
        solution = device.solve_pose(device.lengths(X))
        self.assertTrue(solution.converged)
        np.testing.assert_allclose(solution.X_BG, X, atol=1e-11)

    def test_tensions_present_the_wrench(self):
        device = haptic.Device()
        X = turned([0, 1, 1], 0.1, [0.005, 0, 0.01])
        answer = device.tensions([1, -0.5, 0.5], [0.01, 0, 0.02], X)
        wrench = device.structure(X).T @ answer.tension
        np.testing.assert_allclose(wrench, np.concatenate([answer.force, answer.torque]), atol=100 * EPS * answer.tension.max())
        np.testing.assert_allclose(answer.force, [1, -0.5, 0.5], atol=1e-3)  # inside what the strings can present: to 0.1 %
        self.assertTrue(answer.solved)


class Loops(unittest.TestCase):
    def test_loop_feels_the_cube_and_is_deterministic(self):
        ends = []
        for chunk in (1, 100):
            loop = haptic.Loop("touch_cube")
            hand, touched = loop.hands[0], False
            for _ in range(2000 // chunk):
                loop.tick(chunk)
                touched = touched or hand.in_contact
            ends.append(loop.world.hash())
            self.assertEqual(hand.state, "ENABLED")
            np.testing.assert_allclose(hand.X_BG, hand.truth, atol=2e-3)  # encoder steps
        self.assertTrue(touched)
        self.assertEqual(*ends)
        np.testing.assert_allclose(hand.achieved[3:], hand.asked[3:], atol=2e-2)

    def test_hand_goes_where_it_is_told_and_pause_holds_the_world(self):
        loop = haptic.Loop("touch_cube")
        loop.tick(10)
        loop.hands[0].move_to(turned([0, 0, 1], 0, [0.01, 0, 0.01]))
        loop.tick(1000)
        np.testing.assert_allclose(loop.hands[0].truth[:3, 3], [0.01, 0, 0.01], atol=1e-3)
        loop.pause()
        before = loop.world.hash()
        loop.tick(100)
        self.assertEqual(loop.world.hash(), before)

    def test_world_outlives_the_name_of_its_loop(self):
        world = haptic.Loop("touch_cube").world
        q = world.q
        del world
        self.assertTrue(np.isfinite(q).all())


class Errors(unittest.TestCase):
    def refuse(self, act, *words):
        with self.assertRaises(haptic.SetupError) as caught:
            act()
        message = str(caught.exception)
        self.assertEqual(len(message.splitlines()), 1, message)
        for word in words:
            self.assertIn(word, message)

    def test_one_line_each(self):
        world, device, scene = haptic.World("door"), haptic.Device(), haptic.Scene("door")
        self.refuse(lambda: haptic.World("no_such_scene"), "no_such_scene", "touch_cube")
        self.refuse(lambda: haptic.Device("no_such_device"), "no_such_device", "spidar_g6x3r")
        self.refuse(lambda: haptic.Device("/no/such.yaml"), "/no/such.yaml")
        self.refuse(lambda: world.pose("no_such_link"), "no_such_link", world.links[0])
        self.refuse(lambda: world.command("no_such_joint", position=1), "no_such_joint")
        self.refuse(lambda: setattr(world, "q", [1, 2]), "q", "2")
        self.refuse(lambda: world.restore([1, 2, 3]), "saved state")
        self.refuse(lambda: world.aim_pointer(7, np.eye(4)), "7")
        self.refuse(lambda: world.aim_pointer(0, 2 * np.eye(4)), "rotation")
        self.refuse(lambda: device.solve_pose([1, 2]), "8", "2")
        with self.assertWarnsRegex(DeprecationWarning, "sdirk2.*accuracy"):
            scene.integrator = "sdirk2"
        self.assertEqual(scene.integrator, "automatic")
        self.assertEqual(scene.accuracy, 0.03)
        self.refuse(lambda: setattr(scene, "accuracy", 2), "accuracy = '2'", "≤ 1")
        self.refuse(lambda: haptic.Loop("door", rate=0), "rate")


class BadNumbers(unittest.TestCase):
    def calls(self):
        """(what, call of one number, whether it may be below 0), each on objects of its own."""
        world, loop, device = haptic.World("touch_cube"), haptic.Loop("touch_cube"), haptic.Device()
        door, scene = haptic.World("door"), haptic.Scene("touch_cube")
        lengths, six, here = device.lengths(), np.zeros(6), np.eye(4)
        cube = here.copy()
        cube[2, 3] = 1

        def put(vector, i, x):
            vector = np.array(vector, float)
            vector.flat[i] = x
            return vector

        def write(name, x):
            getattr(world, name)[0] = x
            world.step(1)

        yield "World.step", world.step, False
        yield "Loop.tick", loop.tick, False
        yield "Loop.rate", lambda x: haptic.Loop("touch_cube", rate=x), False
        yield "certify.settle", lambda x: haptic.certify("touch_cube", x), False
        for name, below in (("step", False), ("far_step", False), ("accuracy", False)):
            yield "Scene." + name, lambda x, name=name: setattr(scene, name, x), below
        yield "Scene.default_density", lambda x: haptic.Scene("touch_cube", default_density=x), False
        yield "Scene.gravity", lambda x: setattr(scene, "gravity", [0, x, 0]), True
        yield "World.gravity", lambda x: setattr(world, "gravity", [0, x, 0]), True
        yield "World.budget", lambda x: setattr(world, "budget", x), False
        for name in ("stiffness_scale", "friction_scale"):
            yield "World.tune " + name, lambda x, name=name: world.tune(**{name: x}), False
        for name in ("q", "v"):
            yield "World." + name, lambda x, name=name: setattr(world, name, put(getattr(world, name), 0, x)), True
            yield "World." + name + " in place", lambda x, name=name: write(name, x), True
        for name in ("position", "velocity", "effort"):
            yield "World.command " + name, lambda x, name=name: door.command(door.joints[0], **{name: x}), True
        for i in (0, 7):
            yield f"World.aim_pointer X {i}", lambda x, i=i: world.aim_pointer(0, put(here, i, x)), i == 7
            yield f"World.aim_pointer V {i % 6}", lambda x, i=i: world.aim_pointer(0, here, put(six, i % 6, x)), True
        yield "World.aim_pointer index", lambda x: world.aim_pointer(x, here), False
        yield "World.apply_wrench", lambda x: world.apply_wrench("cube", put(six, 3, x), 0.01), True
        yield "World.apply_wrench duration", lambda x: world.apply_wrench("cube", six, x), False
        yield "World.apply_wrench point", lambda x: world.apply_wrench("cube", six, 0.01, point=[x, 0, 0]), True
        yield "World.set_body_pose", lambda x: world.set_body_pose("cube", put(cube, 3, x)), True
        yield "World.set_body_pose V", lambda x: world.set_body_pose("cube", cube, put(six, 4, x)), True
        yield "World.set_joint_positions", lambda x: door.set_joint_positions({door.joints[0]: x}), True
        yield "World.patch", world.patch, False
        yield "World.restore", lambda x: world.restore(put(world.save(), 7, x)), True
        for name in ("lengths", "structure"):
            yield "Device." + name, lambda x, name=name: getattr(device, name)(put(here, 3, x)), True
            yield "Device.opening " + name, lambda x, name=name: getattr(device, name)(here, x), True
        yield "Device.solve_pose", lambda x: device.solve_pose(put(lengths, 2, x)), False
        yield "Device.solve_pose guess", lambda x: device.solve_pose(lengths, put(here, 3, x)), True
        yield "Device.solve_pose opening", lambda x: device.solve_pose(lengths, opening=x), True
        yield "Device.tensions force", lambda x: device.tensions([0, 0, x]), True
        yield "Device.tensions torque", lambda x: device.tensions([0, 0, 0], [x, 0, 0]), True
        yield "Device.tensions X", lambda x: device.tensions([0, 0, 1], X_BG=put(here, 3, x)), True
        yield "Device.tensions opening", lambda x: device.tensions([0, 0, 1], opening=x), True
        yield "Device.tensions grasp", lambda x: device.tensions([0, 0, 1], grasp_force=x), True
        yield "Hand.move_to", lambda x: loop.hands[0].move_to(put(here, 3, x)), True
        yield "World.lead duration", lambda x: self.lead(x, 0.0), False
        yield "World.lead V", lambda x: self.lead(0.1, x), True

    @staticmethod
    def lead(duration, speed):
        import tempfile
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(BALL.replace("</robot>", '<haptic:motion link="ball" topic="/way"/></robot>'))
            file.flush()
            haptic.World(file.name).lead("ball", turned([0, 0, 1], 0.1, (0, 0, 2)), duration, [0, 0, 0, 0, 0, speed])

    def test_no_bad_number_is_taken(self):
        taken = []
        for what, call, may_be_negative in self.calls():
            for bad in (np.nan, np.inf, -np.inf) + (() if may_be_negative else (-1.0, -1)):
                try:
                    call(bad)
                except (haptic.SetupError, TypeError):  # TypeError: of a count that is no whole number
                    continue
                taken.append(f"{what} = {bad}")
        print(f"figure python.bad_numbers_taken {len(taken)} 1")
        self.assertEqual(taken, [])

    def test_a_refused_number_changes_nothing(self):
        world = haptic.World("touch_cube")
        world.step(10)
        before = world.hash()
        with self.assertRaisesRegex(haptic.SetupError, r"q\[0\]: is nan; give a finite number"):
            world.q[0] = np.nan
            world.step(1)
        with self.assertRaisesRegex(haptic.SetupError, "count: is -1.*>= 0"):
            world.step(-1)
        self.assertEqual(world.hash(), before)


class Stubs(unittest.TestCase):
    def test_stubs_name_what_the_module_has(self):
        with open(os.path.join(os.path.dirname(haptic.__file__), "__init__.pyi"), encoding="utf-8") as file:
            tree = ast.parse(file.read())
        stubs = {node.name: {item.name if isinstance(item, ast.FunctionDef) else item.target.id for item in node.body
                             if isinstance(item, (ast.FunctionDef, ast.AnnAssign))}
                 for node in tree.body if isinstance(node, ast.ClassDef)}
        for name in set(haptic.__all__) - {"certify", "__version__", "SetupError"}:
            members = {member for member in vars(getattr(haptic, name)) if not member.startswith("_")}
            self.assertEqual(members, {member for member in stubs[name] if not member.startswith("_")}, name)
            self.assertTrue(getattr(haptic, name).__doc__, name)

    def test_everything_says_what_it_is(self):
        for name in set(haptic.__all__) - {"__version__", "certify"}:
            for member, value in vars(getattr(haptic, name)).items():
                if member.startswith("_"):
                    continue
                said = [line for line in (value.__doc__ or "").splitlines() if line.strip()]
                # the first line of a method is its signature
                self.assertGreater(len(said), 0 if isinstance(value, property) else 1, f"{name}.{member}")


if __name__ == "__main__":
    unittest.main()
