#!/usr/bin/python3
"""Rows of runs: one process for all steps of a setting changes no run, and one that dies takes no other along."""
import os
import signal
import subprocess
import sys
import unittest

PROGRAMS = sys.argv.pop(1) if len(sys.argv) > 1 and os.path.isdir(sys.argv[1]) else None
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import programs  # noqa: E402
from report_plan import CPU_LIMIT, Case, cases_of, describe, is_reference, parts_of, rows_of, task_of  # noqa: E402
from run_errors import parse_run  # noqa: E402

ROW = tuple(Case('rest', 'ode_quick10', step, 0, 0) for step in (1e-2, 1e-3, 1e-4))


def program():
    return programs.find(PROGRAMS, 'report_run')


def run(*words):
    return subprocess.run([program(), *words], capture_output=True, text=True, check=True).stdout


class Rows(unittest.TestCase):
    def test_a_run_that_dies_is_the_only_one_that_is_lost(self):
        output = 'run 0.01\nstatus ok\nend\nrun 0.001\nstatus o'
        for code, failure, reason in ((-signal.SIGXCPU, 'took more than 150 s of CPU time', f'took more than {CPU_LIMIT} s of CPU time'),
                                      (-signal.SIGSEGV, 'killed by SIGSEGV', 'killed by SIGSEGV'), (0, '', 'printed nothing')):
            parts = parts_of(ROW, {'output': output, 'code': code, 'failure': failure}, quick=False)
            self.assertEqual(list(parts), list(ROW[:2]))
            self.assertEqual((parts[ROW[0]]['failure'], parts[ROW[1]]['failure']), ('', reason))
            self.assertIn('status ok', parts[ROW[0]]['output'])

    @unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
    def test_rows_hold_each_case_once_with_one_setting_and_falling_steps(self):
        scene, = describe(program(), ['rest'])
        cases = cases_of(scene, False, ['ode_quick10', 'jolt'])
        rows = rows_of(cases)
        self.assertCountEqual([case for row in rows for case in row], cases)
        self.assertLess(len(rows), len(cases) / 3)
        for row in rows:
            self.assertEqual(len({(*case._replace(step=0), is_reference(case)) for case in row}), 1)
            self.assertEqual(sorted(row, key=lambda case: -case.step), list(row))

    @unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
    def test_the_runs_of_a_row_are_those_that_each_process_alone_makes(self):
        scene, = describe(program(), ['rest'])
        for method in ('ode_quick10', 'bullet50', 'volume-automatic'):  # ODE's rows are shuffled
            row = tuple(case._replace(method=method) for case in ROW)
            command = task_of(row, program(), 'stamp', False, scene).command
            parts = parts_of(row, {'output': run(*command[1:]), 'code': 0, 'failure': ''}, False)
            for case in row:
                alone = parse_run(case, {'output': run('rest', method, repr(case.step), '--budget', '0'), 'failure': ''})
                together = parse_run(case, parts[case])
                self.assertEqual((together.status, together.steps), ('ok', round(scene.seconds / case.step)))
                self.assertTrue((together.trajectory.pose == alone.trajectory.pose).all(), f'{method} at {case.step} s')

    @unittest.skipUnless(PROGRAMS, 'needs the build folder of the programs')
    def test_a_run_that_would_take_far_longer_than_it_may_fails_early_and_says_so(self):
        output = run('rest', 'volume-verlet', '1e-6,1e-3', '--limit', '1')  # a million steps of no less than 2 µs
        hopeless, short = (parse_run(Case('rest', 'volume-verlet', step, 0, 0), {'output': part, 'failure': ''})
                           for step, part in zip((1e-6, 1e-3), output.split('\nrun ')))
        self.assertEqual((hopeless.status, short.status), ('failed', 'ok'))
        self.assertRegex(hopeless.reason, '^would take [0-9]+ s of CPU time, more than 1 s$')


if __name__ == '__main__':
    unittest.main(verbosity=2)
