#!/usr/bin/python3
"""A study on motor boards, in a process of their own on a pseudo-terminal: the device is unplugged in mid-trial and plugged in again, and
strings on the wrong motors do not pass the force check."""
import os
import re
import select
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, 'test', 'commands'), os.path.join(ROOT, 'haptic_bridge', 'experiment')]
import session_folder  # noqa: E402
from event_markers import CODES  # noqa: E402
from run_verb import RUN, Call  # noqa: E402

STUDY = """study: 1
title: Two pads
instructions: Press.
scene: pad
target: [pad, pointer]
device: spidar_g6x5r
rate: 500
task: two_interval
question: Stiffer?
standard: {stiffness: 1e7}
factors: {stiffness: [0.5e7, 2e7]}
repetitions: 2
order: fixed
phases: {home_seconds: 0.05, explore_seconds: 1.0, respond_seconds: 60, pause_seconds: 0}
"""
LIMIT = 300  # [s] for each event; some take ten on an idle machine, and a busy one ends trial after trial by its own silence
DEVICE = os.path.join(ROOT, 'urdf', 'devices', 'spidar_g6x5r.yaml')


class Unplugged(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.session = os.path.join(self.folder, 'pads', 'sub-s01', 'ses-1')
        port, self.control = os.path.join(self.folder, 'boards'), os.path.join(self.folder, 'control')
        boards = subprocess.Popen([os.path.join(ROOT, 'build', 'devel', 'lib', 'spidar_driver', 'spidar_board_emulator'), '--device', DEVICE,
                                   '--link', port, '--control', self.control], stdout=subprocess.DEVNULL)
        self.addCleanup(self.end, boards)
        self.until(lambda: os.path.exists(port) and os.path.exists(self.control), 'the boards')
        study = os.path.join(self.folder, 'pads.yaml')
        with open(study, 'w', encoding='utf-8') as file:
            file.write(STUDY)
        self.words = ['experiment', study, '--subject', 's01', '--port', port, '--output', self.folder]
        self.line, self.terminal = os.openpty()

    def begin(self, *more):
        self.log = open(os.path.join(self.folder, 'log'), 'w+', encoding='utf-8')
        self.addCleanup(self.log.close)
        self.run_ = subprocess.Popen([RUN, *self.words, '--marker-port', os.ttyname(self.terminal), *more], stdin=subprocess.PIPE,
                                     stdout=self.log, stderr=self.log, text=True)
        self.addCleanup(self.end, self.run_)
        self.type('')  # the instructions were read
        self.until(lambda: 'goes on when the device is ready' in self.said(), 'a device that is not calibrated')
        self.assertIn('no force yet', self.said())
        self.waited = 1
        self.type('c', 'p')

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.terminate()
            process.wait(30)
        if process.stdin:
            process.stdin.close()

    def said(self):
        with open(self.log.name, encoding='utf-8', errors='replace') as file:
            return file.read()

    def rows(self):
        return session_folder.rows_of(os.path.join(self.session, 'trials.csv'))[0]

    def until(self, ready, what):
        end = time.monotonic() + LIMIT
        while time.monotonic() < end:
            found = ready()
            if found:
                return found
            time.sleep(0.05)
        return self.fail(f'{what} did not come: {self.said()[-2000:]}')

    def type(self, *keys):
        for key in keys:
            self.run_.stdin.write(key + '\n')
            self.run_.stdin.flush()

    def order(self, text):
        with open(self.control, 'w', encoding='utf-8') as control:
            control.write(text + '\n')

    def go_on(self):
        """Whenever the program waits for the device: on a busy machine the boards' process may be silent for longer than a board may be,
        and boards that were plugged in take a while to be in step."""
        waits = self.said().count('goes on when the device is ready')
        if waits > self.waited:
            self.waited = waits
            time.sleep(1)
            self.type('p')

    def until_marker(self, name):
        def heard():
            self.go_on()
            return select.select([self.line], [], [], 0)[0] and bytes([CODES[name]]) in os.read(self.line, 64)
        self.until(heard, name)

    def whole(self):
        return [r for r in self.rows() if r['status'] == 'ok']

    def answered(self, count):
        """Rows of `count` whole trials."""
        while len(self.whole()) < count:
            before = len(self.rows())
            self.until_marker('question')
            self.type('1')
            self.until(lambda before=before: len(self.rows()) > before, 'the row of the answer')
        return self.whole()

    def test_one_trial_is_marked_and_repeated_and_nothing_is_lost(self):
        self.begin()
        first = self.answered(1)[0]
        self.assertEqual(first['response'], 'first', self.said())
        self.until_marker('interval_1')
        before = self.rows()
        self.order('unplug')
        lost = self.until(lambda: self.rows()[len(before):], 'the row of the trial that lost its device')[0]
        self.assertEqual(lost['status'], 'unplugged')
        lines = [line for line in self.said().splitlines() if f"trial {lost['trial']} unplugged" in line]
        self.assertEqual(len(lines), 1, self.said())
        self.assertIn('it is repeated', lines[0])
        self.assertEqual(self.rows()[:len(before)], before, 'what was complete is as it was')
        self.order('plug')
        # A busy machine may silence the boards and cost another trial before or after: the lost one is that of its order.
        while not (again := [r for r in self.whole() if r['order'] == lost['order']]):
            self.answered(len(self.whole()) + 1)
        self.assertEqual([r['condition'] for r in again], [lost['condition']])
        complete = len(self.whole()) == 4
        self.type('q')
        self.assertEqual(self.run_.wait(LIMIT), 0 if complete else 3, self.said())
        replay = Call('replay', self.session, '--trial', first['trial'])
        self.assertEqual((replay.code, replay.figures().get('replay.mismatches')), (0, 0), replay.errors)

    def test_strings_that_do_not_pull_are_refused(self):
        with open(DEVICE, encoding='utf-8') as file:
            text = file.read()
        wrong = os.path.join(self.folder, 'wrong.yaml')
        with open(wrong, 'w', encoding='utf-8') as file:  # the motors of two strings at the same knot, which pull to +x, turn the wrong way
            for line in text.splitlines():
                file.write((line.replace(', invert_drive: true', '') if 'knot: [0.015, 0, 0]' in line else line) + '\n')
        self.begin('--device', wrong)
        def refused():
            self.go_on()
            return [r for r in self.rows() if 'the force check failed' in r['note']]
        self.assertEqual(self.until(refused, 'the row of the trial before which the device was checked')[0]['status'], 'stopped')
        self.assertNotIn('First interval', self.said())
        self.type('q')
        self.assertEqual(self.run_.wait(LIMIT), 3, self.said())


if __name__ == '__main__':
    unittest.main()
