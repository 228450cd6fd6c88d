#!/usr/bin/python3
"""What people see, type and publish: numbers that Python takes, frames that references keep, recordings that were cut, and studies: bias and
coverage of each method, trials to an interval of a given width, a BIDS dataset before its validator; the first picture and the words in rviz,
STOP in a study's windows, faults that are shrunk, what the site costs.

    workbench.py --build BUILD [--only PART]...
"""
import argparse
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from types import SimpleNamespace

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
EXPERIMENT, SESSION = os.path.join(ROOT, 'haptic_bridge', 'experiment'), os.path.join(ROOT, 'penalty_sim', 'session')
sys.path[:0] = [EXPERIMENT, SESSION]

import numpy as np  # noqa: E402

import psychometric  # noqa: E402

LAPSES = (0.0, 0.02, 0.05)   # of the simulated percepts, in turn; the fit expects 0.03
SIGMA = 0.15 * math.sqrt(2)  # of a Weber fraction of 0.15, in ln of the ratio
TRUE = SIGMA * psychometric.QUARTILE
TRIALS = {'constant': 280, 'staircase': 200, 'psi': 150, 'quest_plus': 150}
LEVELS = np.log(np.array([0.24, 0.29, 0.34, 0.4, 0.47, 0.55, 0.66]) / 0.4)  # of urdf/experiments/friction.yaml
EXPECTED_LAPSE, GREATEST = 0.03, 2.0
WIDTH, MOST_TRIALS = 0.2, 3000   # an interval of 20 % of the JND
CUTS = (0.3, 0.5, 0.7, 0.9, 0.99)


def figure(name, value, unit):
    print(f'figure {name} {value:.4g} {unit}', flush=True)


def answered(random, x, lapse):
    return random.random() < psychometric.probability(x, 0.0, SIGMA, lapse)


def constant(random, lapse, trials):
    count = np.full(len(LEVELS), float(trials // len(LEVELS)))
    return LEVELS, count, random.binomial(count.astype(int), psychometric.probability(LEVELS, 0.0, SIGMA, lapse)).astype(float)


def staircase(random, lapse, trials):
    """Two tracks of two down, one up; signed as results.judged has them."""
    import study
    from trial_order import Staircase
    rules = study.Staircase('stiffness', start=1.8, steps=[1.6, 1.25], least=1.02, reversals=10**6, max_trials=trials // 2)
    x, y = [], []
    for _ in range(2):
        track = Staircase(rules)
        while not track.done:
            side = 1 if random.random() < 0.5 else -1
            x.append(side * math.log(track.level))
            y.append(answered(random, x[-1], lapse))
            track.answer(y[-1] == (side > 0))
    return psychometric.grouped(x, y)


def adaptive(method, most, width=0.0):
    def run(random, lapse, trials=most):
        rules = SimpleNamespace(method=method, greatest=GREATEST, levels=24, max_trials=trials, least_trials=20, width=width)
        chooser, x, y = psychometric.Adaptive(rules, EXPECTED_LAPSE), [], []
        while not chooser.done:
            x.append(chooser.next_level())
            y.append(answered(random, x[-1], lapse))
            chooser.answer(x[-1], y[-1])
        return psychometric.grouped(x, y)
    return run


METHODS = {'constant': constant, 'staircase': staircase, 'psi': adaptive('psi', 150), 'quest_plus': adaptive('quest_plus', 150)}


def percept(job):
    """(lapse, covered, identified, JND over the true one)."""
    method, number = job
    random, lapse = np.random.default_rng([hash_of(method), number]), LAPSES[number % len(LAPSES)]
    fit = psychometric.fit(*METHODS[method](random, lapse, TRIALS[method]), EXPECTED_LAPSE)
    if fit is None:
        return lapse, False, False, math.nan
    return lapse, fit.jnd_interval[0] <= TRUE <= fit.jnd_interval[1], fit.identified, fit.jnd / TRUE


def hash_of(word):
    return int.from_bytes(word.encode()[:6], 'little')


def studies(options):
    """Bias and coverage: percepts of lapse rates of 0, 2 and 5 % in turn, which the fit does not know."""
    bias, coverage = [], []
    with ProcessPoolExecutor(options.workers) as pool:
        for method in METHODS:
            begin = time.monotonic()
            done = list(pool.map(percept, [(method, i) for i in range(options.percepts)], chunksize=10))
            covered = 100 * sum(row[1] for row in done) / len(done)
            error = 100 * (np.array([row[3] for row in done if row[2]]) - 1)
            parts = []
            for lapse in LAPSES:
                own = [row for row in done if row[0] == lapse]
                found = [row[3] for row in own if row[2]]
                parts.append(f'{100 * lapse:g} %: bias {100 * (np.mean(found) - 1):+.1f} %, covered {100 * sum(r[1] for r in own) / len(own):.1f} %')
            print(f'{method}, {TRIALS[method]} trials, {len(done)} percepts: {sum(not row[2] for row in done)} not identified; lapses of ' +
                  '; '.join(parts) + f'; {time.monotonic() - begin:.0f} s', flush=True)
            figure(f'study.{method}.jnd_bias_pct', error.mean(), '%')
            figure(f'study.{method}.coverage_pct', covered, '%')
            bias.append(abs(error.mean()))
            coverage.append(covered)
    figure('study.jnd_bias_pct', max(bias), '%')
    figure('study.coverage_pct', min(coverage, key=lambda c: min(c - 93, 97 - c)), '%')


def trials_of(job):
    """Trials until the interval is WIDTH of the JND. Of fixed levels and staircases the number doubles, then halves the rest."""
    method, number = job
    random = np.random.default_rng([hash_of(method) + 1, number])
    if method in ('psi', 'quest_plus'):
        _, count, _ = adaptive(method, MOST_TRIALS, WIDTH)(random, 0.02)
        return float(count.sum())
    low, high = 0, 140
    wide = lambda fit: not (fit and fit.identified and fit.jnd_interval[1] - fit.jnd_interval[0] <= WIDTH * fit.jnd)  # noqa: E731
    while high < MOST_TRIALS and wide(psychometric.fit(*METHODS[method](random, 0.02, high), EXPECTED_LAPSE)):
        low, high = high, 2 * high
    while high - low > 0.05 * high:
        middle = (low + high) // 2
        low, high = (middle, high) if wide(psychometric.fit(*METHODS[method](random, 0.02, middle), EXPECTED_LAPSE)) else (low, middle)
    return float(high)


def widths(options):
    with ProcessPoolExecutor(options.workers) as pool:
        for method in METHODS:
            done = list(pool.map(trials_of, [(method, i) for i in range(options.sessions)]))
            figure(f'study.trials_to_width_{method}', float(np.median(done)), 'trials')


def dataset(folder):
    """Two simulated sessions of a shipped study, as the experiment writes them, without a loop."""
    import power
    import session_folder
    import study as study_file
    from simulated_subject import Percept
    study = study_file.read(os.path.join(ROOT, 'urdf', 'experiments', 'friction.yaml'))
    for number, subject in enumerate(('s01', 's02')):
        made = session_folder.SessionFolder(os.path.join(folder, study.name), study, subject, 1, None, {'device': study.device, 'simulated': 1})
        percept_ = Percept(0.12, 0.02, np.random.default_rng(number))
        for i, row in enumerate(power.session_rows(study, subject, power.nominal_felt(study), percept_)):
            made.append({**row, 'trial': i + 1, 'onset': 8.0 * i, 'duration': 7.0, 'order': i, 'block': 1, 'contacts': 2, 'level': float(row['level'])})
        made.finish(True)
        made.lock.close()
    return os.path.join(folder, study.name)


def bids(_):
    npm = shutil.which('npm')
    if not npm:
        print('study.bids_errors is not measured: npm is not here, which brings the validator')
        return
    with tempfile.TemporaryDirectory() as folder:
        root = dataset(folder)
        subprocess.run([sys.executable, '-B', os.path.join(EXPERIMENT, 'analyse.py'), os.path.join(root, 'sub-s01', 'ses-1')], check=True,
                       stdout=subprocess.DEVNULL)
        got = subprocess.run([npm, 'install', '--prefix', os.path.join(folder, 'npm'), '--no-audit', '--no-fund', 'bids-validator@1.15.0'],
                             capture_output=True, text=True, check=False)
        if got.returncode:
            print(f'study.bids_errors is not measured: {(got.stderr.strip().splitlines() or ["npm failed"])[-1]}')
            return
        program = os.path.join(folder, 'npm', 'node_modules', '.bin', 'bids-validator')
        said = subprocess.run([program, '--json', root], capture_output=True, text=True, check=False)
        issues = json.loads(said.stdout)['issues']
        for kind in ('errors', 'warnings'):
            for issue in issues[kind]:
                print(f"{kind}: {issue['key']}: {issue.get('reason', '')}")
        figure('study.bids_errors', len(issues['errors']), '1')


def lines_of(program, *words):
    """Runs a test that prints figures; its lines `figure` are this bench's."""
    done = subprocess.run([program, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    found = re.findall(r'^figure .*', done.stdout, re.MULTILINE)
    print('\n'.join(found) if found else f'{os.path.basename(program)}: no figure: {done.stdout[-2000:]}', flush=True)


def found(build, name):
    for folder, _, files in os.walk(build):
        if name in files and os.access(os.path.join(folder, name), os.X_OK):
            return os.path.join(folder, name)
    sys.exit(f'bench workbench: {name} is not built below {build}')


def frames(options):
    lines_of(found(options.build, 'scene_test'), '--gtest_filter=NamedFrames.*')


def numbers(_):
    lines_of(sys.executable, '-B', os.path.join(ROOT, 'test', 'python', 'python_test.py'), 'BadNumbers')


def cuts(options):
    """A recording of 3 s cut at some shares of its bytes: ticks that are replayed bit for bit, over those of the whole one."""
    with tempfile.TemporaryDirectory() as folder:
        whole = os.path.join(folder, 'whole.bag')
        run = os.path.join(ROOT, 'run')
        subprocess.run([run, 'demo', '--seconds', '3', '--record', whole], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        size, used = os.path.getsize(whole), 0
        for share in CUTS:
            cut = shutil.copy(whole, os.path.join(folder, f'cut{100 * share:.0f}.bag'))
            os.truncate(cut, int(share * size))
            done = subprocess.run([run, 'replay', cut], capture_output=True, text=True, check=False)
            said = re.search(r'was cut off: (\d+) ticks', done.stderr)
            same = re.search(r'figure replay\.mismatches 0 ', done.stdout)
            print(f'cut at {100 * share:.0f} %: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "nothing said"}', flush=True)
            used += bool(said and same and done.returncode == 0)
    figure('cut.used', used, f'of_{len(CUTS)}')


def rviz(options):
    """The first picture of each shipped scene, words for each state, and contrast in the window itself."""
    lines_of(found(options.build, 'scene_test'), '--gtest_filter=SceneView.*')
    lines_of(found(options.build, 'told_states_test'))
    lines_of('rostest', '--text', os.path.join(ROOT, 'test', 'panel', 'panel.test'))


def stop(_):
    program = os.path.join(ROOT, 'test', 'experiment', 'study_windows_test.py')
    lines_of(sys.executable, '-B', program, 'Windows.test_a_session_by_keys_and_clicks')


def shrink(_):
    lines_of(sys.executable, '-B', os.path.join(ROOT, 'test', 'commands', 'shrink_test.py'), '--seeded', '20')


def docs(options):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([os.path.join(ROOT, 'run'), 'docs'], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    figure('docs.cpu_s', after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 's')
    files = [os.path.join(folder, name) for folder, _, names in os.walk(os.path.join(options.build, 'docs', 'html')) for name in names]
    figure('docs.mb', 1e-6 * sum(map(os.path.getsize, files)), 'MB')
    with open(os.path.join(options.build, 'log', 'docs.figures'), encoding='utf-8') as file:
        print(''.join(line for line in file if line.startswith('figure docs.search_found')), end='', flush=True)


PARTS = {'frames': frames, 'numbers': numbers, 'cuts': cuts, 'rviz': rviz, 'stop': stop, 'shrink': shrink, 'docs': docs, 'bids': bids, 'studies': studies, 'widths': widths}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--build', default=os.path.join(ROOT, 'build'))
    parser.add_argument('--only', choices=PARTS, action='append')
    parser.add_argument('--percepts', type=int, default=2000, help='of each method')
    parser.add_argument('--sessions', type=int, default=60, help='of each method, for the trials to a width')
    parser.add_argument('--workers', type=int, default=os.cpu_count())
    options = parser.parse_args()
    os.environ.setdefault('OMP_NUM_THREADS', '1')
    for name, part in PARTS.items():
        if options.only is None or name in options.only:
            print(f'## {name}', flush=True)
            part(options)


if __name__ == '__main__':
    main()
