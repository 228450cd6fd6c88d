#!/usr/bin/python3
"""The report: its arithmetic, its exact solutions, and that it survives what runs do to it. `report_test.py BUILD_FOLDER`."""
import csv
import html
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import advice  # noqa: E402
import engine_results  # noqa: E402
import figures  # noqa: E402
import haptic_section  # noqa: E402
import page  # noqa: E402
import pareto  # noqa: E402
import profile_steps  # noqa: E402
import programs  # noqa: E402
import run_errors  # noqa: E402
import report_plan  # noqa: E402
from analysis import SceneResult  # noqa: E402
from report_plan import Case, describe  # noqa: E402

WASM = os.environ['HAPTIC_WASM_PEERS'] = programs.fetched_wasm_peers()
PROGRAMS = sys.argv.pop(1) if len(sys.argv) > 1 and os.path.isdir(sys.argv[1]) else ''
SPHERE = '<robot name="{name}" xmlns:haptic="https://haptic/urdf"><haptic:scene step="0.001"><haptic:contact ' \
         'stiffness="{k}"/></haptic:scene><link name="world"/><link name="ball"><inertial><mass value="0.1"/><inertia ' \
         'ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size="0.1 0.1 0.1"/>' \
         '</geometry></collision></link><link name="floor"><collision><geometry><box size="4 4 1"/></geometry></collision>' \
         '</link><joint name="a" type="floating"><origin xyz="0 0 0.06"/><parent link="world"/><child link="ball"/>' \
         '<haptic:joint linear="{v}"/></joint><joint name="b" type="fixed"><origin xyz="0 0 -0.5"/><parent link="world"/>' \
         '<child link="floor"/></joint></robot>'


class Arithmetic(unittest.TestCase):
    def test_angle_between_is_exact_for_large_and_tiny_rotations(self):
        for angle in (1e-12, 1e-6, 0.3, 3.0):
            a = run_errors.np.array([math.cos(angle / 2), 0, 0, math.sin(angle / 2)])
            b = run_errors.np.array([1.0, 0, 0, 0])
            for sign in (1, -1):  # both quaternions of a rotation
                self.assertAlmostEqual(run_errors.angle_between(sign * a, b) / angle, 1, delta=1e-12)

    def test_order_is_the_slope_above_the_floor(self):
        steps = [1e-4, 2e-4, 4e-4, 8e-4, 1.6e-3]
        order, points = run_errors.order_of(steps, [3 * h ** 2 for h in steps])
        self.assertAlmostEqual(order, 2, delta=1e-9)
        floored = [3 * h ** 2 + (1e-7 if h < 3e-4 else 0) for h in steps]
        order, points = run_errors.order_of(steps, floored)
        self.assertGreater(order, 1.5)
        self.assertLess(points, 5)
        self.assertTrue(math.isnan(run_errors.order_of([1e-3], [1])[0]))

    def test_cells_that_nobody_reaches_do_not_count_and_none_is_left_out(self):
        cells = [('s', 'position', decade, decade < -4) for decade in range(-2, -9, -1)]
        points = {('s', 'position'): [pareto.Point(1.0, 5e-4, True, True, 'peer'), pareto.Point(2.0, 5e-6, False, True, 'ours'),
                                      pareto.Point(0.1, 0.5, False, True, 'rough')]}
        reached = pareto.reached_cells(points, cells=cells)
        self.assertEqual([cell.decade for cell in reached], [-2, -3, -4, -5])
        self.assertEqual([pareto.verdict(cell) for cell in reached], ['lost', 'lost', 'only ours', 'only ours'])
        counted = pareto.counts(reached)
        self.assertEqual((counted['contested'], counted['only ours'], counted['cells'], counted['rounding']), (2, 1, 3, 1))
        self.assertEqual(pareto.front([(1, 3), (2, 4), (3, 1), (4, 2)]), [(1, 3), (3, 1)])

    def test_a_cell_is_won_by_five_percent_or_it_is_level(self):
        def cell(ours, theirs):
            return pareto.Cell('s', 'position', -2, False, ours, 'ours', theirs, 'peer')
        self.assertEqual([pareto.verdict(cell(*costs)) for costs in ((1, 1.06), (1, 1.04), (1.04, 1), (1.06, 1))],
                         ['won', 'level', 'level', 'lost'])

    def test_spread_is_shown_where_a_fifth_decides(self):
        def cell(ours, theirs, our_run='ours'):
            return pareto.Cell('s', 'position', -2, False, ours, our_run, theirs, 'peer')
        self.assertEqual([pareto.decides_closely(cell(*costs)) for costs in ((1, 1.19), (1.19, 1), (1, 1.21), (math.inf, 1, None))],
                         [True, True, False, False])

    def test_the_default_count_takes_the_default_alone(self):
        def point(method, own):
            run = run_errors.Run(Case('s', method, 1e-3, 0, 0), *[None] * (len(run_errors.Run._fields) - 1))
            return pareto.Point(1.0, 1e-3, False, own, run)
        takes, _ = pareto.comparisons('volume-implicit')['default']
        self.assertEqual([takes(point(*each)) for each in (('volume-implicit', True), ('volume-implicit', False), ('volume-verlet', True))],
                         [True, False, False])

    def test_the_rule_of_the_list_says_which_default_counts(self):
        def point(scene, stiffness, own):
            run = run_errors.Run(Case(scene, 'volume-automatic', 1e-3, stiffness, 0), *[None] * (len(run_errors.Run._fields) - 1))
            return pareto.Point(1.0, 1e-3, False, own, run)
        takes = {name: take for name, (take, _) in pareto.comparisons('volume-automatic').items()}
        said, rigid = {scene: point(scene, 1e6, True) for scene in ('rest', 'bounce')}, \
            {scene: point(scene, math.inf, False) for scene in ('rest', 'bounce')}
        self.assertEqual([takes['chosen'](p) for p in (said['rest'], rigid['rest'], said['bounce'], rigid['bounce'])],
                         [False, True, True, False])
        self.assertEqual([takes['default'](said['rest']), takes['default'](rigid['rest']), takes['default_rigid'](rigid['rest'])],
                         [True, False, True])
        self.assertEqual(set(pareto.read_defaults().values()), {'said', 'rigid'})
        stiffer = point('rest', 1e12, False)  # neither: a user's own choice
        self.assertFalse(takes['chosen'](stiffer))

    def test_what_webassembly_alone_reaches_is_counted_apart(self):
        cells = [('s', 'position', decade, decade < -4) for decade in range(-2, -7, -1)]
        points = {('s', 'position'): [pareto.Point(1.0, 5e-4, True, True, 'peer')]}
        wasm = {('s', 'position'): [pareto.Point(math.nan, 5e-5, True, True, 'wasm')]}
        reached = pareto.reached_cells(points, cells=cells)
        self.assertEqual(pareto.only_wasm(wasm, reached, cells), [('s', 'position', -4)])
        self.assertTrue(report_plan.is_wasm('mujoco3_euler') and not report_plan.is_wasm('mujoco_euler'))
        self.assertEqual(pareto.lost_ratio([pareto.Cell('s', 'position', -2, False, 3.0, 'ours', 1.0, 'peer'),
                                            pareto.Cell('s', 'position', -3, True, 9.0, 'ours', 1.0, 'peer')])[0], 3.0)

    def test_figures_of_the_haptic_peer_become_rows(self):
        output = 'peers haptic god plane\nfigure god.lets_go 1 trials\nfigure ours.edge.tick_us 6.2 us\n'
        self.assertEqual(haptic_section.rows_of(output), [('god', '', 'lets_go', 1.0, 'trials'), ('ours', 'edge', 'tick_us', 6.2, 'us')])

    def test_list_of_cells_names_metrics_that_exist(self):
        cells = pareto.read_cells()
        self.assertEqual(len(cells), len(set(cells)))
        self.assertEqual({cell[1] for cell in cells} - set(run_errors.METRICS), set())
        if PROGRAMS:  # and scenes: a name that no scene has would never be counted
            known = {scene.name for scene in describe(programs.find(PROGRAMS, 'report_run'), [])}
            self.assertEqual({cell[0] for cell in cells} - known, set())
            self.assertLessEqual({'swinging_chain', 'arm_load', 'quadruped_stands', 'quadruped_walks', 'hand_grasp'}, {cell[0] for cell in cells})
        self.assertEqual(min(cell[2] for cell in cells if cell[:2] == ('rest', 'position') and not cell[3]), -9)

    def test_advice_takes_only_what_a_hand_at_one_kilohertz_holds(self):
        def run(method, step, cpu, slowest):
            values = dict.fromkeys(run_errors.Run._fields)
            values.update(case=Case('s', method, step, 0, 0), status='ok', cpu=cpu, slowest=slowest)
            return run_errors.Run(**values)

        class Result:
            total = [(run('volume-automatic', 1e-2, 0.001, 1e-6), {'position': 1e-5}), (run('volume-automatic', 1e-3, 0.01, 7e-4), {'position': 1e-5}),
                     (run('volume-automatic', 5e-4, 0.1, 2e-4), {'position': 1e-5, 'wrench': 0.2}),
                     (run('point-verlet', 1e-3, 1e-4, 1e-6), {'position': 1e-9}),  # no scene can be given this method
                     (run('bullet10', 1e-3, 0.02, 1e-5), {'position': 1e-3})]
        found = advice.choices(Result, 'position')
        self.assertEqual([choice.ours and choice.ours.case.step for choice in found], [5e-4] * 4 + [None])
        self.assertEqual(advice.named(found[0].ours), '<haptic:scene step="0.0005">')
        self.assertEqual(advice.advised(Result), Result.total[2])
        self.assertEqual([choice.theirs and choice.theirs.case.method for choice in found], ['bullet10'] * 2 + [None] * 3)

    def test_the_first_screen_counts_scenes_that_are_held_within_one_percent_in_all_measures(self):
        def run(scene, method, cpu, slowest=1e-5, stiffness=0.0, accuracy=0):
            values = dict.fromkeys(run_errors.Run._fields)
            values.update(case=Case(scene, method, 1e-3, stiffness, 0, accuracy), status='ok', cpu=cpu, slowest=slowest)
            return run_errors.Run(**values)

        def result(name, *total):
            scene = type('Scene', (), {'name': name, 'not_for_peers': ''})
            return type('Result', (), {'scene': scene, 'total': total, 'own_stiffness': staticmethod(lambda case: case.stiffness != math.inf)})

        ours, small = 'volume-automatic', {'position': 1e-3, 'velocity': 1e-3, 'energy': 1e-3}
        results = [result('bounce', (run('bounce', ours, 0.02), small), (run('bounce', ours, 0.01, accuracy=0.3), small),
                          (run('bounce', 'ode_a', 0.01), {**small, 'energy': 0.02}), (run('bounce', 'ode_b', 0.04), small)),
                   result('slide', (run('slide', ours, 0.001), small), (run('slide', ours, 0.03, stiffness=math.inf), small),
                          (run('slide', 'ode_a', 0.01), small), (run('slide', 'ode_b', 0.01), small),
                          (run('slide', 'bullet10', 0.01, slowest=7e-4), small)),
                   result('in_no_list', (run('in_no_list', ours, 1), small))]
        found = advice.holders(results, ours, [{'name': name} for name in ('ode_a', 'ode_b', 'bullet10', 'jolt')])
        self.assertEqual([(h.engine, h.setting, {scene: r.cpu for scene, r in h.runs.items()}, h.scenes) for h in found],
                         [('ours', ours, {'bounce': 0.02, 'slide': 0.03}, 2), ('ode', 'ode_b', {'bounce': 0.04, 'slide': 0.01}, 2),
                          ('bullet', 'bullet10', {}, 2)])


@unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
class ExactSolutions(unittest.TestCase):
    """Against the numbers of closed forms, worked out apart from the programs."""

    def exact(self, scene, *more):
        output = subprocess.run([programs.find(PROGRAMS, 'report_run'), scene, 'exact', *more], capture_output=True, text=True,
                                check=True).stdout
        return run_errors.parse_samples(output.splitlines())

    def test_tilted_cube_passes_a_hundredth_of_a_radian_when_energy_says(self):
        fall = self.exact('tilt', '--seconds', '0.2318494', '--samples', '1')
        w, y = fall.pose[0, 0, 3], fall.pose[0, 0, 5]
        self.assertAlmostEqual(-2 * math.atan2(y, w), 0.01, delta=0.7898892 * 1e-7)
        # Energy: I ω²/2 = m g r (sin(π/4 + 0.1) - sin(π/4 + 0.01)) about the edge.
        omega = math.sqrt(2 * 9.8 * math.sqrt(2) * (math.sin(math.pi / 4 + 0.1) - math.sin(math.pi / 4 + 0.01)) / (8 / 3))
        self.assertAlmostEqual(fall.twist[0, 0, 1], omega, delta=1e-6)

    def test_a_cube_slides_out_of_a_grasp_as_the_friction_that_is_missing_says(self):
        for name, factor in (('grasp_090', 0.9), ('grasp_098', 0.98)):
            slide = self.exact(name)
            for time_, pose, twist in zip(slide.time, slide.pose[:, 0], slide.twist[:, 0]):
                since = max(0.0, time_ - 0.5)
                # Of weight and friction of both fingers: m g - 2 mu N / 2 with mu = f m g / N.
                self.assertAlmostEqual(pose[2], -(0.064 * 9.81 * (1 - factor)) / 0.064 * since ** 2 / 2, delta=1e-12)
                self.assertAlmostEqual(twist[5], -9.81 * (1 - factor) * since, delta=1e-12)

    def test_a_cradle_keeps_momentum_and_energy_and_moves_its_balls_by_a_gap(self):
        cradle = self.exact('cradle')
        for twist in cradle.twist:
            self.assertAlmostEqual(twist[:, 3].sum(), 1, delta=1e-12)
            self.assertAlmostEqual((twist[:, 3] ** 2).sum(), 1, delta=1e-12)
        way = cradle.pose[-1, :, 0] - [-0.15, 0, 0.1001, 0.2002, 0.3003]
        self.assertEqual([round(x, 9) for x in way[:4]], [0.05, 1e-4, 1e-4, 1e-4])
        self.assertAlmostEqual(way[4], 0.2 - 0.0503, delta=1e-12)

    def test_stick_slip_releases_at_the_static_limit_and_repeats_with_its_period(self):
        limit, spring, speed, mass = 0.265 * 2 * 9.8, 400, 0.0642, 2
        w, u0 = math.sqrt(spring / mass), (0.265 - 0.160) * 2 * 9.8 / spring
        period = (math.pi + 2 * math.atan2(speed / w, u0)) / w + 2 * u0 / speed
        onset = limit / spring / speed
        at_onset = self.exact('stick_slip', '--seconds', repr(onset), '--samples', '1')
        self.assertAlmostEqual(at_onset.hands[0, 0, 3], -limit, delta=1e-9)
        later = self.exact('stick_slip', '--seconds', repr(onset + 3 * period + 1e-9), '--samples', '1')
        self.assertAlmostEqual(later.pose[0, 0, 0], 3 * period * speed, delta=1e-8)

    def test_free_body_keeps_energy_and_angular_momentum(self):
        motion = self.exact('free')
        inertia = run_errors.np.array([1, 2, 2.5]) @ run_errors.np.array([0.01, 5, 0.01]) ** 2 / 2
        self.assertAlmostEqual(float(abs(motion.energy / inertia - 1).max()), 0, delta=1e-13)
        self.assertAlmostEqual(float(abs(motion.angular_momentum - [0.01, 10, 0.025]).max()), 0, delta=1e-12)

    def test_top_keeps_its_tilt_and_its_apex(self):
        motion = self.exact('top')
        energy = motion.energy
        self.assertAlmostEqual(float(energy.max() - energy.min()), 0, delta=1e-14)
        w, x, y, z = motion.pose[:, 0, 3:].T
        self.assertAlmostEqual(float(abs(1 - 2 * (x * x + y * y) - math.cos(0.2)).max()), 0, delta=1e-14)

    def test_pulled_box_and_rolling_balls_obey_newton(self):
        motion = self.exact('rolling')
        t, mass, ball, radius, pull = motion.time[-1], 10.0, 1.0, 0.1, 150.0
        v = motion.twist[-1][:, 3:]
        along = run_errors.np.array([0.5, math.sqrt(0.75), 0])
        box, balls = v[0] @ along / t, v[1:] @ along / t
        friction = 0.4 * (mass + 25 * ball) * 9.81
        self.assertAlmostEqual(mass * box + ball * float(balls.sum()) + friction, pull, delta=1e-10)
        omega = motion.twist[-1][1:, :3]
        slip = v[1:] + run_errors.np.cross(omega, [0, 0, -radius]) - v[0]
        self.assertLess(float(abs(slip).max()), 1e-12)  # they roll
        torque = 0.4 * ball * radius ** 2 * float(run_errors.np.linalg.norm(omega[0])) / t
        self.assertAlmostEqual(torque, radius * ball * float(balls[0]), delta=1e-12)

    def test_gazebo_box_keeps_energy_and_the_direction_of_its_angular_momentum(self):
        motion = self.exact('boxes_complex')
        self.assertAlmostEqual(motion.energy[0] / 368.5464125, 1, delta=2e-8)  # theirs, from an inertia of eight digits
        self.assertAlmostEqual(float(abs(motion.energy / motion.energy[0] - 1).max()), 0, delta=1e-12)
        spin = motion.angular_momentum - 10 * run_errors.np.cross(motion.pose[:, 0, :3], motion.twist[:, 0, 3:])
        self.assertLess(float(abs(spin - spin[0]).max()), 1e-11)


@unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
class Peers(unittest.TestCase):
    def error(self, peer, scene, step):
        def states(*words):
            done = subprocess.run([programs.find(PROGRAMS, 'report_run'), scene, *words], capture_output=True, text=True, check=True)
            return run_errors.parse_samples(done.stdout.splitlines())
        return float(abs(states(peer, repr(step), '--budget', '0').pose[..., :3] - states('exact').pose[..., :3]).max())

    def test_a_true_ball_rolls_the_better_the_shorter_the_step(self):
        for peer in ('ode_exact', 'ode_quick100_firm', 'bullet10', 'bullet_dantzig', 'mujoco_firm'):
            # First order: a tenth of the step leaves a tenth of the error; half of that is room for softness.
            self.assertGreater(self.error(peer, 'roll', 1e-3), 5 * self.error(peer, 'roll', 1e-4), peer)

    def test_every_setting_runs_where_a_cube_rests(self):
        peers = report_plan.describe_peers(programs.find(PROGRAMS, 'report_run'))
        self.assertGreaterEqual(len(peers), 9)
        self.assertEqual({purpose for purpose in (peer['purpose'] for peer in peers)}, {'as it comes', 'accuracy', 'speed'})
        for peer in peers:
            if report_plan.is_wasm(peer['name']) and not WASM:
                continue  # its packages were never fetched here
            self.assertLess(self.error(peer['name'], 'rest', 1e-3), 1e-2, peer['name'])

    def test_rigid_surfaces_are_rigid_in_a_run(self):
        output = subprocess.run([programs.find(PROGRAMS, 'report_run'), 'stack15', 'volume-automatic', '1e-3', 'rigid', '--budget', '0'],
                                capture_output=True, text=True, check=True).stdout
        samples = run_errors.parse_samples(output.splitlines())
        sink = 0.05 + 0.1 * run_errors.np.arange(15) - samples.pose[-1, :, 2]
        # Each contact by a millionth of 0.1 m at most, the upper ones on all below.
        self.assertTrue((sink <= 1e-7 * run_errors.np.arange(1, 16)).all(), sink)
        self.assertTrue((sink > 0).all(), sink)

    @unittest.skipUnless(WASM, 'needs the packages of test/peers/wasm')
    def test_engines_in_webassembly_fly_and_are_told_forces_and_friction(self):
        program = programs.find(PROGRAMS, 'report_run')

        def output(scene, name):
            return subprocess.run([program, scene, name, '1e-3', '--budget', '0'], capture_output=True, text=True, check=True).stdout
        old, new = (run_errors.parse_samples(output('free', name).splitlines()) for name in ('mujoco_euler', 'mujoco3_euler'))
        if old is not None:  # the same Euler steps without contact; 2.2 and 3.14 may sum in another order
            self.assertLess(abs(old.pose - new.pose).max(), 1e-9)
        said = subprocess.run([program, 'free', 'exact'], capture_output=True, text=True, check=True)
        exact = run_errors.parse_samples(said.stdout.splitlines())
        for engine in ('mujoco3', 'jolt', 'rapier'):
            with self.subTest(engine):
                flown = run_errors.parse_samples(output('free', engine + ('_euler' if engine == 'mujoco3' else '')).splitlines())
                # Steps of first order, in 2 s about the middle axis of inertia, which multiplies their errors; other axes: 5 rad/s.
                self.assertLess(abs(exact.twist[:4] - flown.twist[:4]).max(), 1e-2)
                # Held by the hands' forces alone; friction of .9 of what holds lets go by nearly g (1 - .9) t^2/2 = 19.6 mm.
                held = output('grasp_110', engine + '_firm')
                self.assertIn('status ok', held)
                self.assertLess(float(re.search(r'measure_slip (\S+)', held).group(1)), 1e-3)
                let_go = run_errors.parse_samples(output('grasp_090', engine + '_firm').splitlines())
                self.assertAlmostEqual(let_go.pose[-1, 0, 2], -0.5 * 0.1 * 9.81 * 0.2 ** 2, delta=5e-3)

    def test_a_setting_whose_error_does_not_fall_is_named(self):
        class Scene:
            source = name = 's'
            chaotic, exact, round, not_for_peers, stiffer_is_truer, smallest_step, benchmark = False, True, False, '', False, 0, ''
            stiffness, bodies, measures = 0, 1, ()
        result = SceneResult(Scene, False, ['falls', 'stays'])
        result.exact = True
        for step in (1e-3, 1e-4):
            for peer, error in (('falls', step), ('stays', 0.1)):
                values = dict.fromkeys(run_errors.Run._fields, None)
                result.total.append((run_errors.Run(**{**values, 'case': Case('s', peer, step, 0, 0)}), {'position': error}))
        result.find_not_converging(['falls', 'stays'])
        self.assertEqual(result.not_converging, ['stays'])


class Profiles(unittest.TestCase):
    @unittest.skipUnless(PROGRAMS and shutil.which('valgrind'), 'needs the build folder of the programs, and valgrind')
    def test_a_body_that_flies_moves_by_itself(self):
        scene, = describe(programs.find(PROGRAMS, 'report_run'), ['free'])
        instructions, shares = profile_steps.profile(programs.find(PROGRAMS, 'report_run'), scene, 0.05)
        self.assertGreater(instructions, 500)
        self.assertGreater(shares['flow'], 0.3)
        self.assertEqual((shares['contact volumes'], shares['matrix']), (0, 0))

    def test_what_is_not_there_is_one_line(self):
        for words, line in (([], 'give the build folder'), (['/nowhere', 'rest'], 'no report_run below /nowhere')):
            done = subprocess.run([sys.executable, '-B', os.path.join(HERE, 'profile_steps.py'), *words], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1))
            self.assertIn(line, done.stderr)


@unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
class FailedMeansFailed(unittest.TestCase):
    """A cube that is launched although its program says ok: a cross with its reason, and no cell."""

    @classmethod
    def setUpClass(cls):
        program = programs.find(PROGRAMS, 'report_run')
        scene, = describe(program, ['rest'])
        cls.result = SceneResult(scene, True, ['bullet10'])
        cls.launched, cls.still, cls.loose = (Case('rest', method, 1e-3, 1e6, 0) for method in
                                              ('volume-verlet', 'volume-sdirk2', 'volume-implicit'))
        cls.result.cases, cls.result.references = [cls.launched, cls.still, cls.loose], {}
        exact = Case('rest', 'exact', 0, 0, 0)
        outputs = {exact: subprocess.run([program, 'rest', 'exact'], capture_output=True, text=True, check=True).stdout}
        for case, speed, unconverged in ((cls.launched, 4.0, 0), (cls.still, 0.0, 0), (cls.loose, 0.0, 3)):
            lines = [f'status ok\nreason \ntime_reached 1\nsteps 1000\ncpu_s 1e-3\nstep_p50_s 1e-6\nstep_p99_s 1e-6\nstep_p999_s 1e-6\n'
                     f'step_max_s 1e-6\nstep_touching_p50_s 1e-6\nallocations 0\niterations 0\niterations_worst 0\nevaluations_worst 0\nunconverged {unconverged}\n'
                     'energy_gain 0']
            for i in range(1, 21):
                t = i / 20
                z = 0.05 + max(0.0, speed * (t - 0.49))
                lines.append(f'sample {t} 0 0 0 0 0 0 0 0 1 0 0 {z} 1 0 0 0 0 0 0 0 0 {speed}')
            outputs[case] = '\n'.join(lines)
        cls.result.take({case: {'failure': '', 'output': output} for case, output in outputs.items()})

    def test_the_launched_cube_has_failed_with_its_reason_and_the_still_one_has_not(self):
        status = {run.case: (run.status, run.reason) for run in self.result.runs}
        self.assertEqual(status[self.launched], ('failed', 'a body is 2.04 m from the reference, more than 0.1 m'))
        self.assertEqual(status[self.still], ('ok', ''))
        self.assertEqual(status[self.loose], ('failed', '3 of 1000 steps did not converge'))
        self.assertEqual(self.result.beyond_bound(), 0)

    def test_it_wins_no_cell_although_it_turned_by_nothing(self):
        points = self.result.points()[('rest', 'orientation')]
        self.assertEqual([point.run.case for point in points], [self.still])

    def test_it_is_a_cross_in_the_plot_and_a_red_row_on_the_page(self):
        with tempfile.TemporaryDirectory() as folder:
            svg = figures.work_precision(self.result.scene, self.result.total, 'position', folder, self.result.is_default, {})
            self.assertIn('2 failed', svg)
            self.assertIn('role="img" aria-label="rest: total error: up position error [m], to the right CPU time per simulated second [s]"', svg)
            rows = page.later_table(['status'], [[run.status] for run in self.result.runs],
                                    [i for i, run in enumerate(self.result.runs) if run.status != 'ok'])
            self.assertEqual(page.shown_failures(rows), 2)


def toy_lines():
    return subprocess.run([sys.executable, '-B', os.path.join(HERE, 'toy_engine.py')], capture_output=True, text=True,
                          check=True).stdout.splitlines()


class OtherEngines(unittest.TestCase):
    """A program that the report does not know writes its runs into a file, and they count as those of any peer."""

    def read(self, lines, known=()):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'toy.jsonl')
            with open(path, 'w') as file:
                file.write('\n'.join(lines))
            return engine_results.read([path], known)

    def test_a_line_that_is_not_of_the_schema_is_refused_with_its_place(self):
        lines = toy_lines()
        good = json.loads(lines[0])

        def changed(**more):
            return json.dumps({**good, **more})
        for line, reason in (('{', 'Expecting'), ('[]', 'schema'), (changed(schema=2), 'schema'), (changed(setting='a-b'), 'a-z'),
                             (changed(status='fine'), 'fine'), (changed(step_s='1'), 'step_s'), (changed(licence=''), 'licence'),
                             (changed(pose=good['pose'][1:]), 'pose has not 20 x 1 x 7'), (changed(energy_j=[math.nan] * 20), 'energy_j'),
                             (changed(pose=[[[0, 0, 0, 1, 1, 0, 0]]] * 20), 'quaternion'),
                             (json.dumps({key: good[key] for key in good if key != 'twist' and key != 'time_s'}), "no 'time_s'"),
                             (lines[0], 'already')):
            with self.assertRaises(ValueError, msg=line) as caught:
                self.read([lines[0], '', line])
            self.assertIn('toy.jsonl:3: ', str(caught.exception))
            self.assertIn(reason, str(caught.exception))
        with self.assertRaisesRegex(ValueError, "one of the report's own"):
            self.read(lines, {'toy_exact'})

    @unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
    def test_the_toy_errs_as_its_formula_says_and_reaches_cells_with_times_of_this_machine_alone(self):
        program = programs.find(PROGRAMS, 'report_run')
        scene, = describe(program, ['slope_slide'])
        exact = Case('slope_slide', 'exact', 0, 0, 0)
        output = subprocess.run([program, 'slope_slide', 'exact'], capture_output=True, text=True, check=True).stdout
        lines = toy_lines()
        for told, here in ((lines, True), ([line.replace('"machine": "', '"machine": "another ') for line in lines], False)):
            outside = self.read(told)
            result = SceneResult(scene, True, [])
            result.cases, result.references = [], {}
            result.take({exact: {'failure': '', 'output': output}})
            for each in outside:
                engine_results.check_samples(each, scene)
            result.add([each.run for each in outside])
            self.assertEqual([peer['name'] for peer in engine_results.peers_of(outside)], ['toy_exact', 'toy_euler'])
            self.assertEqual({run.status for run in result.runs}, {'ok'})
            angle = math.atan(0.75)
            a = 9.8 * (math.sin(angle) - 0.5 * math.cos(angle))
            times = run_errors.np.arange(1, 21) / 40
            for run, errors in result.total:
                self.assertEqual(set(errors), {'position', 'orientation', 'velocity'})  # it does not say its energy
                h = 0.025 / round(0.025 / run.case.step)
                rms = a * h / 2 * math.sqrt((times ** 2).mean()) if run.case.method == 'toy_euler' else 0
                self.assertAlmostEqual(errors['position'], rms, delta=1e-13)  # 500 sums of up to 0.5
            cells = pareto.reached_cells(result.points(), cells=[('slope_slide', 'position', decade, False) for decade in range(-2, -12, -1)])
            self.assertEqual([pareto.verdict(cell) for cell in cells], ['only theirs'] * 10 if here else [])

    @unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
    def test_states_of_another_time_are_refused(self):
        scene, = describe(programs.find(PROGRAMS, 'report_run'), ['slope_slide'])
        line = json.loads(toy_lines()[0])
        line['time_s'] = [2 * time_ for time_ in line['time_s']]
        with self.assertRaisesRegex(ValueError, '20 samples to 0.5 s'):
            engine_results.check_samples(self.read([json.dumps(line)])[0], scene)

    @unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
    def test_it_stands_on_the_page_and_in_the_csv(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'toy.jsonl')
            with open(path, 'w') as file:
                file.write('\n'.join(toy_lines()))
            command = [sys.executable, '-B', os.path.join(HERE, 'report.py'), '--quick', '--programs', PROGRAMS, '--output',
                       os.path.join(folder, 'out'), '--results', path, 'slope_slide']
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(os.path.join(folder, 'out', 'report.html')) as file:
                text = file.read()
            self.assertIn('toy 1, BSD-3-Clause: a point mass that falls', text)
            self.assertIn('To hold a loop of 1 kHz', text)
            runs = [json.loads(block)['rows'] for block in re.findall(r'<script type="application/json">({"heads.*?)</script>', text)][-1]
            self.assertEqual({row[-1].split()[0] for row in runs}, {'slope_slide'})
            led = {int(index) for index in re.findall('href="#run=slope_slide:([0-9]+)"', text)}
            self.assertEqual(led, {i for i, row in enumerate(runs) if row[5] == 'ok'})
            again = runs[min(i for i in led if 'volume-automatic' in runs[i][0])][-1].split()
            done = subprocess.run([programs.find(PROGRAMS, 'report_run'), *again], capture_output=True, text=True, check=True)
            self.assertIn('status ok', done.stdout)
            with open(os.path.join(folder, 'out', 'report.csv'), newline='') as file:
                rows = [row for row in csv.DictReader(file) if row['model'] == 'toy_exact' and row['metric'] == 'position']
            self.assertEqual(len(rows), 3)
            self.assertLess(max(float(row['error']) for row in rows), 1e-13)
            with open(path, 'a') as file:
                file.write('\n{}')
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertNotEqual(done.returncode, 0)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)


@unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
class WholeReport(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        for name, k, v in (('drop', '1e6', '0 0 0'), ('escapes', '1e6', '0 0 1e5')):
            with open(os.path.join(cls.folder.name, name + '.urdf'), 'w') as file:
                file.write(SPHERE.format(name=name, k=k, v=v))
        cls.command = [sys.executable, '-B', os.path.join(HERE, 'report.py'), '--quick', '--programs', PROGRAMS, '--output',
                       os.path.join(cls.folder.name, 'out'), os.path.join(cls.folder.name, 'drop.urdf'),
                       os.path.join(cls.folder.name, 'escapes.urdf'), 'rest']
        # Interrupted after some runs, then resumed: the same report as an undisturbed one.
        first = subprocess.Popen(cls.command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        runs = os.path.join(cls.folder.name, 'out', 'runs')
        def finished():  # files: a run is being written beside them
            return [name for name in os.listdir(runs) if name.endswith('.json')] if os.path.isdir(runs) else []

        deadline = time.time() + 120
        while first.poll() is None and time.time() < deadline and len(finished()) < 5:
            time.sleep(0.05)
        first.send_signal(signal.SIGINT)
        cls.interrupted = first.communicate()[1]
        cls.interrupted_code = first.returncode
        cls.early = {name: os.stat(os.path.join(runs, name)).st_mtime_ns for name in finished()}
        done = subprocess.run(cls.command, capture_output=True, text=True, check=False)
        cls.output, cls.errors, cls.code = done.stdout, done.stderr, done.returncode
        cls.late = {name: os.stat(os.path.join(runs, name)).st_mtime_ns for name in os.listdir(runs)}
        cls.page = os.path.join(cls.folder.name, 'out', 'report.html')

    def figures(self):
        return {line.split()[1]: float(line.split()[2]) for line in self.output.splitlines() if line.startswith('figure ')}

    def text(self):
        with open(self.page) as file:
            return file.read()

    def test_interrupted_runs_resume(self):
        self.assertNotEqual(self.interrupted_code, 0)
        self.assertIn('goes on from there', self.interrupted.splitlines()[-1])
        self.assertEqual(self.code, 0, self.errors)
        self.assertGreaterEqual(len(self.early), 5)
        self.assertEqual({name: self.late[name] for name in self.early}, self.early)
        self.assertGreater(len(self.late), len(self.early))

    def test_figures_count_what_the_page_shows(self):
        figures, page = self.figures(), self.text()
        self.assertEqual(figures['report.scenes'], 3)
        self.assertEqual(figures['report.failed_runs_shown'], figures['report.failed_runs'])
        self.assertGreater(figures['report.failed_runs'], 0)
        self.assertEqual(figures['report.ok_runs_beyond_bound'], 0)
        blocks = re.findall(r'<div class="table later"><script type="application/json">(.*?)</script>', page, re.S)
        rows = {'method': [], 'metric': []}
        for block in map(json.loads, blocks):
            rows[block['heads'][0]] += block['rows']
        self.assertEqual(len(rows['method']), figures['report.runs'])
        verdicts = [row[6] for row in rows['metric']]
        self.assertEqual([verdicts.count(each) for each in ('won', 'lost')],
                         [figures['report.cells_all_won'], figures['report.cells_all_lost']])
        self.assertEqual(verdicts.count('won') + verdicts.count('lost') + verdicts.count('level'), figures['report.cells_contested'])

    def test_the_terminal_and_the_page_end_with_the_same_advice(self):
        lines = [line for line in self.output.splitlines() if line.startswith('drop: ')]
        self.assertEqual(len(lines), 1, self.output)
        self.assertIn('Write into the scene: <haptic:scene step="', lines[0])
        part = self.text().split('id="own-drop"')[1].split('<section')[0]
        self.assertIn(html.escape(lines[0].removeprefix('drop: ')), part)

    def test_a_scene_that_every_method_loses_says_so(self):
        part = self.text().split('id="scene-escapes"')[1].split('<section')[0]
        self.assertIn('Every method failed', part)

    def test_page_asks_for_nothing_from_outside(self):
        page = re.sub(r'xmlns(:\w+)?="[^"]*"', '', self.text())
        self.assertNotRegex(page, r'(src|href)="(?!#)')
        self.assertNotIn('@import', page)

    def test_csv_says_where_each_error_comes_from(self):
        with open(os.path.join(self.folder.name, 'out', 'report.csv'), newline='') as file:
            rows = list(csv.DictReader(file))
        for column in ('machine', 'commit', 'compiler', 'flags', 'scene', 'model', 'integrator', 'step_s', 'metric', 'error', 'unit',
                       'reference', 'step_p50_us', 'step_p99_us', 'step_p999_us', 'step_max_us', 'newton_worst', 'steps', 'allocations'):
            self.assertIn(column, rows[0])
        self.assertEqual({row['reference'] for row in rows if row['scene'] == 'rest' and row['error_kind'] == 'total'}, {'exact'})
        self.assertEqual({row['reference'] for row in rows if row['scene'] == 'drop' and row['error_kind']}, {'converged'})

    def test_our_steps_allocate_nothing(self):
        with open(os.path.join(self.folder.name, 'out', 'report.csv'), newline='') as file:
            ours = [row for row in csv.DictReader(file) if row['model'] in ('volume', 'point') and row['status'] == 'ok']
        self.assertGreater(len(ours), 10)
        self.assertEqual({row['allocations'] for row in ours}, {'0'})

    def test_the_default_of_the_plan_is_that_of_the_program(self):
        self.assertEqual(report_plan.DEFAULT, report_plan.default_method(programs.find(PROGRAMS, 'report_run')))

    def test_a_shipped_scene_is_known_by_its_name(self):
        scene, = describe(programs.find(PROGRAMS, 'report_run'), ['a_cube'])
        self.assertEqual(scene.source, os.path.join(programs.ROOT, 'urdf', 'scenes', 'a_cube.urdf'))

    def test_unknown_scene_is_one_line(self):
        done = subprocess.run(self.command[:-3] + ['no_such_scene'], capture_output=True, text=True, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn('no_such_scene', done.stderr)

    def test_headless_chromium_shows_sorts_and_turns_dark_at_both_widths(self):
        """A script added to a copy of the page acts as a reader and leaves what it saw in the title."""
        probe = '''<script>addEventListener('load', () => { const seen = {};
          const paper = () => getComputedStyle(document.body).backgroundColor;
          seen.light = paper(); document.getElementById('theme').click(); seen.dark = paper();
          const text = document.querySelector('figure svg text');
          seen.ink = text ? getComputedStyle(text).fill : 'none';
          seen.width = document.documentElement.scrollWidth - innerWidth;
          document.querySelectorAll('details').forEach(d => d.open = true);
          setTimeout(() => {
            seen.failed = document.querySelectorAll('tr.failed').length;
            const table = [...document.querySelectorAll('.later table.sortable')].filter(t => t.tBodies[0].rows.length > 9).pop();
            const head = [...table.querySelectorAll('th')].findIndex(h => h.textContent.startsWith('CPU'));
            table.querySelectorAll('th')[head].click();
            seen.keys = [...table.tBodies[0].rows].map(r => parseFloat(r.cells[head].dataset.key)).filter(isFinite);
            seen.explained = [...document.querySelectorAll('td[title]')].length;
            seen.wide = document.documentElement.scrollWidth - innerWidth;
            seen.svgs = [...document.querySelectorAll('figure svg')].map(s => s.getBoundingClientRect().height);
            document.title = JSON.stringify(seen); }, 500); });</script>'''
        copy = os.path.join(self.folder.name, 'probe.html')
        with open(copy, 'w') as file:
            file.write(self.text().replace('</body>', probe + '</body>'))
        for width in (1300, 700):
            done = subprocess.run(['chromium', '--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage',
                                   f'--window-size={width},900', '--user-data-dir=' + os.path.join(self.folder.name, 'profile'),
                                   '--virtual-time-budget=10000', '--dump-dom', 'file://' + copy],
                                  capture_output=True, text=True, timeout=120, check=False)
            title = re.search(r'<title>(.*?)</title>', done.stdout, re.S)
            self.assertIsNotNone(title, done.stderr[-1000:])
            seen = json.loads(title.group(1).replace('&quot;', '"'))
            self.assertEqual(seen['light'], 'rgb(255, 255, 255)')
            self.assertEqual(seen['dark'], 'rgb(20, 25, 30)')
            self.assertEqual(seen['ink'], 'rgb(223, 230, 236)', 'plots follow the theme')
            self.assertLessEqual(max(seen['width'], seen['wide']), 0, 'the page must not scroll sideways')
            self.assertEqual(seen['failed'], self.figures()['report.failed_runs'])
            self.assertGreater(seen['explained'], 20, 'names of methods are explained on hover')
            self.assertGreater(len(seen['keys']), 5)
            self.assertEqual(seen['keys'], sorted(seen['keys']))
            self.assertEqual(len(seen['svgs']), self.text().count('<svg'))
            self.assertGreater(min(seen['svgs']), 100)

    def test_labels_of_axes_differ(self):
        for svg in re.findall(r'<svg.*?</svg>', self.text(), re.S):
            labels = re.findall(r'<text [^>]*>([\d.e+−-]+)</text>', svg)
            self.assertGreater(len(set(labels)), 3, labels)


if __name__ == '__main__':
    unittest.main(verbosity=2)
