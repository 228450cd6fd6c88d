"""How many trials a study needs: simulated subjects of known JND run it, and their fits tell bias and width of the intervals."""
import copy
import math

import numpy as np

import results
from condition_scene import write
from presented import presented
from simulated_subject import JND_PER_WEBER, Percept, SimulatedHand
from strict_yaml import Refused
from trial_order import Generator, Order

SUBJECTS = 60          # per line of the table: the width stands to 5 %
SIZES = (0.5, 1, 2, 4)


def session_rows(study, subject, felt, percept):
    """A session as rows that results.py reads. `felt(trial)`: magnitudes of the intervals."""
    order, rows, answers = Order(study, subject), [], []
    while True:
        trial = order.next(answers)
        if trial is None:
            return rows
        answer = percept.answer(study, felt(trial))
        right = trial.right_answer(study)
        answers.append(None if right is None else answer == right)
        rows.append({'status': 'ok', 'trial_type': trial.kind, 'response': answer, 'comparison': str(trial.comparison + 1),
                     'level': repr(trial.condition.get(study.parameter)), 'within_tolerance': '', 'track': str(trial.track),
                     'correct': '' if answers[-1] is None else str(int(answers[-1]))})


def nominal_felt(study):
    """Percepts of a study whose loop gives what it says."""
    return lambda trial: [c[study.parameter] for c in trial.intervals]


def twin_felt(study, rig, folder, random):
    """Each interval explored by a simulated hand on the whole twin; percepts take what was presented."""
    def felt(trial):
        out = []
        for condition in trial.intervals:
            rig.load(write(study, condition, folder), condition.get('rate', study.rate))
            samples = rig.explore(SimulatedHand(study.hand, study.measure, random), study.phases.explore_seconds)
            out.append(presented(study.measure, samples, condition, study.added_delay(condition)).value)
        return out
    return felt


def counted(study, rows):
    return [r for r in rows if not results.why_left_out(study, r)]


def sized(study, size):
    """The study with `size` times its trials."""
    study = copy.deepcopy(study)
    if study.staircase:
        study.staircase.reversals = max(2, round(study.staircase.reversals * size))
        study.staircase.discard = min(study.staircase.discard, study.staircase.reversals - 1)
        study.staircase.max_trials = round(study.staircase.max_trials * max(1, size))
    elif study.adaptive:
        study.adaptive.max_trials = max(2, round(study.adaptive.max_trials * size))
        study.adaptive.least_trials = min(study.adaptive.least_trials, study.adaptive.max_trials)
    else:
        study.repetitions = max(1, round(study.repetitions * size))
    return study


def main(study, options):
    del options
    if study.task not in ('two_interval',):
        raise Refused(f'{study.path}: --power wants a two_interval task: its JND is what the number of trials is for')
    weber = study.hand.get('weber', 0.1)
    true = JND_PER_WEBER * weber
    print(f'{study.title}: simulated subjects with a Weber fraction of {weber:g}, JND {true:.4f} of {results.axis(study)[0]}')
    print('  trials   JND found / true   95 % interval of one subject   subjects for 10 %')
    for size in SIZES:
        variant, found, widths, trials = sized(study, size), [], [], []
        for number in range(SUBJECTS):
            random = np.random.default_rng(Generator('power', size, number).bits())
            rows = counted(variant, session_rows(variant, f's{number + 1}', nominal_felt(variant), Percept(weber, study.lapse, random)))
            trials.append(len(rows))
            fit, _ = results.fit_rows(variant, rows, seed=number)
            if fit and fit.identified:
                found.append(fit.jnd)
                widths.append(math.log(fit.jnd_interval[1] / fit.jnd_interval[0]) / 2)
        spread = float(np.std(np.log(found), ddof=1))
        needed = math.ceil((1.96 * spread / math.log(1.1)) ** 2)
        half = math.exp(float(np.median(widths)))
        print(f'  {np.mean(trials):6.0f}   {np.mean(found) / true:16.3f}   /{half:.2f} to x{half:.2f}{needed:31d}')
    print(f'{SUBJECTS} subjects a line; the last column: subjects whose mean JND then has a 95 % interval of +-10 %, if all are alike')
    return 0


