#!/usr/bin/python3
"""Results of studies: fits against scipy and known truths, presented stimuli against closed forms, sessions on disk."""
import json
import math
import os
import resource
import select
import signal
import sys
import tempfile
import unittest
from dataclasses import replace

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, 'haptic_bridge', 'experiment'), os.path.join(ROOT, 'penalty_sim', 'session'),
                os.path.join(ROOT, 'build', 'devel', 'lib', 'python3', 'dist-packages')]
import numpy as np  # noqa: E402
import force_check  # noqa: E402
import power  # noqa: E402
import presented  # noqa: E402
import psychometric  # noqa: E402
import results  # noqa: E402
import session_folder  # noqa: E402
import study as study_file  # noqa: E402
from event_markers import CODES, EventMarkers  # noqa: E402
from simulated_subject import JND_PER_WEBER, Percept  # noqa: E402
from strict_yaml import Refused  # noqa: E402
from trial_order import Order  # noqa: E402

FRICTION = os.path.join(ROOT, 'urdf', 'experiments', 'friction.yaml')


def percepts(number, lapses, sigma, trials, levels):
    """(x, count, positive) of simulated percepts with these lapse rates in turn."""
    random, x = np.random.default_rng(2), np.linspace(-levels * sigma, levels * sigma, 7)
    for i in range(number):
        yield x, np.full(7, float(trials // 7)), random.binomial(trials // 7, psychometric.probability(x, 0, sigma, lapses[i % len(lapses)]))


class Fits(unittest.TestCase):
    def test_the_posterior_is_that_of_another_quadrature(self):
        """Medians and ends of intervals against importance sampling with a million draws from the prior's box: its own error is known."""
        random = np.random.default_rng(4)
        x, n, k = np.array([-0.3, -0.1, 0.1, 0.3]), np.full(4, 20.0), np.array([2.0, 6.0, 15.0, 19.0])
        fit = psychometric.fit(x, n, k, 0.02)
        mu, log_sigma = random.uniform(-0.3, 0.3, 10**6), random.uniform(math.log(0.02), math.log(3), 10**6)
        lapse = np.minimum(random.beta(1, 49, 10**6), 0.15)
        p = psychometric.probability(x[:, None], mu, np.exp(log_sigma), lapse)
        log = (k[:, None] * np.log(p) + (n - k)[:, None] * np.log1p(-p)).sum(axis=0)
        weight = np.exp(log - log.max())
        order = np.argsort(log_sigma)
        ends = np.interp([0.025, 0.5, 0.975], np.cumsum(weight[order]) / weight.sum(), log_sigma[order])
        effective = weight.sum() ** 2 / (weight ** 2).sum()
        spread = math.sqrt(np.average((log_sigma - np.average(log_sigma, weights=weight)) ** 2, weights=weight))
        # A quantile at 2.5 % stands to 2.7 / sqrt(effective) standard deviations; the grid's cells are a tenth of one.
        room = spread * (3.3 * 2.7 / math.sqrt(effective) + 0.1)
        np.testing.assert_allclose(np.log(np.array([fit.jnd_interval[0], fit.jnd, fit.jnd_interval[1]]) / psychometric.QUARTILE), ends, atol=room)

    def test_much_data_give_the_function_back(self):
        x = np.linspace(-2, 2, 9)
        fit = psychometric.fit(x, np.full(9, 1e5), 1e5 * psychometric.probability(x, 0.3, 0.7, 0.04), 0.03)
        self.assertTrue(fit.identified)
        np.testing.assert_allclose((fit.pse, fit.jnd / psychometric.QUARTILE, fit.lapse), (0.3, 0.7, 0.04), atol=0.01)
        self.assertGreater(fit.fit_p, 0.5, 'the deviance of what was not even drawn is the least there is')

    def test_intervals_cover_and_bias_is_small(self):
        """Lapse rates of 0, 2 and 5 %, which the fit does not know, in turn."""
        true = 0.2 * psychometric.QUARTILE
        fits = [psychometric.fit(*data, 0.03) for data in percepts(240, (0.0, 0.02, 0.05), 0.2, 280, 2.5)]
        covered = sum(f.jnd_interval[0] <= true <= f.jnd_interval[1] for f in fits)
        self.assertGreaterEqual(covered, 216)  # of 240 at 95 %: P(fewer) = 0.001
        error = np.array([f.jnd / true - 1 for f in fits])
        self.assertLess(abs(error.mean()), 3.3 * error.std(ddof=1) / math.sqrt(240) + 0.02)

    def test_what_is_not_identified_is_said(self):
        self.assertIsNone(psychometric.fit([0.0, 1.0], [5, 5], [5, 5]))
        self.assertIsNone(psychometric.fit([0.0], [5], [2]))
        two = psychometric.fit([-0.5, 0.5], [1, 1], [0, 1], 0.02)      # a study of two usable trials
        self.assertEqual((two.identified, two.jnd_text()), (False, 'JND not identified'))
        self.assertTrue(math.isnan(two.jnd))
        apart = psychometric.fit([-0.5, -0.1, 0.1, 0.5], [9, 9, 9, 9], [0, 0, 9, 9], 0.02)   # any small sigma is as likely
        self.assertFalse(apart.identified)
        self.assertEqual(apart.jnd_interval[0], 0)
        self.assertTrue(0.03 < apart.jnd_interval[1] < 0.3, apart.jnd_interval)
        self.assertIn('not identified, at most', apart.jnd_text())
        flat = psychometric.fit([-0.5, -0.1, 0.1, 0.5], [40] * 4, [20, 19, 21, 20], 0.02)    # answers do not follow x
        self.assertEqual((flat.identified, flat.jnd_interval[1]), (False, math.inf))

    def test_a_curve_that_does_not_fit_is_found_out(self):
        x = np.linspace(-1, 1, 7)
        steps = psychometric.fit(x, np.full(7, 60.0), 60 * np.array([0.1, 0.1, 0.9, 0.5, 0.1, 0.9, 0.9]), 0.02)
        self.assertLess(steps.fit_p, 0.01)

    def test_the_band_holds_the_curve(self):
        data = next(percepts(1, (0.02,), 0.2, 280, 2.5))
        low, middle, high = psychometric.fit(*data, 0.03).band(data[0])
        self.assertTrue((low < middle).all() and (middle < high).all())
        share, error = data[2] / data[1], np.sqrt(0.25 / data[1])
        self.assertTrue((np.abs(share - middle) < 4 * error).all())


class Adapted(unittest.TestCase):
    def method(self, name, **more):
        rules = study_file.Adaptive('stiffness', name, 2.0, **{'levels': 24, 'max_trials': 60, 'least_trials': 10, 'width': 0.0, **more})
        return psychometric.Adaptive(rules, 0.03)

    def run_method(self, method, sigma, seed):
        random, x, y = np.random.default_rng(seed), [], []
        while not method.done:
            x.append(method.next_level())
            y.append(random.random() < psychometric.probability(x[-1], 0.0, sigma, 0.0))
            method.answer(x[-1], y[-1])
        return np.array(x), np.array(y)

    def test_each_level_tells_most(self):
        """The information of each level by its definition: the expected fall of the posterior's entropy."""
        for name in ('psi', 'quest_plus'):
            method = self.method(name)
            for level, answer in ((0.3, True), (-0.2, False), (0.1, True)):
                method.answer(level, answer)
            w = method.posterior.weights().ravel()
            entropy = lambda v: float(-(v[v > 0] * np.log(v[v > 0])).sum())  # noqa: E731
            told = []
            for x in method.x:
                p = method.posterior.p(x).ravel()
                after = [w * p, w * (1 - p)]
                told.append(entropy(w) - sum(float(a.sum()) * entropy(a / a.sum()) for a in after))
            self.assertEqual(method.next_level(), float(method.x[int(np.argmax(told))]), name)

    def test_it_finds_what_fixed_levels_find_in_fewer_trials(self):
        fixed, widths = [psychometric.fit(*data, 0.03) for data in percepts(30, (0.0,), 0.1, 56, 6.9)], {}
        for name in ('psi', 'quest_plus'):
            fits = []
            for seed in range(30):
                x, y = self.run_method(self.method(name, max_trials=56), 0.1, seed)
                fits.append(psychometric.fit(*psychometric.grouped(x, y), 0.03))
            found = [f.jnd for f in fits if f.identified]
            self.assertGreaterEqual(len(found), 28, name)
            self.assertAlmostEqual(float(np.median(found)) / (0.1 * psychometric.QUARTILE), 1, delta=0.15, msg=name)
            widths[name] = np.median([f.jnd_interval[1] / max(f.jnd_interval[0], 1e-9) for f in fits])
        wide = np.median([f.jnd_interval[1] / max(f.jnd_interval[0], 1e-9) for f in fixed])
        for name, width in widths.items():
            self.assertLess(width, wide, name)

    def test_it_ends_where_the_interval_is_narrow_enough(self):
        method = self.method('psi', max_trials=400, width=0.6)
        self.run_method(method, 0.1, 1)
        self.assertLess(method.trials, 400)
        self.assertLessEqual(method.width(), 0.6)
        self.assertEqual(self.run_method(self.method('psi', max_trials=30), 0.1, 1)[0].size, 30)

    def test_a_session_goes_on_in_its_order(self):
        text = Tasks.HEAD + 'task: two_interval\nadaptive: {parameter: stiffness, greatest: 1.8, max_trials: 25}\npractice: 2\n'
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
            file.write(text)
            file.flush()
            study = study_file.read(file.name)
        rows = power.session_rows(study, 's01', power.nominal_felt(study), Percept(0.1, 0.0, np.random.default_rng(1)))
        self.assertEqual(len(rows), 27)
        answers = [{'1': True, '0': False}.get(r['correct']) for r in rows]
        order = Order(study, 's01')
        for n in (0, 2, 10, 26):
            self.assertEqual(repr(order.next(answers[:n]).condition['stiffness']), rows[n]['level'])
        self.assertEqual({r['comparison'] for r in rows}, {'1', '2'})
        fit, _ = results.fit_rows(study, power.counted(study, rows))
        self.assertTrue(fit.identified)


    def test_a_percept_of_known_noise_is_found_again(self):
        """The whole way from order to JND, without a loop: constant stimuli and a staircase."""
        for name, weber in (('friction', 0.15), ('stiffness', 0.1)):
            study = study_file.read(os.path.join(ROOT, 'urdf', 'experiments', name + '.yaml'))
            found = []
            for number in range(20):
                percept = Percept(weber, study.lapse, np.random.default_rng(number))
                rows = power.session_rows(study, f's{number + 1}', power.nominal_felt(study), percept)
                x, y = results.judged(study, power.counted(study, rows))
                fit = psychometric.fit(*psychometric.grouped(x, y), study.lapse)
                if fit.identified:
                    found.append(fit.jnd)
                self.assertLess(abs(fit.pse), 4 * weber)
            self.assertGreaterEqual(len(found), 19)
            mean, error = np.mean(found), np.std(found, ddof=1) / math.sqrt(len(found))
            self.assertLess(abs(mean / (JND_PER_WEBER * weber) - 1), 3.3 * error / mean + 0.06, name)


class Tasks(unittest.TestCase):
    """Each kind of task from its file to its results."""
    HEAD = 'study: 1\ntitle: A\ninstructions: B\nscene: pad\ntarget: [pad, pointer]\nquestion: Q\nstandard: {stiffness: 1e7}\n'

    def rows(self, text, weber=0.1):
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
            file.write(self.HEAD + text)
            file.flush()
            study = study_file.read(file.name)
        percept = Percept(weber, 0.0, np.random.default_rng(1))
        answer = percept.answer
        percept.answer = lambda study, felt: answer(study, felt, study.standard['stiffness'])
        return study, power.session_rows(study, 's01', power.nominal_felt(study), percept)

    def test_two_answers_to_one_interval(self):
        for task, words in (('yes_no', ['no', 'yes']), ('two_alternative', ['soft', 'stiff'])):
            study, rows = self.rows(f'task: {task}\nanswers: [{", ".join(words)}]\nfactors: {{stiffness: [0.7e7, 0.93e7, 1.08e7, 1.4e7]}}\n'
                                    'repetitions: 100\n')
            self.assertEqual({r['response'] for r in rows}, set(words))
            x, y = results.judged(study, power.counted(study, rows))
            fit = psychometric.fit(*psychometric.grouped(x, y), study.lapse)
            # Two levels on the slope and two beyond it tell it from lapses. 400 trials leave log sigma to 8 % and mu to 0.1 sigma; three of them, and what the lapses that may be leave open.
            self.assertAlmostEqual(math.log(fit.jnd / psychometric.QUARTILE / 0.1), 0, delta=0.3)
            self.assertLess(abs(fit.pse), 0.03)
            for row in rows:
                greater = float(row['level']) > 1e7
                self.assertEqual(row['correct'], str(int((row['response'] == words[1]) == greater)))

    def test_magnitudes_are_proportional(self):
        study, rows = self.rows('task: magnitude\nfactors: {stiffness: [1e7, 2e7]}\nrepetitions: 50\n')
        found = results.magnitudes(study, [{**r, 'condition': r['level']} for r in power.counted(study, rows)])
        one, two = (found[repr(v)] for v in (1e7, 2e7))
        self.assertAlmostEqual(math.log(two[1] / one[1]), math.log(2), delta=3.3 * math.hypot(one[2], two[2]) + 0.01)  # answers of 3 digits
        self.assertEqual((one[0], two[0]), (50, 50))

    def test_exploration_asks_nothing(self):
        study, rows = self.rows('task: exploration\nfactors: {stiffness: [1e7, 2e7]}\nrepetitions: 3\n')
        self.assertEqual({(r['response'], r['correct']) for r in rows}, {('', '')})
        self.assertEqual(len(power.counted(study, rows)), 6)

    def test_catch_trials_are_seen_apart(self):
        study = study_file.read(FRICTION)
        rows = power.session_rows(study, 's01', power.nominal_felt(study), Percept(0.05, 0.0, np.random.default_rng(1)))
        catch = [r for r in rows if r['trial_type'] == 'catch']
        self.assertEqual(len(catch), len([r for r in rows if r['trial_type'] == 'main']) // study.catch_every)
        self.assertEqual({r['correct'] for r in catch}, {'1'})
        self.assertEqual(sum(r in power.counted(study, rows) for r in catch), 0)


class Presented(unittest.TestCase):
    def samples(self, position, force, contact=None):
        n = len(position)
        return presented.Samples(np.arange(n) * 1e-3, position, force, np.ones(n, bool) if contact is None else contact,
                                 np.zeros(n, np.uint32), np.ones(n), np.ones(n))

    def test_stiffness_of_a_damped_pad_in_any_direction(self):
        t = np.arange(2000) * 1e-3
        depth, speed = 2e-3 * (1 - np.cos(6 * t)), 12e-3 * np.sin(6 * t)
        normal = np.array([0.6, 0, 0.8])
        # Hunt and Crossley: F = K d (1 + a d'); differences over 20 ms of a motion at 6 rad/s are 6e-4 small, times a d' of 0.12.
        force = 1500 * depth * (1 + 10 * speed)
        found = presented.stiffness(self.samples(np.array([0.3, 0, 1]) - depth[:, None] * normal, force[:, None] * normal))
        self.assertAlmostEqual(found.value / 1500, 1, delta=3e-4)
        self.assertLess(abs(found.value - 1500), 5 * found.error + 0.5)

    def test_an_added_delay_and_faded_ticks_leave_the_slope(self):
        t = np.arange(2000) * 1e-3
        way = lambda t: 2e-3 * (1 - np.cos(6 * t))  # noqa: E731
        position = np.stack([0 * t, 0 * t, -way(t)], axis=1)
        force = np.stack([0 * t, 0 * t, 1500 * way(t - 0.02)], axis=1)
        late = self.samples(position, force)
        # Between rows 1 ms apart a motion at 6 rad/s is straight to (6e-3)^2 / 8 = 5e-6.
        self.assertAlmostEqual(presented.presented('stiffness', late, {}, delay=0.02).value / 1500, 1, delta=1e-3)
        # Without, the terms in x' take the lag to first order: a phase of 0.12 rad leaves its square.
        self.assertGreater(abs(presented.presented('stiffness', late, {}).value / 1500 - 1), 3e-3)
        # After an interruption the force comes back over half a second.
        fade = np.where((t > 0.7) & (t < 1.2), 0.25 + 1.5 * (t - 0.7), 1.0)
        faded = replace(self.samples(position, 1500 * (fade * way(t))[:, None] * [0, 0, 1]), fade=fade)
        self.assertAlmostEqual(presented.stiffness(faded).value / 1500, 1, delta=1e-3)
        self.assertGreater(abs(presented.stiffness(replace(faded, fade=np.ones(2000))).value / 1500 - 1), 0.02, 'they would show')
        self.assertAlmostEqual(presented.faded_share(faded), 0.25, delta=2e-3)

    def test_friction_is_read_where_the_tip_slides(self):
        t = np.arange(2000) * 1e-3
        x, v = 0.01 * np.sin(6 * t), 0.06 * np.cos(6 * t)
        n = 1 + 0.3 * np.sin(2 * t)
        # Before it slides the tip is held by less than mu: a spring of 2 mm after each turn.
        position = np.stack([x, 0 * x, 0 * x], axis=1)
        strained = np.clip(presented.way_since_turn(self.samples(position, position), np.stack([v, 0 * v, 0 * v], axis=1)) / 1.9e-3, 0, 1)
        force = np.stack([-np.sign(v) * 0.4 * n * strained, 0 * n, n], axis=1)
        found = presented.friction(self.samples(position, force), (0, 0, 1))
        self.assertAlmostEqual(found.value, 0.4, delta=1e-12)
        naive = np.abs(force[:, 0]).sum() / n.sum()
        self.assertGreater(abs(naive - 0.4), 0.01, 'the turns would show')

    def test_mass_takes_the_acceleration_off(self):
        t = np.arange(3000) * 1e-3
        height, acceleration = 0.01 * (1 - np.cos(2 * t)), 0.04 * np.cos(2 * t)
        force = np.stack([0 * t, 0 * t, -0.2 * (9.8 + acceleration)], axis=1)
        found = presented.mass(self.samples(np.stack([0 * t, 0 * t, height], axis=1), force), 9.8)
        self.assertAlmostEqual(found.value, 0.2, delta=0.2 * 1e-5)  # differences over 20 ms: (2 · 0.01)² / 6 of 0.04 m/s², over g: 3e-7

    def test_no_touch_is_no_number(self):
        free = self.samples(np.zeros((100, 3)), np.zeros((100, 3)), np.zeros(100, bool))
        for measure in ('stiffness', 'friction', 'mass'):
            self.assertTrue(math.isnan(presented.presented(measure, free, {}).value), measure)


class Twin(unittest.TestCase):
    def test_the_shipped_conditions_are_presented(self):
        """On the whole twin, without a clock: what the strings give is what the conditions say."""
        import loop_rig
        import preview
        # Cable forces are solved to 0.1 %, and one press of 2 mm with a tremor of 0.1 mm tells a slope to 0.5 %.
        for name, most in (('stiffness', 0.01), ('friction', 0.001), ('weight', 0.01)):
            study = study_file.read(os.path.join(ROOT, 'urdf', 'experiments', name + '.yaml'))
            with tempfile.TemporaryDirectory() as folder:
                previews = preview.Previews(study, loop_rig.LoopRig(study.device), folder)
                for condition in [study.standard, {**study.standard, **study.conditions[-1]}]:
                    look = previews.of(condition)
                    self.assertAlmostEqual(look.presented.value / look.nominal, 1, delta=most, msg=f'{name} {condition}')
                    self.assertEqual((look.clamps, look.share), ([], 1.0))


class ForceCheck(unittest.TestCase):
    """The push of a device before a block: what is refused, and the way of a simulated hand."""
    @staticmethod
    def pushes(stiffness=500.0, give=lambda push: push, turn=lambda way: way):
        """Of a hand of that stiffness [N/m] on a device that gives `give` of each push and moves the grip by `turn` of its way."""
        out = []
        for push in force_check.PUSHES.astype(float):
            way = turn(0.8 * give(push) / stiffness)
            along = float(way @ push)
            out.append(force_check.Push(list(push), 0.8, float(0.8 * give(push) @ push), along, float(np.linalg.norm(way - along * push))))
        return out

    def test_what_is_refused_and_what_is_warned_of(self):
        self.assertEqual(force_check.judged(self.pushes()), ('', ''))
        for name, pushes, refused, part in (
                ('mirrored', self.pushes(turn=lambda way: way * [1, -1, 1]), True, '-1.6 mm along'),
                ('axes exchanged', self.pushes(turn=lambda way: way[[1, 0, 2]]), True, 'across'),
                ('two strings pull nothing', self.pushes(turn=lambda way: np.array([min(way[0], 0), way[1], way[2]])), True, 'did not move'),
                ('no power', self.pushes(turn=lambda way: 0 * way), True, 'did not move'),
                ('weak', self.pushes(give=lambda push: 0.8 * push), False, 'the strings give 0.64 N'),
                ('a firm hand', self.pushes(stiffness=4000.0), False, 'more loosely')):
            said = force_check.judged(pushes)
            self.assertEqual((said[0] != '', said[1] != ''), (refused, not refused), name)
            self.assertIn(part, said[0] + said[1], name)
            self.assertNotIn('\n', said[0] + said[1])

    def test_a_relaxed_hand_gives_way_as_its_spring_says(self):
        import haptic
        with tempfile.TemporaryDirectory() as folder:
            for push, scene in zip(force_check.PUSHES, force_check.scenes(0.8, 1000, folder)):
                loop = haptic.Loop(scene, 'spidar_g6x3r', 1000)
                loop.hands[0].move_to(np.eye(4))
                loop.tick(3000)
                hand = loop.hands[0]
                # 500 N/m, the twin's hand; of the force lambda keeps 1 %, and a count is 17 um of a string.
                np.testing.assert_allclose(hand.truth[:3, 3], 0.8 / 500 * push, atol=0.01 * 0.8 / 500 + 17e-6)
                np.testing.assert_allclose(hand.achieved[3:], 0.8 * push, atol=0.01)


class Folders(unittest.TestCase):
    def setUp(self):
        self.root = tempfile.TemporaryDirectory()
        self.addCleanup(self.root.cleanup)
        self.study = study_file.read(FRICTION)

    def folder(self, **options):
        words = {'subject': 's01', 'session': 1, 'seed': None, **options}
        made = session_folder.SessionFolder(self.root.name, words.get('study', self.study), words['subject'], words['session'],
                                            words['seed'], {})
        self.addCleanup(made.lock.close)
        return made

    def close(self, folder):
        folder.lock.close()

    def test_rows_are_read_back(self):
        folder = self.folder()
        folder.append({'trial': 1, 'order': 0, 'status': 'ok', 'correct': 1, 'note': 'a, "b"\nc', 'level': 0.1})
        self.close(folder)
        again = self.folder()
        self.assertEqual((again.answers(), again.next_trial(), again.rows[0]['note']), ([True], 2, 'a, "b" c'))
        with open(os.path.join(again.path, 'trials.json'), encoding='utf-8') as file:
            self.assertEqual(list(json.load(file)), list(session_folder.COLUMNS))

    def test_time_goes_on_after_a_kill(self):
        folder = self.folder()
        folder.append({'trial': 1, 'order': 0, 'status': 'ok', 'correct': 1, 'onset': 5.0, 'duration': 3.5})
        folder.running({'trial': 2, 'order': 1, 'onset': 9.25})
        self.close(folder)
        self.assertEqual(self.folder().elapsed(), 9.25, 'where the trial began that ran when the program was killed')

    def test_a_torn_row_is_the_interrupted_trial(self):
        folder = self.folder()
        folder.append({'trial': 1, 'order': 0, 'status': 'ok', 'correct': 1})
        folder.running({'trial': 2, 'order': 1})
        with open(folder.table, 'ab') as table:
            table.write(b'2,0.1,3')
        self.close(folder)
        again = self.folder()
        self.assertEqual([(r['trial'], r['status']) for r in again.rows], [('1', 'ok'), ('2', 'interrupted')])
        self.assertEqual((len(again.answers()), again.next_trial()), (1, 3))
        self.close(again)
        self.assertEqual(self.folder().rows, again.rows, 'as it stands on disk, and once is enough')

    def test_what_does_not_fit_is_refused_in_one_line(self):
        folder = self.folder(seed=3)
        with self.assertRaisesRegex(Refused, 'another program runs this session'):
            self.folder()
        self.close(folder)
        with self.assertRaisesRegex(Refused, 'seed 3, not 4'):
            self.folder(seed=4)
        other = study_file.read(FRICTION)
        other.text += '# changed\n'
        with self.assertRaisesRegex(Refused, 'another text'):
            self.folder(study=other)
        with self.assertRaisesRegex(Refused, 'pseudonym'):
            self.folder(subject='Ann Lee')
        folder = self.folder()
        folder.finish(True)
        self.close(folder)
        with self.assertRaisesRegex(Refused, 'is complete'):
            self.folder()

    def test_a_full_disk_loses_nothing(self):
        folder = self.folder()
        folder.append({'trial': 1, 'order': 0, 'status': 'ok', 'correct': 1})
        size = os.path.getsize(folder.table)
        before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size + 7, before[1][1]))
        try:
            with self.assertRaises(Refused) as caught:
                folder.append({'trial': 2, 'order': 1, 'status': 'ok', 'correct': 1})
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before[1])
            signal.signal(signal.SIGXFSZ, before[0])
        self.assertNotIn('\n', str(caught.exception))
        self.assertEqual(os.path.getsize(folder.table), size)
        folder.append({'trial': 2, 'order': 1, 'status': 'ok', 'correct': 0})
        self.assertEqual(folder.answers(), [True, False])


class Markers(unittest.TestCase):
    def test_a_byte_on_the_line_and_a_message(self):
        line, terminal = os.openpty()
        said = []
        markers = EventMarkers(os.ttyname(terminal), lambda *words: said.append(words[1:]))
        for event in CODES:
            self.assertEqual(markers.send(event, 3), '')
        arrived = b''
        while len(arrived) < len(CODES) and select.select([line], [], [], 10)[0]:  # the terminal hands them on in its own time
            arrived += os.read(line, 100)
        self.assertEqual(list(arrived), list(CODES.values()))
        self.assertEqual(said, [(code, event, 3) for event, code in CODES.items()])
        os.close(line)
        os.close(terminal)

    def test_no_line_is_refused(self):
        with self.assertRaisesRegex(Refused, 'marker-port'):
            EventMarkers('/dev/null')


if __name__ == '__main__':
    unittest.main()
