#!/usr/bin/python3
"""The pool of processes behind the report: it survives what runs do to it, here and on a cluster."""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from task_pool import Kept, Task, run_tasks  # noqa: E402


class Pool(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.kept = Kept(os.path.join(self.folder.name, 'runs'))

    def run_all(self, commands, **options):
        tasks = [Task(f'key{i}', tuple(command), 2, 1.0) for i, command in enumerate(commands)]
        return [run_tasks(tasks, self.kept, 'test', **options)[task.key] for task in tasks]

    def test_a_process_that_is_killed_is_repeated_and_others_lose_nothing(self):
        flag = os.path.join(self.folder.name, 'died')
        dies_once = ['sh', '-c', f'if [ -e {flag} ]; then echo done; else touch {flag}; kill -KILL $$; fi']
        first, second = self.run_all([dies_once, ['echo', 'other']])
        self.assertEqual((first['output'], first['attempts'], first['failure']), ('done\n', 2, ''))
        self.assertEqual(second['output'], 'other\n')

    def test_failures_are_results_with_a_reason(self):
        fails, loops, absent = self.run_all([['sh', '-c', 'echo no such contact >&2; exit 3'],
                                             ['sh', '-c', 'while :; do :; done'], ['/no/such/program']])
        self.assertEqual(fails['failure'], 'no such contact')
        self.assertIn('CPU time', loops['failure'])
        self.assertIn('No such file', absent['failure'])

    def test_what_is_finished_is_not_run_again(self):
        count = os.path.join(self.folder.name, 'count')
        self.run_all([['sh', '-c', f'echo x >> {count}']])
        self.run_all([['sh', '-c', f'echo x >> {count}']])
        with open(count) as file:
            self.assertEqual(file.read(), 'x\n')

    def test_an_interrupted_pool_ends_its_processes_and_starts_none(self):
        starts = os.path.join(self.folder.name, 'starts')

        def interrupt(*_):
            if not os.path.exists(starts):
                signal.setitimer(signal.ITIMER_REAL, 0.1)
                return
            raise KeyboardInterrupt
        before = signal.signal(signal.SIGALRM, interrupt)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with self.assertRaises(KeyboardInterrupt):
            self.run_all([['sh', '-c', f'echo x >> {starts}; exec sleep 1000']])
        with open(starts) as file:
            self.assertEqual(file.read(), 'x\n')

    def test_a_cluster_runs_the_same_tasks_and_survives_the_death_of_a_worker(self):
        file = os.path.join(self.folder.name, 'scheduler.json')
        environment = {**os.environ, 'DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT': '10s'}
        common = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL, 'env': environment}

        def module(name, *more):
            process = subprocess.Popen([sys.executable, '-c', f'from distributed.cli import {name} as m; m.main()',
                                        '--scheduler-file', file, *more], **common)
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
            return process
        module('dask_scheduler', '--port', '0', '--no-dashboard', '--host', '127.0.0.1')
        workers = [module('dask_worker', '--nthreads', '1', '--no-nanny', '--no-dashboard', '--local-directory',
                          os.path.join(self.folder.name, f'worker{i}')) for i in range(2)]
        deadline = time.time() + 60
        while not os.path.exists(file):
            self.assertLess(time.time(), deadline, 'no scheduler')
            time.sleep(0.1)
        with open(file) as text:
            address = json.load(text)['address']
        victim = workers[0].pid
        # One task takes its worker along, once; it and the others must all come back.
        flag = os.path.join(self.folder.name, 'killed')
        kills = ['sh', '-c', f'if [ -e {flag} ]; then echo survived; else touch {flag}; kill -KILL {victim}; sleep 1; fi']
        results = self.run_all([kills] + [['echo', str(i)] for i in range(8)], scheduler=address)
        self.assertEqual([result['output'].strip() for result in results[1:]], [str(i) for i in range(8)])
        self.assertIn(results[0]['output'].strip(), ('survived', ''))
        self.assertEqual(results[0]['failure'], '')


if __name__ == '__main__':
    unittest.main(verbosity=2)
