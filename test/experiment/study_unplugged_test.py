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
LIMIT = 120  # [s] for each event; some take ten on an idle machine
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
        self.until(lambda: 'no force yet' in self.said(), 'a device that is not calibrated')
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

    def until_marker(self, name):
        def heard():
            return select.select([self.line], [], [], 0)[0] and bytes([CODES[name]]) in os.read(self.line, 64)
        self.until(heard, name)

    def answer(self, count):
        self.until_marker('question')
        self.type('1')
        self.until(lambda: len(self.rows()) >= count, f'row {count}')

    def test_one_trial_is_marked_and_repeated_and_nothing_is_lost(self):
        self.begin()
        self.answer(1)
        first = self.rows()[0]
        self.assertEqual((first['status'], first['response']), ('ok', 'first'), self.said())
        self.until_marker('interval_1')
        self.order('unplug')
        self.until(lambda: len(self.rows()) >= 2, 'the row of the trial that lost its device')
        self.assertEqual([r['status'] for r in self.rows()], ['ok', 'unplugged'])
        lines = [line for line in self.said().splitlines() if 'trial 2 unplugged' in line]
        self.assertEqual(len(lines), 1, self.said())
        self.assertIn('it is repeated', lines[0])
        self.assertEqual(self.rows()[0], first, 'what was complete is as it was')
        self.order('plug')
        # Boards that kept their power go on counting. Who asks before they are in step hears so, and asks again.
        for _ in range(20):
            self.type('p')
            before = self.said()
            self.until(lambda before=before: self.said() != before, 'an answer')
            time.sleep(1)
            if 'no force yet: DISCONNECTED' not in self.said()[len(before):]:
                break
        self.until_marker('question')
        self.type('1')
        self.until(lambda: len(self.rows()) >= 3, 'the row of the repeated trial')
        third = self.rows()[2]
        self.assertEqual((third['status'], third['order'], third['condition']),
                         ('ok', self.rows()[1]['order'], self.rows()[1]['condition']))
        self.type('q')
        self.assertEqual(self.run_.wait(LIMIT), 3, self.said())
        again = Call('replay', self.session, '--trial', '1')
        self.assertEqual((again.code, again.figures().get('replay.mismatches')), (0, 0), again.errors)

    def test_strings_that_do_not_pull_are_refused(self):
        with open(DEVICE, encoding='utf-8') as file:
            text = file.read()
        wrong = os.path.join(self.folder, 'wrong.yaml')
        with open(wrong, 'w', encoding='utf-8') as file:  # the motors of two strings at the same knot, which pull to +x, turn the wrong way
            for line in text.splitlines():
                file.write((line.replace(', invert_drive: true', '') if 'knot: [0.015, 0, 0]' in line else line) + '\n')
        self.begin('--device', wrong)
        self.until(lambda: self.rows(), 'the row of the trial before which the device was checked')
        self.assertEqual(self.rows()[0]['status'], 'stopped', self.said())
        self.assertIn('the force check failed', self.rows()[0]['note'])
        self.assertNotIn('First interval', self.said())
        self.type('q')
        self.assertEqual(self.run_.wait(LIMIT), 3, self.said())


if __name__ == '__main__':
    unittest.main()
