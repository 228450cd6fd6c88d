"""Runs one session, trial by trial: home, intervals, question, row on disk."""
import dataclasses
import math
import os
import queue
import time

import numpy as np

import condition_scene
import force_check
import session_data
from presented import faded_share, presented
from session_folder import ACCEPTED
from simulated_subject import Percept, SimulatedHand
from stack_rig import HAND_PERIOD, SOFT_START, TrialEnded
from strict_yaml import Refused
from trial_order import Generator

SETTLED = 0.1          # beyond it [s]
HOME_CHECK = 0.1       # the grip rests at home for so long before it is pushed [s]
HOME_PATIENCE = 5.0    # a simulated hand is home long before [s]
LIFTED = 0.2           # without touch for so long: lifted off [s]
LEAST_TOUCH = 0.05     # [N]
MOST_RESIDUAL = 2e-3   # rms of the string lengths' errors: beyond it the pose is not good enough for a study [m]
MOTOR_HOT = 1 << session_data.FLAGS.index('MotorHot')
RECOVERIES = 30        # that a simulated subject tries, one a second
MOST_REPEATS = 3       # of a trial outside the tolerance: a stimulus that the device cannot present is kept and marked then


class Aborted(Exception):
    """The experimenter ended the session."""


class SessionRun:
    def __init__(self, study, order, folder, rig, front, markers, nominal, simulate=None, clamp_bits=0):
        """`nominal`: function from a condition to what it should present. `simulate`: seed of a simulated subject, None: a hand."""
        self.study, self.order, self.folder, self.rig, self.front = study, order, folder, rig, front
        self.markers, self.nominal, self.simulate, self.clamp_bits = markers, nominal, simulate, clamp_bits
        self.notes, self.began, self.before, self.trial = [], time.monotonic(), folder.elapsed(), 0
        self.block = None
        rig.on_answer = self._on_answer
        front.on_stop, front.status = rig.stop, self.status

    def _on_answer(self, word):
        if word.startswith('button '):
            answers = self.study.answers
            index = int(word.split()[1])
            word = answers[index] if index < len(answers) else word
        self.front.events.put(('answer', word))

    def seconds(self):
        return self.before + time.monotonic() - self.began

    def mark(self, event):
        note = self.markers.send(event, self.trial)
        if note:
            self.notes.append(note)

    # The session.

    def run(self):
        """True when all trials are done."""
        total = self.order.expected_trials()
        self.begin()
        while True:
            answers = self.folder.answers()
            trial = self.order.next(answers)
            if trial is None:
                break
            plan = self.order.plan or []  # a staircase does not know its next trial before the answer
            after = plan[trial.index + 1].name(self.study) if trial.index + 1 < len(plan) else ''
            self.front.progress(len(answers), total, trial.name(self.study), after)
            if trial.rest and self.simulate is None and not self._repeats(trial):
                self.break_for(trial.rest)
            self.row(trial)
        self.folder.info['seconds'] = self.seconds()
        self.folder.info['compute_missed'] = self.folder.info.get('compute_missed', 0) + self.rig.compute_missed
        self.folder.finish(True)
        self.front.show('That was all. Thank you.')
        return True

    def begin(self):
        """The instructions stand until a key says that they were read, also where a session goes on."""
        again = 'go on' if self.folder.rows else 'begin'
        self.front.show(self.study.instructions, f'Space or Enter to {again}')
        if self.simulate is None:
            self.front.tell(f'the instructions are shown; Enter, Space or Pause to {again}')
            self.until('begin', 'pause')

    def until(self, *kinds):
        """Waits for one of these events; the others that make sense meanwhile are heard."""
        while True:
            kind, value = self.front.events.get()
            if kind in kinds:
                self.front.state('')
                return
            if kind == 'abort':
                raise Aborted()
            if kind == 'calibrate':
                self.front.tell(self.rig.calibrate())
            if kind == 'note':
                self.notes.append(value)

    def break_for(self, seconds):
        """A rest for the hand, which skip and repeat end."""
        self.front.show(f'Rest your hand for {seconds:.0f} s.')
        try:
            self.wait(seconds)
        except (Skipped, Repeated):
            pass
        except TrialEnded:
            self.recover()

    def status(self):
        """For the experimenter: the device, its force, and the time that is left at the pace so far."""
        state, done = self.rig.state, [float(row['duration']) for row in self.folder.rows if row['duration']]
        left = self.order.expected_trials() - len(self.folder.answers())
        ahead = f', about {left * sum(done) / len(done) / 60:.0f} min left' if done else ''
        outside = sum(row['status'] == 'outside' or row['within_tolerance'] == '0' for row in self.folder.rows)
        return (f"{state.message if state else 'no device yet'}; {self.rig.force():.1f} N{ahead}" +
                (f'; {outside} trials out of tolerance' if outside else ''))

    def _repeats(self, trial):
        return any(int(row['order']) == trial.index for row in self.folder.rows)

    def row(self, trial):
        """One trial and its row."""
        study = self.study
        self.trial = self.folder.next_trial()
        self.notes, unready = [], None
        try:
            self.ready(trial)
        except (TrialEnded, Skipped, Repeated) as end:
            unready = end
        onset = self.seconds()
        row = {'trial': self.trial, 'onset': onset, 'order': trial.index, 'block': trial.block, 'trial_type': trial.kind,
               'condition': trial.name(study), 'track': trial.track, 'comparison': trial.comparison + 1,
               'level': trial.condition.get(study.parameter)}
        self.folder.running(row)
        random = np.random.default_rng(Generator(self.simulate, study.digest, self.order.subject, self.trial).bits()) \
            if self.simulate is not None else None
        self.mark('trial_begin')
        try:
            if unready:
                raise unready
            row.update(self.felt(trial, random))
            row['status'] = row.get('status', 'ok')
        except TrialEnded as end:
            row.update(status=end.status, note=end.reason)
            self.mark('stopped')
        except Skipped:
            row['status'] = 'skipped'
        except Repeated:
            row['status'] = 'repeated'
        row['duration'] = self.seconds() - onset
        row['note'] = '; '.join(filter(None, [row.get('note', '')] + self.notes))
        self.folder.append(row)
        self.mark('trial_end')
        if row['status'] in ('stopped', 'unplugged', 'interrupted'):
            self.front.state(f"No force: {row['status']}", 'wait for the experimenter, who goes on: Pause, or Space there')
            self.front.tell(f"trial {self.trial} {row['status']}: {row['note']}; it is repeated")
            self.recover()
        elif row['status'] not in ACCEPTED:
            self.front.tell(f"trial {self.trial} is {row['status']} and comes again")

    def ready(self, trial):
        """Before the trial, and not in its time."""
        self.cool()
        if trial.block != self.block:
            self.check_device(trial)

    def felt(self, trial, random):
        """Columns of a trial that came to its end."""
        study, windows = self.study, []
        recorder_fresh = True
        for number, condition in enumerate(trial.intervals):
            self.go_home()
            scene = condition_scene.write(study, condition, os.path.join(self.folder.path, 'scenes'))
            if recorder_fresh and self.rig.recorder:
                self.rig.recorder.forget()
            self.rig.load(scene, condition.get('rate', study.rate))
            recorder_fresh = False
            self.wait_home(max(study.phases.home_seconds, SOFT_START + SETTLED))
            self.rig.whole_force()
            self.front.tone()
            self.front.show(f'{("First", "Second")[number]} interval' if len(trial.intervals) == 2 else 'Go')
            self.mark(f'interval_{number + 1}')
            windows.append(self.explore(random))
            self.mark('interval_end')
            self.go_home(wait=False)
        bag = self.folder.bag(self.trial)
        answer = None
        if self.simulate is None:
            answer = self.ask()
        self.rig.recorder.write(os.path.join(self.folder.path, bag))
        samples, mismatches, lost = self.rig.samples(os.path.join(self.folder.path, bag), windows)
        row = {'recording': bag, 'replay_mismatches': mismatches, 'missed_ticks': lost,
               'delay_ms': 1e3 * (self.rig.state.wire_delay + 0.5 / self.rig.rate)}
        felt = self.measured(trial, samples, row)
        if self.simulate is not None:
            percept = Percept(study.hand.get('weber', 0.1), study.hand.get('lapse', 0.0), random)
            self.mark('question')
            answer = (percept.answer(study, felt, self.nominal(study.standard)), 0.0)
            self.mark('answer')
        self.judge(trial, answer, row)
        self.feedback(row)
        self.wait(study.phases.pause_seconds)
        return row

    def measured(self, trial, samples, row):
        """Presented stimuli into `row`; the magnitudes that a percept takes."""
        study, felt, within = self.study, [], []
        for number, (condition, part) in enumerate(zip(trial.intervals, samples), 1):
            added = study.added_delay(condition)
            estimate, nominal = presented(study.measure, part, condition, added), self.nominal(condition)
            row[f'added_delay_{number}_ms'] = 1e3 * added
            row[f'nominal_{number}'], row[f'presented_{number}'] = nominal, estimate.value
            row[f'presented_{number}_error'] = estimate.error
            felt.append(estimate.value)
            if math.isfinite(nominal):
                within.append(math.isfinite(estimate.value) and abs(estimate.value / nominal - 1) <= study.tolerance / 100 and
                              faded_share(part) <= study.tolerance / 100)
        force = np.concatenate([np.linalg.norm(part.force, axis=1) for part in samples])
        touch = np.concatenate([part.contact for part in samples])
        row['peak_force'] = float(force.max(initial=0))
        row['mean_force'] = float(force[touch].mean()) if touch.any() else 0.0
        row['path'] = float(sum(np.linalg.norm(np.diff(part.position, axis=0), axis=1).sum() for part in samples))
        row['contacts'] = int(sum((np.diff(part.contact.astype(int), prepend=0) == 1).sum() for part in samples))
        flags = np.concatenate([part.flags for part in samples])
        share = np.concatenate([part.share for part in samples])
        row['clamped_share'] = float(((flags & self.clamp_bits) != 0)[touch].mean()) if touch.any() else 0.0
        row['faded_share'] = max(map(faded_share, samples))
        row['softened_share'] = float((share[touch] < 1 - 1e-9).mean()) if touch.any() else 0.0
        if study.tolerance > 0 and within:
            row['within_tolerance'] = int(all(within))
            before = sum(r['status'] == 'outside' and int(r['order']) == trial.index for r in self.folder.rows)
            if study.repeat_outside and not all(within) and before < MOST_REPEATS:
                row['status'] = 'outside'
        return felt

    def judge(self, trial, answer, row):
        word, seconds = answer if answer else ('', float('nan'))
        right = trial.right_answer(self.study)
        row['response'], row['response_time'] = word, seconds
        if not answer and self.study.task != 'exploration':
            row.update(status='repeated', note='no answer in time')
        row['correct'] = '' if right is None or not answer else int(word == right)

    def feedback(self, row):
        if self.study.phases.feedback_seconds > 0 and row['correct'] != '':
            self.front.show('Right.' if row['correct'] else 'Wrong.')
            self.wait(self.study.phases.feedback_seconds)

    # Phases.

    def take_events(self):
        """What the experimenter wants now; the last answer, None without one."""
        answer = None
        while True:
            try:
                kind, value = self.front.events.get_nowait()
            except queue.Empty:
                return answer
            if kind == 'answer':
                answer = value
            elif kind == 'note':
                self.notes.append(value)
                self.mark('note')
            elif kind == 'pause':
                self.paused()
            elif kind == 'stop':
                raise TrialEnded('stopped', 'STOP by a key')
            elif kind == 'calibrate':
                self.front.tell(self.rig.calibrate())
            elif kind == 'abort':
                raise Aborted()
            elif kind == 'skip':
                raise Skipped()
            elif kind == 'repeat':
                raise Repeated()

    def paused(self):
        """Until the experimenter goes on. The trial that it falls into is repeated."""
        self.mark('pause')
        self.front.state('A pause', 'Space or Pause to go on')
        self.until('pause', 'begin')
        raise Repeated()

    def wait(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.take_events()
            time.sleep(min(0.02, max(0.0, end - time.monotonic())))

    def go_home(self, wait=True):
        if self.simulate is not None:
            self.rig.lead((0, 0, 0))
        elif wait:
            self.front.show('Back to the middle, please.')
        if wait and self.rig.launch is not None:
            self.wait_home(self.study.phases.home_seconds)

    def wait_home(self, seconds):
        """The grip rests within the home radius for so long."""
        since, begin = None, time.monotonic()
        while since is None or time.monotonic() - since < seconds:
            self.take_events()
            self.rig.check()
            if self.simulate is not None:
                self.rig.lead((0, 0, 0))
            near = self.rig.distance_home() < self.study.phases.home_radius
            since = (since or time.monotonic()) if near else None
            if not near and self.simulate is not None and time.monotonic() - begin > HOME_PATIENCE:
                raise TrialEnded('stopped', f'the simulated hand is {1e3 * self.rig.distance_home():.1f} mm from home')
            time.sleep(HAND_PERIOD)

    def explore(self, random):
        """Window of the exploration (begin, end) in ROS time."""
        study = self.study
        hand = SimulatedHand(study.hand, study.measure, random) if random is not None else None
        begin, wall, touched, away = time.monotonic(), time.time(), False, None
        while time.monotonic() - begin < study.phases.explore_seconds:
            self.take_events()
            self.rig.check()
            if hand:
                self.rig.lead(hand.position(time.monotonic() - begin))
            touch = self.rig.force() > LEAST_TOUCH
            touched = touched or touch
            away = None if touch else (away or time.monotonic())
            if study.phases.until_lift_off and touched and away and time.monotonic() - away > LIFTED:
                break
            time.sleep(HAND_PERIOD)
        return wall, time.time()

    def ask(self):
        """(answer, seconds); None when none came in time."""
        study = self.study
        if study.task == 'exploration':
            return ('', 0.0)
        self.take_events()
        self.front.ask(study.question, study.answers)
        self.mark('question')
        begin = time.monotonic()
        while time.monotonic() - begin < study.phases.respond_seconds:
            word = self.take_events()
            if word is not None:
                answer = self.understood(word)
                if answer is not None:
                    self.mark('answer')
                    return answer, time.monotonic() - begin
                self.front.tell(f"'{word}' is no answer")
            time.sleep(0.002)
        return None

    def understood(self, word):
        study = self.study
        if study.task == 'magnitude':
            try:
                return word if math.isfinite(float(word)) and float(word) >= 0 else None
            except ValueError:
                return None
        if word in study.answers:
            return word
        return study.answers[int(word) - 1] if word in ('1', '2') else None

    # The device.

    def check_device(self, trial):
        """Before each block: the strings agree, and the grip gives way to a push (force_check.py)."""
        study, rig = self.study, self.rig
        rate, scenes = trial.intervals[0].get('rate', study.rate), os.path.join(self.folder.path, 'scenes')
        pushes = []
        self.prepare(condition_scene.write(study, trial.intervals[0], scenes), rate)
        if study.force_check > 0:
            if rig.recorder:
                rig.recorder.forget()
            self.front.show('The device is checked: hold the grip loosely in the middle.')
            pushes = force_check.check(rig, study.force_check, rate, scenes, self.rest, lambda: self.wait_home(HOME_CHECK))
        rig.check()
        state = rig.state
        if state.pose_residual > MOST_RESIDUAL or state.suspect_string >= 0:
            raise TrialEnded('stopped', f'the strings contradict each other by {1e3 * state.pose_residual:.1f} mm: calibrate')
        refused, warned = force_check.judged(pushes)
        self.folder.info.setdefault('device_checks', []).append(
            {'block': trial.block, 'seconds': self.seconds(), 'model': state.model, 'transport': state.transport,
             'state': state.message, 'pose_residual_m': state.pose_residual, 'wire_delay_s': state.wire_delay,
             'stable_stiffness_n_per_m': state.stable_stiffness, 'force_check': refused or warned or ('passed' if pushes else 'none'),
             'pushes': [dataclasses.asdict(push) for push in pushes]})
        self.folder.save_info()
        if refused:
            raise TrialEnded('stopped', f'the force check failed: {refused}')
        if warned:
            self.front.tell(f'force check: {warned}')
            self.notes.append(f'force check: {warned}')
        self.block = trial.block

    def prepare(self, scene, rate):
        """The loop runs and the force is on: a device that was just plugged in is calibrated first, and no trial is spent on it."""
        while True:
            if self.rig.launch is None or self.rig.rate != rate:
                self.rig.load(scene, rate)
            if self.rig.gives_force():
                return
            self.front.tell(f'no force yet: {self.rig.state.message}')
            self.recover()  # a stack that ended in it is started anew

    def rest(self, seconds):
        """Time passes; a simulated hand stays at home."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.take_events()
            self.rig.check()
            if self.simulate is not None:
                self.rig.lead((0, 0, 0))
            time.sleep(min(HAND_PERIOD, max(0.0, end - time.monotonic())))

    def cool(self):
        """While a motor is hot, nothing is felt."""
        told = False
        while self.rig.state is not None and self.rig.state.flags & MOTOR_HOT:
            if not told:
                self.front.show('A pause: the device is warm.')
                self.front.tell('a motor is hot; the next trial waits')
                self.notes.append('waited for a hot motor')
                told = True
            self.wait(1.0)

    def recover(self):
        """After STOP or a fault, until the force is on again. With a hand the experimenter says when to try."""
        tries = RECOVERIES
        while True:
            if self.simulate is None:
                self.until_ready()
            refused = self.rig.recover()
            if not refused:
                return
            self.front.tell(f'no force yet: {refused}')
            tries -= 1
            if self.simulate is not None:
                if not tries:
                    raise Refused(f'the device gives no force: {refused}')
                time.sleep(1)

    def until_ready(self):
        """The experimenter says that the device is."""
        self.front.tell('Pause or Space goes on when the device is ready; calibrate with the grip held at home where it says so')
        self.until('pause')


class Skipped(Exception):
    """The experimenter leaves this trial out."""


class Repeated(Exception):
    """The experimenter wants this trial again."""
