"""A subject in software: a hand that explores by a strategy with motor noise, and a percept of known noise.

The percept of a magnitude S is S exp(w z), z normal, w the Weber fraction. Of two intervals the second is judged greater with
probability Phi(ln(S2/S1) / (w sqrt 2)): the JND at 75 % is 0.6745 w sqrt 2 in ln S, whatever the study."""
import math

import numpy as np

JND_PER_WEBER = 0.6744897501960817 * math.sqrt(2)
CYCLE_NOISE = 0.1      # of each stroke's size, relative
TREMOR = 1e-4          # rms of the slow wander of the hand [m]
MEMORY = 0.2           # of that wander [s]


class SimulatedHand:
    """Where the hand wants the grip, in the device's base. One per interval."""

    def __init__(self, hand, measure, random):
        self.hand = {'gap': 8e-3, 'press': 5e-3, 'stroke': 10e-3, 'period': 1.0, **hand}
        self.measure, self.random = measure, random
        self.sizes, self.wander, self.last = {}, np.zeros(3), 0.0

    def size(self, cycle):
        if cycle not in self.sizes:
            self.sizes[cycle] = 1 + CYCLE_NOISE * float(np.clip(self.random.normal(), -2, 2))
        return self.sizes[cycle]

    def tremor(self, t):
        keep = math.exp(-max(0.0, t - self.last) / MEMORY)
        self.wander = keep * self.wander + math.sqrt(1 - keep * keep) * TREMOR * self.random.normal(size=3)
        self.last = t
        return self.wander

    def position(self, t):
        """At `t` s after the interval began."""
        gap, press, period = self.hand['gap'], self.hand['press'], self.hand['period']
        cycle, phase = divmod(t / period, 1.0)
        approach = min(1.0, t / (0.25 * period))
        wave = 0.5 * (1 - math.cos(2 * math.pi * phase))
        if self.measure == 'friction':
            across = self.hand['stroke'] * self.size(int(cycle)) * math.sin(2 * math.pi * t / period)
            p = np.array([across, 0, -(gap + press) * approach])
        elif self.measure == 'mass':
            # Up below the tray and with it, then slowly to and fro: the lift is held.
            p = np.array([0, 0, approach * (gap + press * (0.8 + 0.2 * wave * self.size(int(cycle))))])
        else:
            p = np.array([0, 0, -approach * gap - press * self.size(int(cycle)) * wave])
        return p + self.tremor(t)


class Percept:
    """Answers from what was felt, with noise of Weber fraction `weber` and lapses."""

    def __init__(self, weber, lapse, random):
        self.weber, self.lapse, self.random = weber, lapse, random

    def magnitude(self, felt):
        return felt * math.exp(self.weber * self.random.normal())

    def answer(self, study, felt, reference=float('nan')):
        """One of the study's answers, or a number as text. `felt`: magnitude of each interval; NaN is guessed. `reference`: the standard's
        magnitude, which a task of one interval is judged by."""
        if study.task == 'exploration':
            return ''
        if study.task == 'magnitude':
            return f'{self.magnitude(felt[0]) / 10:.3g}' if math.isfinite(felt[0]) else '0'
        if not all(math.isfinite(f) and f > 0 for f in felt) or self.random.random() < self.lapse:
            return study.answers[int(self.random.integers(2))]
        seen = [self.magnitude(f) for f in felt]
        if study.task == 'two_interval':
            return study.answers[0 if seen[0] > seen[1] else 1]
        return study.answers[1 if seen[0] > reference else 0]
