#!/usr/bin/python3
"""The subject's and the experimenter's window, on a display of their own, by real keys and clicks: answers, STOP, a pause, the end; and the scene
that fills the subject's screen."""
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, 'test', 'commands'), os.path.join(ROOT, 'haptic_bridge', 'experiment')]
import numpy as np  # noqa: E402
import session_folder  # noqa: E402
from run_verb import RUN  # noqa: E402
from windows import BUTTONS_AT  # noqa: E402

STUDY = """study: 1
title: Two pads
instructions: Wait.
scene: pad
target: [pad, pointer]
task: two_interval
question: Which pad was stiffer?
standard: {stiffness: 1e7}
factors: {stiffness: [0.5e7, 2e7]}
repetitions: 3
order: fixed
phases: {home_seconds: 0.05, explore_seconds: 0.2, respond_seconds: 60, pause_seconds: 0}
"""
WIDTH, HEIGHT = 1280, 800  # of the screen [pixels]
LIMIT = 300  # [s] for each event: it takes a second or two on an idle machine


HOOK = """
import os, sys, threading, time

def watched(run):
    from PyQt5.QtCore import QEvent, QObject, Qt

    class Watch(QObject):
        begin, drawn = None, set()

        def eventFilter(self, widget, event):
            if event.type() == QEvent.KeyPress and event.key() == Qt.Key_Escape and self.begin is None:
                self.begin, self.drawn = time.monotonic(), set()
            elif event.type() == QEvent.Paint and self.begin is not None and type(widget).__name__ == 'Banner':
                self.drawn.add(id(widget))
                if len(self.drawn) == 2:
                    with open(os.environ['STUDY_TIMES'], 'a') as file:
                        file.write(f'{time.monotonic() - self.begin}\\n')
                    self.begin = None
            return False

    def run_watched(front, work):
        front.watch = Watch()
        front.application.installEventFilter(front.watch)
        return run(front, work)
    return run_watched

def wait():
    while not hasattr(sys.modules.get('windows'), 'WindowFront'):
        time.sleep(0.002)
    front = sys.modules['windows'].WindowFront
    front.run = watched(front.run)

if 'STUDY_TIMES' in os.environ and any('experiment.py' in word for word in sys.orig_argv):
    threading.Thread(target=wait, daemon=True).start()
"""


class Windows(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        number, out = os.pipe()
        self.server = subprocess.Popen(['Xvfb', '-displayfd', str(out), '-screen', '0', f'{WIDTH}x{HEIGHT}x24', '-nolisten', 'tcp'],
                                       pass_fds=[out], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(out)
        with os.fdopen(number) as told:
            self.display = ':' + told.readline().strip()
        self.addCleanup(self.end, self.server)
        self.session = os.path.join(self.folder.name, 'pads', 'sub-s01', 'ses-1')
        study = os.path.join(self.folder.name, 'pads.yaml')
        with open(study, 'w', encoding='utf-8') as file:
            file.write(STUDY)
        self.log = open(os.path.join(self.folder.name, 'log'), 'w+', encoding='utf-8')
        self.addCleanup(self.log.close)
        self.words = [RUN, 'experiment', study, '--subject', 's01', '--output', self.folder.name]

        self.times = os.path.join(self.folder.name, 'times')
        open(self.times, 'w', encoding='utf-8').close()
        # Python loads this at its start (site, user base): it notes in the program itself how long a banner takes from the key on.
        hook = os.path.join(self.folder.name, 'lib', f'python{sys.version_info[0]}.{sys.version_info[1]}', 'site-packages', 'usercustomize.py')
        os.makedirs(os.path.dirname(hook))
        with open(hook, 'w', encoding='utf-8') as file:
            file.write(HOOK)

    def begin(self, *words):
        self.run = subprocess.Popen(self.words + list(words), stdin=subprocess.DEVNULL, stdout=self.log, stderr=self.log,
                                    env={**os.environ, 'DISPLAY': self.display, 'LIBGL_ALWAYS_SOFTWARE': '1', 'QT_X11_NO_MITSHM': '1',
                                         'PYTHONUSERBASE': self.folder.name, 'STUDY_TIMES': self.times})
        self.addCleanup(self.end, self.run)

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            process.wait(30)

    def x(self, *words):
        done = subprocess.run(['xdotool', *words], env={**os.environ, 'DISPLAY': self.display}, capture_output=True, text=True, check=False)
        return done.stdout.split()

    def until(self, ready, what):
        end = time.monotonic() + LIMIT
        while time.monotonic() < end:
            found = ready()
            if found:
                return found
            self.assertIsNone(self.run.poll(), f'{what}: it has ended: {self.said()}')
            time.sleep(0.1)
        return self.fail(f'{what} did not come: {self.said()}')

    def said(self):
        self.log.seek(0)
        return self.log.read()[-2000:]

    def rows(self):
        return session_folder.rows_of(os.path.join(self.session, 'trials.csv'))[0]

    def key(self, window, *keys):
        self.x('windowfocus', '--sync', window)
        self.x('key', '--window', window, *keys)

    def click(self, window, x, y):
        self.x('mousemove', '--window', window, str(x), str(y), 'click', '1')

    def answer(self, window, key, number):
        """Presses the key until the row is there: before the question it does nothing."""
        def pressed():
            self.key(window, key)
            return len(self.rows()) >= number
        self.until(pressed, f'row {number}')

    def picture(self):
        """Of the whole screen, height x width x 3."""
        done = subprocess.run(['import', '-window', 'root', '-depth', '8', 'rgb:-'], env={**os.environ, 'DISPLAY': self.display},
                              stdout=subprocess.PIPE, check=True)
        return np.frombuffer(done.stdout, np.uint8).reshape(HEIGHT, WIDTH, 3).astype(int)

    def geometry(self, window):
        found = re.findall(r'(X|Y|WIDTH|HEIGHT)=(-?\d+)', '\n'.join(self.x('getwindowgeometry', '--shell', window)))
        return {name: int(value) for name, value in found}

    def test_the_scene_fills_the_subjects_screen_below_its_text(self):
        self.begin('--rviz')
        subject = self.until(lambda: self.x('search', '--name', '^study$'), 'the subject\'s window')[0]
        experimenter = self.until(lambda: self.x('search', '--name', '^experimenter$'), 'the experimenter\'s window')[0]
        view = self.until(lambda: self.x('search', '--onlyvisible', '--name', 'study.rviz'), 'the scene\'s window')[0]
        self.until(lambda: self.geometry(view) == {'X': 0, 'Y': 0, 'WIDTH': WIDTH, 'HEIGHT': HEIGHT}, 'a scene on the whole screen')
        strip, beside = self.geometry(subject), self.geometry(experimenter)
        self.assertEqual((strip['X'], strip['Y'] + strip['HEIGHT']), (0, HEIGHT))
        self.assertLess(strip['HEIGHT'], HEIGHT // 3)
        self.assertLessEqual(strip['X'] + strip['WIDTH'], beside['X'], 'no window of the two hides the other')
        orange = lambda shot: ((shot[..., 0] > 2 * shot[..., 2] + 40) & (shot[..., 0] > shot[..., 1] + 30))[:strip['Y']].sum()  # noqa: E731
        text = lambda shot: (shot[strip['Y']:, :strip['WIDTH']].min(axis=2) > 200).sum()  # noqa: E731
        self.key(subject, 'space')  # the instructions were read
        self.until(lambda: orange(self.picture()) > 200, 'the tip above the pad')
        self.until(lambda: text(self.picture()) > 200, 'the text above the scene')
        grey = self.picture()[:strip['Y'], :beside['X']]
        self.assertEqual((grey.min(axis=2) > 200).sum(), 0, 'no menu, tool or number is beside the scene')
        # A click gives the scene the keys; the subject's text has them back soon after, and they go where the display sends them.
        self.x('mousemove', '300', '200', 'click', '1')
        self.until(lambda: self.x('getwindowfocus', '-f') == [subject], 'the keys back at the subject\'s text')

        def answered():
            self.x('key', '2')
            return [row for row in self.rows() if row['status'] == 'ok']
        self.assertEqual(self.until(answered, 'a trial that was answered')[0]['response'], 'second')
        self.click(experimenter, 9 * beside['WIDTH'] // 10, BUTTONS_AT)
        self.assertEqual(self.run.wait(LIMIT), 3, self.said())
        self.until_gone('study.rviz')

    def until_gone(self, name):
        end = time.monotonic() + LIMIT
        while self.x('search', '--name', name) and time.monotonic() < end:
            time.sleep(0.1)
        self.assertEqual(self.x('search', '--name', name), [])

    def stop_is_seen_in_both(self, window, both):
        """Esc: a red banner in either window; how long from the key's arrival in one to the later drawing."""
        before, count = [self.red(each) for each in both], len(self.seen())
        self.key(window, 'Escape')
        self.until(lambda: all(self.red(each) > was + 2000 for each, was in zip(both, before)), 'STOP in both windows')
        return self.until(lambda: self.seen()[count:], 'the time of the drawing')[0]

    def red(self, window):
        """Pixels of a banner in it."""
        place, shot = self.geometry(window), self.picture()
        part = shot[max(0, place['Y']):place['Y'] + place['HEIGHT'], max(0, place['X']):place['X'] + place['WIDTH']]
        return int(((part[..., 0] > 150) & (part[..., 1:].max(axis=2) < 40)).sum())

    def seen(self):
        with open(self.times, encoding='utf-8') as file:
            return [float(line) for line in file]

    def test_a_session_by_keys_and_clicks(self):
        self.begin('--windows')
        subject = self.until(lambda: self.x('search', '--name', '^study$'), 'the subject\'s window')[0]
        experimenter = self.until(lambda: self.x('search', '--name', '^experimenter$'), 'the experimenter\'s window')[0]
        self.x('windowmove', experimenter, '760', '420')
        time.sleep(3)
        self.assertEqual(self.rows(), [], 'the instructions stay until a key says that they were read')
        self.key(subject, 'space')
        self.answer(subject, '2', 1)
        self.answer(subject, '1', 2)
        first, second = self.rows()[:2]
        self.assertEqual([r['response'] for r in (first, second)], ['second', 'first'])
        self.assertGreater(float(first['response_time']), 0)
        # Each row is right where it names the comparison's interval and that is stiffer, or the other one and it is softer.
        for row in (first, second):
            greater = (row['response'] == 'second') == (row['comparison'] == '2')
            self.assertEqual(row['correct'], str(int(greater == (float(row['level']) > 1e7))))
        both = (subject, experimenter)
        longest = self.stop_is_seen_in_both(subject, both)
        self.until(lambda: len(self.rows()) >= 3, 'the row of the trial that STOP ended')
        self.assertEqual(self.rows()[2]['status'], 'stopped')
        self.key(subject, 'space')  # after STOP the experimenter alone goes on, here by a key
        time.sleep(1)
        self.assertEqual(len(self.rows()), 3)
        self.until(lambda: self.key(experimenter, 'space') or self.red(subject) < 2000, 'a session that goes on by a key')
        longest = max(longest, self.stop_is_seen_in_both(experimenter, both))
        print(f'figure study.stop_seen_ms_max {1e3 * longest:.0f} ms')
        self.until(lambda: len(self.rows()) >= 4, 'the row of the second trial that STOP ended')
        geometry = dict(re.findall(r'(WIDTH|HEIGHT)=(\d+)', '\n'.join(self.x('getwindowgeometry', '--shell', experimenter))))
        width = int(geometry['WIDTH'])
        self.click(experimenter, width // 10, BUTTONS_AT)
        self.answer(subject, '1', 5)
        self.assertEqual({row['order'] for row in self.rows()[2:5]}, {self.rows()[2]['order']}, 'the trial that was stopped comes again')
        self.click(experimenter, 9 * width // 10, BUTTONS_AT)
        self.assertEqual(self.run.wait(LIMIT), 3, self.said())
        self.assertIn('the same command goes on', self.said())


if __name__ == '__main__':
    unittest.main()
