#!/usr/bin/python3
"""Studies as files: strict reading, orders, staircases, condition scenes."""
import collections
import glob
import itertools
import math
import os
import random
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, 'haptic_bridge', 'experiment'))
import condition_scene  # noqa: E402
import study as study_file  # noqa: E402
import trial_order  # noqa: E402
from strict_yaml import Refused  # noqa: E402

GOOD = """study: 1
title: A
instructions: Press.
scene: pad
target: [pad, pointer]
task: two_interval
question: Stiffer?
standard: {stiffness: 1e7}
factors:
  stiffness: [0.8e7, 1e7, 1.3e7]
repetitions: 4
blocks: 2
"""
STAIRCASE = """study: 1
title: A
instructions: Press.
scene: pad
target: [pad, pointer]
task: two_interval
question: Stiffer?
standard: {stiffness: 1e7}
staircase: {parameter: stiffness, start: 2, steps: [1.3, 1.1], down: 2, up: 1, reversals: 400, discard: 20, max_trials: 2000, tracks: 1}
"""


def read(text):
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
        file.write(text)
        file.flush()
        return study_file.read(file.name)


class Reading(unittest.TestCase):
    def test_shipped_studies(self):
        paths = glob.glob(os.path.join(ROOT, 'urdf', 'experiments', '*.yaml'))
        self.assertEqual(len(paths), 4)
        for path in paths:
            self.assertTrue(study_file.read(path).title)

    def test_errors_name_file_line_and_what(self):
        cases = [('blocks: 2', 'blocs: 2', 12, 'blocs'), ('repetitions: 4', 'repetitions: 0', 11, '1 to 1000'),
                 ('repetitions: 4', 'repetitions: many', 11, "'many'"), ('1.3e7]', 'x]', 10, "'x'"), ('1.3e7]', '1e7]', 10, 'twice'),
                 ('stiffness: [', 'hardness: [', 10, 'hardness'), ('task: two_interval', 'task: three', 6, 'three'),
                 ('scene: pad', 'scene: nowhere', 4, 'nowhere'), ('standard: {stiffness: 1e7}', 'standard: {mass: 1}', 6, 'no stiffness'),
                 ('[0.8e7, 1e7, 1.3e7]', '[0.8e7, -1]', 10, '-1'), ('blocks: 2', 'blocks: 2.5', 12, 'whole'),
                 ('blocks: 2', 'blocks: 2\nblocks: 2', 13, 'twice'), ('blocks: 2', 'blocks: .inf', 12, 'finite'),
                 ('target: [pad, pointer]\n', '', 4, 'target'), ('blocks: 2', 'blocks: [', 13, 'YAML')]
        read(GOOD)
        for old, new, line, word in cases:
            self.assertIn(old, GOOD)
            with self.assertRaises(Refused, msg=new) as caught:
                read(GOOD.replace(old, new))
            message = str(caught.exception)
            self.assertRegex(message, rf'\.yaml:{line}: .*', new)
            self.assertIn(word, message)
            self.assertNotIn('\n', message)

    def test_any_key_that_goes_missing_or_is_misspelt_is_one_line(self):
        choose = random.Random(1)
        lines = GOOD.splitlines()
        for _ in range(300):
            broken = [list(line) for line in lines]
            row = choose.choice(broken)
            row[choose.randrange(len(row))] = choose.choice(':{}[]-x1 #')
            try:
                read('\n'.join(map(''.join, broken)) + '\n')
            except Refused as refusal:
                self.assertNotIn('\n', str(refusal))


class AddedDelays(unittest.TestCase):
    TEXT = GOOD.replace('{stiffness: 1e7}', '{stiffness: 1e7, force_delay: 0.0}').replace(
        'stiffness: [0.8e7, 1e7, 1.3e7]', 'force_delay: [0.0, 0.0054, 0.02]')

    def test_a_delay_is_in_whole_ticks_and_in_the_scene(self):
        study = read(self.TEXT)
        self.assertEqual([round(1e3 * study.added_delay(c), 9) for c in study.conditions], [0, 5, 20])
        self.assertEqual(study.added_delay({'pose_delay': 0.01, 'force_delay': 0.02, 'rate': 250.0}), 8 / 250)
        with open(study.scene, encoding='utf-8') as file:
            root = xml.fromstring(condition_scene.changed_text(study.scene, file.read(), study.target, study.conditions[2]))
        pointer = root.find(condition_scene.tag('pointer'))
        self.assertEqual((float(pointer.get('force_delay')), pointer.get('pose_delay')), (0.02, None))

    def test_bounds(self):
        with self.assertRaises(Refused) as caught:
            read(self.TEXT.replace('0.02]', '0.3]'))
        self.assertIn('0 to 0.2', str(caught.exception))


class Orders(unittest.TestCase):
    def test_random_numbers_are_splitmix64(self):
        generator = trial_order.Generator('x')
        generator.state = 1234567  # the first two of the reference implementation for this state
        self.assertEqual([generator.bits(), generator.bits()], [6457827717110365317, 3203168211198807973])

    def test_below_is_uniform(self):
        generator = trial_order.Generator('uniform')
        counts = collections.Counter(generator.below(7) for _ in range(70000))
        chi2 = sum((n - 10000) ** 2 / 10000 for n in counts.values())
        self.assertEqual(set(counts), set(range(7)))
        self.assertLess(chi2, 22.5)  # 6 degrees of freedom, p = 0.001

    def test_all_arrangements_come_equally_often(self):
        generator = trial_order.Generator('shuffled')
        counts = collections.Counter(tuple(generator.shuffled('abcd')) for _ in range(24000))
        self.assertEqual(len(counts), 24)
        self.assertLess(sum((n - 1000) ** 2 / 1000 for n in counts.values()), 49.7)  # 23 degrees of freedom, p = 0.001

    def test_order_is_a_function_of_study_subject_session_and_seed(self):
        study = read(GOOD)
        names = lambda *words: [(t.name(study), t.comparison) for t in trial_order.Order(study, *words).plan]  # noqa: E731
        self.assertEqual(names('s01', 1, 5), names('s01', 1, 5))
        self.assertEqual(len({repr(names(*w)) for w in (('s01', 1, 5), ('s02', 1, 5), ('s01', 2, 5), ('s01', 1, 6))}), 4)

    def test_each_condition_comes_as_often_and_in_both_intervals(self):
        study = read(GOOD)
        plan = trial_order.Order(study, 's01').plan
        for condition, comparison in itertools.product((0.8e7, 1e7, 1.3e7), (0, 1)):
            self.assertEqual(sum(t.condition['stiffness'] == condition and t.comparison == comparison for t in plan), 4)
        for block in (1, 2):
            self.assertEqual(sum(t.block == block for t in plan), 12)

    def test_latin_squares_are_balanced(self):
        for count in range(2, 9):
            rows = [trial_order.williams_row(count, r) for r in range(count if count % 2 == 0 else 2 * count)]
            for place in range(count):
                self.assertEqual(set(collections.Counter(row[place] for row in rows).values()), {len(rows) // count})
            follows = collections.Counter(pair for row in rows for pair in zip(row, row[1:]))
            self.assertEqual(len(follows), count * (count - 1))
            self.assertEqual(len(set(follows.values())), 1, f'{count}: first-order carry-over')

    def test_latin_square_over_subjects(self):
        study = read(GOOD.replace('repetitions: 4', 'repetitions: 1\norder: latin').replace('blocks: 2', 'blocks: 1'))
        first = [trial_order.Order(study, f's{i:02d}').plan[0].condition['stiffness'] for i in range(1, 7)]
        self.assertEqual(set(collections.Counter(first).values()), {2})

    def test_rates_are_blocks(self):
        study = study_file.read(os.path.join(ROOT, 'urdf', 'experiments', 'update_rate.yaml'))
        plan = trial_order.Order(study, 's01').plan
        for block, trials in itertools.groupby(plan, key=lambda t: t.block):
            self.assertEqual(len({t.condition['rate'] for t in trials}), 1, block)


class Staircases(unittest.TestCase):
    def converges(self, down, up=1):
        """Share right at the mean level of the reversals of one long track."""
        study = read(STAIRCASE.replace('down: 2', f'down: {down}'))
        order, choose, answers = trial_order.Order(study, 's01'), random.Random(down), []
        track = trial_order.Staircase(study.staircase)
        right = lambda level: 0.5 + 0.5 * math.erf(math.log(level) / 0.3)  # noqa: E731
        del order, answers
        while not track.done:
            track.answer(choose.random() < right(track.level))
        return right(track.threshold()), 0.5 ** (1 / down), track

    def test_it_settles_at_the_point_that_its_rule_says(self):
        # The mean of reversals of small steps lies on the point up to the step (10 % of the logarithm, +-0.03 in share here).
        for down in (1, 2, 3):
            share, oracle, _ = self.converges(down)
            self.assertAlmostEqual(share, oracle, delta=0.03, msg=down)

    def test_interleaved_tracks_go_on_from_their_answers_alone(self):
        study = read(STAIRCASE.replace('reversals: 400, discard: 20', 'reversals: 6, discard: 2').replace('tracks: 1', 'tracks: 2'))
        order, choose, answers, seen = trial_order.Order(study, 's01'), random.Random(3), [], []
        own = {t: trial_order.Staircase(study.staircase) for t in (1, 2)}
        while (trial := order.next(answers)) is not None:
            self.assertEqual(trial.level, own[trial.track].level, 'each track hears the answers to its own trials')
            seen.append((trial.track, round(trial.level, 12), trial.comparison))
            answers.append(choose.random() < 0.75)
            own[trial.track].answer(answers[-1])
        self.assertEqual({t for t, _, _ in seen}, {1, 2})
        again = trial_order.Order(study, 's01')
        for n in (0, 3, len(answers) // 2, len(answers) - 1):  # as after a kill
            trial = again.next(answers[:n])
            self.assertEqual((trial.track, round(trial.level, 12), trial.comparison), seen[n])
        tracks, _ = order.tracks(answers)
        self.assertTrue(all(len(t.reversals) >= 6 for t in tracks.values()))


class ConditionScenes(unittest.TestCase):
    def root(self, name, **condition):
        path = os.path.join(ROOT, 'urdf', 'experiments', 'scenes', name + '.urdf')
        with open(path, encoding='utf-8') as file:
            return xml.fromstring(condition_scene.changed_text(path, file.read(), [name], condition))

    def test_only_what_is_named_changes(self):
        root = self.root('pad', stiffness=2e7, friction=0.7)
        pad, pointer = (root.find(f"link[@name='{n}']/collision/{condition_scene.tag('contact')}") for n in ('pad', 'pointer'))
        self.assertEqual((float(pad.get('stiffness')), float(pad.get('mu_static')), float(pad.get('mu_dynamic'))), (2e7, 0.7, 0.7))
        self.assertEqual((float(pointer.get('stiffness')), float(pointer.get('mu_static'))), (1e7, 0.3))

    def test_mass_takes_the_inertia_along(self):
        link = self.root('tray', mass=0.5).find("link[@name='tray']/inertial")
        self.assertEqual(float(link.find('mass').get('value')), 0.5)
        self.assertAlmostEqual(float(link.find('inertia').get('ixx')), 1e-4 * 0.5 / 0.2, delta=1e-15)

    def test_modulus_takes_the_place_of_stiffness(self):
        contact = self.root('pad', young_modulus=1e6).find(f"link[@name='pad']/collision/{condition_scene.tag('contact')}")
        self.assertEqual((contact.get('stiffness'), float(contact.get('young_modulus'))), (None, 1e6))

    def test_what_is_seen_may_differ_from_what_is_felt(self):
        hidden, moved = self.root('pad', shown='false'), self.root('pad', seen_offset=0.003)
        self.assertEqual(hidden.find("link[@name='pad']/visual/material/color").get('rgba').split()[-1], '0')
        self.assertIn('0.003', moved.find("link[@name='pad']/visual/origin").get('xyz'))
        self.assertIsNone(moved.find("link[@name='pad']/collision/origin"))

    def test_an_unknown_link_is_named(self):
        with self.assertRaises(Refused) as caught:
            condition_scene.changed_text('x.urdf', '<robot name="a"><link name="b"/></robot>', ['c'], {'mass': 1.0})
        self.assertIn("'c'", str(caught.exception))


if __name__ == '__main__':
    unittest.main()
