#!/usr/bin/python3
"""Robots of the report in ours, Bullet and MuJoCo against their exact motions. `robot_peers_test.py BUILD_FOLDER`."""
import os
import subprocess
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
import programs  # noqa: E402
import run_errors  # noqa: E402

WASM = os.environ['HAPTIC_WASM_PEERS'] = programs.fetched_wasm_peers()
PROGRAMS = sys.argv.pop(1)


class RobotPeers(unittest.TestCase):
    def samples(self, *words):
        done = subprocess.run([programs.find(PROGRAMS, 'report_run'), *words], capture_output=True, text=True, check=True)
        return run_errors.parse_samples(done.stdout.splitlines())

    def error(self, peer, scene, step, *more):
        run = self.samples(scene, peer, repr(step), *more, '--budget', '0')
        return float(abs(run.pose[..., :3] - self.samples(scene, 'exact').pose[..., :3]).max())

    def test_trees_of_links_move_as_lagranges_equations_say(self):
        # The reference is in absolute angles, by Runge and Kutta. Between forces ours and Bullet's accurate setting are of fourth order, the
        # others of first; with drives all are of first. Half of what the order takes off in a quarter of the step is room for the next term.
        for scene, method, order in (('swinging_chain', 'volume-automatic', 4), ('swinging_chain', 'bullet200_firm', 4),
                                     ('swinging_chain', 'bullet10', 1), ('swinging_chain', 'mujoco_firm', 1), ('arm_load', 'volume-automatic', 1),
                                     ('arm_load', 'bullet10', 1), ('arm_load', 'bullet200_firm', 1), ('arm_load', 'mujoco_firm', 1)):
            self.assertGreater(self.error(method, scene, 1e-3), 0.5 * 4 ** order * self.error(method, scene, 2.5e-4), (scene, method))

    def test_trees_of_links_start_with_the_accelerations_of_the_exact_equations(self):
        # Velocities after a step of 1 ps over its length: masses, moments of inertia, joint axes and drives are the same in all engines.
        # A drive's damper (D h/I, 30 N m s/rad on .1 kg m^2) errs by 3e-10; what rounding leaves, below 1e-13.
        step = '1e-12'

        def twist(scene, *words):
            return self.samples(scene, *words, '--seconds', step, '--samples', '1').twist
        for scene in ('swinging_chain', 'arm_load'):
            exact = twist(scene, 'exact')
            for method in ('volume-automatic', 'volume-verlet', 'bullet10', 'bullet200_firm', 'bullet_dantzig', 'mujoco_euler', 'mujoco_rk4',
                           'mujoco_firm') + (('mujoco3_euler', 'mujoco3_firm') if WASM else ()):
                off = abs(twist(scene, method, step, '--budget', '0') - exact).max() / abs(exact).max()
                self.assertLess(off, 1e-9, (scene, method))

    def test_a_quadruped_stands_where_its_drives_hold_it(self):
        # Ours sinks by its feet's foundation, which is soft here; .8 mm in 0.5 m.
        for method in ('volume-automatic', 'bullet10', 'mujoco_firm'):
            self.assertLess(self.error(method, 'quadruped_stands', 1e-3), 1e-3, method)

    def test_a_quadruped_walks_along_its_path_the_better_the_shorter_the_step(self):
        # A third of the step leaves a third of the error; ours has k of 1e17 N/m^3, in which feet sink by 60 nm.
        for method, more in (('volume-automatic', ('1e17',)), ('bullet10', ()), ('mujoco_firm', ())):
            coarse, fine = (self.error(method, 'quadruped_walks', step, *more) for step in (1e-3, 1e-3 / 3))
            self.assertLess(coarse, 2e-3, method)
            self.assertLess(fine, coarse / 2, method)

    def test_a_hand_holds_a_bar_where_its_drives_hold_it(self):
        # Without friction, or with other efforts, the bar falls by 20 m in 2 s. Rigid ours sinks by a few millionths of the tips' 12 mm
        # and of the bar's 50 mm each; ten iterations of Bullet leave .2 mm, fifty nothing, and MuJoCo creeps.
        for method, more in (('volume-automatic', ('rigid',)), ('bullet50', ()), ('mujoco_firm', ())):
            self.assertLess(self.error(method, 'hand_grasp', 1e-3, *more), 1e-5, method)


if __name__ == '__main__':
    unittest.main(verbosity=2)
