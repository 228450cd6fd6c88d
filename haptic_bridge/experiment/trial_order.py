"""Which trial comes next: a pure function of study, subject, session, seed and the answers so far. An interrupted session goes on in
the same order because nothing else is in it.

Random numbers are splitmix64 (Steele, Lea, Flood, OOPSLA 2014): the same on every machine and in every version of Python."""
import hashlib
import math
import re
from dataclasses import dataclass, field

import psychometric

MASK = (1 << 64) - 1


class Generator:
    """splitmix64 from a hash of words."""

    def __init__(self, *words):
        self.state = int.from_bytes(hashlib.sha256('\0'.join(map(str, words)).encode()).digest()[:8], 'little')

    def bits(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & MASK
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return z ^ (z >> 31)

    def below(self, count):
        """Uniform in 0..count-1, by rejection."""
        limit = (1 << 64) - (1 << 64) % count
        while True:
            value = self.bits()
            if value < limit:
                return value % count

    def shuffled(self, items):
        """Fisher-Yates."""
        items = list(items)
        for i in range(len(items) - 1, 0, -1):
            j = self.below(i + 1)
            items[i], items[j] = items[j], items[i]
        return items


@dataclass
class Trial:
    """One planned trial. `intervals` are the conditions felt, in order; `comparison` is the index of the one that is judged."""
    index: int
    block: int
    kind: str                 # practice, main or catch
    condition: dict
    intervals: list = field(default_factory=list)
    comparison: int = 0
    track: int = 0
    level: float = float('nan')   # of a staircase: the ratio to the standard
    rest: float = 0               # break before it [s]

    def right_answer(self, study):
        """The answer that is right, None where none is."""
        if study.task == 'two_interval':
            value, standard = self.condition.get(study.parameter), study.standard.get(study.parameter)
            if value is None or value == standard:
                return None
            return study.answers[self.comparison if value > standard else 1 - self.comparison]
        if study.task in ('two_alternative', 'yes_no') and study.parameter in study.standard:
            value, standard = self.condition.get(study.parameter), study.standard[study.parameter]
            return None if value == standard else study.answers[1 if value > standard else 0]
        return None

    def name(self, study):
        if 'name' in self.condition:
            return self.condition['name']
        return ' '.join(f'{key}={value:g}' if isinstance(value, float) else f'{key}={value}' for key, value in self.condition.items()
                        if study.standard.get(key) != value or key == study.parameter)


def subject_number(subject):
    """Row of a Latin square: the number that ends the pseudonym, counted from 0."""
    digits = re.search(r'(\d+)$', subject)
    if digits:
        return int(digits.group(1)) - 1
    return int.from_bytes(hashlib.sha256(subject.encode()).digest()[:4], 'little')


def williams_row(count, row):
    """Row of Williams' design (Aust. J. Sci. Res. A 2, 1949): in `count` rows (twice as many when it is odd) each condition stands once
    at each place and follows each other one equally often."""
    first = [0]
    for i in range(1, count):
        first.append((i + 1) // 2 if i % 2 else count - i // 2)
    turn, mirrored = row % count, count % 2 == 1 and (row // count) % 2 == 1
    values = [(v + turn) % count for v in first]
    return values[::-1] if mirrored else values


class Staircase:
    """A transformed up-down track (Levitt, JASA 49, 1971): the log of the ratio is divided by a step after `down` right answers in a row
    and multiplied by it after `up` wrong ones. It settles where P(right)^down = P(wrong in a row)^up, for up = 1 at 0.5^(1/down)."""

    def __init__(self, rules):
        self.rules, self.log_level = rules, math.log(rules.start)
        self.right = self.wrong = self.trials = 0
        self.direction, self.reversals = 0, []

    @property
    def level(self):
        return math.exp(self.log_level)

    @property
    def done(self):
        return len(self.reversals) >= self.rules.reversals or self.trials >= self.rules.max_trials

    def answer(self, right):
        self.trials += 1
        self.right, self.wrong = (self.right + 1, 0) if right else (0, self.wrong + 1)
        if self.right == self.rules.down:
            self.turn(-1)
        elif self.wrong == self.rules.up:
            self.turn(1)

    def turn(self, direction):
        self.right = self.wrong = 0
        if self.direction == -direction:
            self.reversals.append(self.level)
        self.direction = direction
        steps = self.rules.steps
        step = steps[min(len(self.reversals), len(steps) - 1)]
        log_level = self.log_level * step if direction > 0 else self.log_level / step
        self.log_level = min(max(log_level, math.log(self.rules.least)), 4 * math.log(self.rules.start))

    def threshold(self):
        """Geometric mean of the log ratios of the reversals that count; NaN before there are any."""
        kept = self.reversals[self.rules.discard:]
        return math.exp(math.exp(sum(math.log(math.log(level)) for level in kept) / len(kept))) if kept else float('nan')


class Order:
    """The trials of one session. `next` wants the accepted trials' answers in order: True, False or None each."""

    def __init__(self, study, subject, session=1, seed=None):
        self.study, self.subject, self.session = study, subject, session
        self.seed = study.seed if seed is None else seed
        self.plan = None if study.chooses_levels else self._with_catches(self._planned())

    def _words(self, *more):
        return Generator(self.seed, self.subject, self.session, *more)

    def _arranged(self, block):
        """Conditions of one block, `repetitions` of each."""
        study, conditions = self.study, self.study.conditions
        if study.order == 'fixed':
            return [c for _ in range(study.repetitions) for c in conditions]
        if study.order == 'latin':
            first = subject_number(self.subject) + block * study.repetitions
            return [conditions[i] for r in range(study.repetitions) for i in williams_row(len(conditions), first + r)]
        return self._words('block', block).shuffled([c for _ in range(study.repetitions) for c in conditions])

    def _planned(self):
        trials, block = [], 0
        practice = self._words('practice').shuffled(self.study.conditions)
        rates = self._words('rates').shuffled(self.study.rates())
        for i in range(self.study.practice):
            trials.append(Trial(0, 0, 'practice', practice[i % len(practice)]))
        rate_of = lambda c: c.get('rate', self.study.rate)  # noqa: E731
        trials.sort(key=lambda t: rates.index(rate_of(t.condition)))
        for i in range(self.study.blocks):
            arranged = self._arranged(i)
            for rate in rates:  # a rate is a loop of its own, hence a block of its own
                here = [c for c in arranged if rate_of(c) == rate]
                if not here:
                    continue
                block += 1
                trials += [Trial(0, block, 'main', c) for c in here]
        return trials

    def _with_catches(self, trials):
        """Catch trials are easy: whoever attends answers them right."""
        study, out, since = self.study, [], 0
        for trial in trials:
            out.append(trial)
            since += trial.kind == 'main'
            if study.catch_every and since == study.catch_every:
                out.append(Trial(0, trial.block, 'catch', self._catch()))
                since = 0
        sides = {}
        for index, trial in enumerate(out):
            trial.index = index
            key = (trial.kind, trial.name(study))
            # Within each condition both orders of the intervals come equally often: pairs, each in random order.
            pair = sides.setdefault(key, [])
            if not pair:
                pair += self._words('sides', *key, index).shuffled([0, 1])
            self._fill(trial, pair.pop())
        return out

    def _catch(self):
        """Twice the largest level."""
        study = self.study
        levels = [c[study.parameter] for c in study.conditions if study.parameter in c]
        standard = study.standard[study.parameter]
        return {**study.conditions[0], study.parameter: 2 * max([standard] + levels), 'name': 'catch'}

    def _fill(self, trial, comparison):
        study = self.study
        felt = {**study.standard, **trial.condition}
        trial.condition = felt
        if study.task == 'two_interval':
            trial.comparison = comparison
            trial.intervals = [study.standard, study.standard]
            trial.intervals[comparison] = felt
        else:
            trial.intervals = [felt]
        if study.break_every and trial.index > 0 and trial.index % study.break_every == 0:
            trial.rest = study.break_seconds
        return trial

    def expected_trials(self):
        """How many there are; of a staircase the most there can be."""
        if self.plan is not None:
            return len(self.plan)
        tracks = len(self.study.staircase.tracks) if self.study.staircase else 1
        return self.study.practice + tracks * self.study.chooses_levels.max_trials

    def _chosen(self, index, level, random, track=0):
        """The trial of a level that the answers have chosen; `index` below `practice`: one to practise."""
        study, practice = self.study, index < self.study.practice
        value = study.standard[study.parameter] * level
        trial = Trial(index, 0 if practice else 1, 'practice' if practice else 'main', {study.parameter: value}, track=track, level=level)
        return self._fill(trial, random.below(2))

    def adapted(self, answers):
        """The adaptive method after these answers, and the trial after them (None: done)."""
        study = self.study
        method = psychometric.Adaptive(study.adaptive, study.lapse)
        for index in range(len(answers) + 1):
            if index < study.practice:
                level = study.adaptive.greatest
            elif method.done:
                return method, None
            else:
                level = math.exp(method.next_level())
            if index == len(answers):
                return method, self._chosen(index, level, self._words('trial', index))
            if index >= study.practice and answers[index] is not None:
                method.answer(math.log(level), answers[index] == (level > 1))
        return method, None

    def tracks(self, answers):
        """The staircases after these answers, and the trial after them (None: all done)."""
        study = self.study
        tracks = {t: Staircase(study.staircase) for t in study.staircase.tracks}
        index = 0
        while True:
            practice = index < study.practice
            open_tracks = [t for t in tracks if not tracks[t].done]
            if not open_tracks and not practice:
                return tracks, None
            random = self._words('trial', index)
            track = 0 if practice else open_tracks[random.below(len(open_tracks))]
            level = study.staircase.start if practice else tracks[track].level
            if index == len(answers):
                return tracks, self._chosen(index, level, random, track)
            if not practice and answers[index] is not None:
                tracks[track].answer(answers[index])
            index += 1

    def next(self, answers):
        """The trial after these answers; None: the session is complete."""
        if self.plan is None:
            return (self.tracks if self.study.staircase else self.adapted)(answers)[1]
        return self.plan[len(answers)] if len(answers) < len(self.plan) else None
