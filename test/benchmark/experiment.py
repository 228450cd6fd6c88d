#!/usr/bin/python3
"""Figures of studies (`./run bench experiment`): orders, fits and simulated subjects of known JND, sessions on the twin with kills, what
was presented against an independent evaluation, switches of conditions in touch, markers, replays of all trials of the four studies."""
import argparse
import glob
import os
import random
import select
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
STUDIES = os.path.join(ROOT, 'urdf', 'experiments')
EXPERIMENT = os.path.join(ROOT, 'haptic_bridge', 'experiment')
sys.path[:0] = [EXPERIMENT, os.path.join(ROOT, 'penalty_sim', 'session')]

import numpy as np  # noqa: E402

import power  # noqa: E402
import results  # noqa: E402
import session_data  # noqa: E402
import session_folder  # noqa: E402
import study as study_file  # noqa: E402
from event_markers import CODES, EventMarkers  # noqa: E402
from simulated_subject import JND_PER_WEBER, Percept  # noqa: E402
from trial_order import Generator, Order  # noqa: E402

NAMES = ('stiffness', 'friction', 'weight', 'update_rate')
PERCEPTS, SUBJECTS, KILLS, MARKERS = 2000, 20, 200, 2000
LANES = 4            # sessions beside each other that are killed; each start of a stack is two seconds of a processor
KILL_PATIENCE = 60   # for the bytes of a session on a busy machine [s]
AFTER_LOST = 0.1   # [s]
GAP_SPELL, GAP_SPELLS, FASTEST = 0.02, 150, 10000  # [s], number, and the highest rate of a study [Hz]
DEVICE = os.path.join(ROOT, 'urdf', 'devices', 'spidar_g6x3r.yaml')
KILL_STUDY = """study: 1
title: Short trials to be killed in
instructions: Press.
scene: pad
target: [pad, pointer]
task: two_interval
question: Stiffer?
standard: {stiffness: 1e7}
factors: {stiffness: [0.8e7, 1.25e7]}
repetitions: 500
phases: {home_seconds: 0.05, explore_seconds: 0.5, pause_seconds: 0}
force_check_n: 0
presented: {measure: stiffness}
simulated_hand: {gap_mm: 8, press_mm: 5, period_s: 0.5, weber: 0.1}
"""


def figure(name, value, unit):
    print(f'figure experiment.{name} {value:.6g} {unit}', flush=True)


def shipped(name):
    return study_file.read(os.path.join(STUDIES, name + '.yaml'))


def orders(_):
    """The order in another process, and from any prefix of the answers, is the same."""
    program = ('import sys; sys.path.insert(0, sys.argv[1]); import study, trial_order; s = study.read(sys.argv[2]); '
               'o = trial_order.Order(s, sys.argv[3], 1, int(sys.argv[4])); a = []\n'
               'while (t := o.next(a)) is not None: print(t.index, t.condition, t.comparison, t.track); '
               'a.append((t.index * 7 + 3) % 4 != 0)')
    same = True
    for name in NAMES:
        for subject, seed in (('s01', 1), ('s02', 1), ('s01', 2)):
            call = [sys.executable, '-B', '-c', program, EXPERIMENT, os.path.join(STUDIES, name + '.yaml'), subject, str(seed)]
            first, second = (subprocess.run(call, capture_output=True, text=True, check=True).stdout.splitlines() for _ in range(2))
            study, n = shipped(name), len(first)
            for k in range(0, n, max(1, n // 20)):
                trial = Order(study, subject, 1, seed).next([(i * 7 + 3) % 4 != 0 for i in range(k)])
                same &= f'{trial.index} {trial.condition} {trial.comparison} {trial.track}' == first[k]
            same &= first == second and n > 0
    figure('order_reproduced', int(same), '1')


def fits(options):
    """Percepts of known JND through the friction study with 280 trials that count."""
    study = shipped('friction')
    study.repetitions, study.practice, study.catch_every = 20, 0, 0
    found, covered, none, weber = [], 0, 0, 0.15
    true = JND_PER_WEBER * weber
    for number in range(options.percepts):
        percept = Percept(weber, study.lapse, np.random.default_rng(Generator('percept', number).bits()))
        rows = power.counted(study, power.session_rows(study, f's{number + 1}', power.nominal_felt(study), percept))
        fit, _ = results.fit_rows(study, rows, seed=number)
        covered += fit is not None and fit.jnd_interval[0] <= true <= fit.jnd_interval[1]
        if fit is None or not fit.identified:
            none += 1
            continue
        found.append(fit.jnd)
    error = 100 * (np.array(found) / true - 1)
    print(f'{options.percepts} percepts of JND {true:.4f}, 280 trials each: mean {error.mean():+.2f} % (s.e. '
          f'{error.std(ddof=1) / np.sqrt(len(error)):.2f}), median {np.median(error):+.2f} %, {none} not identified')
    figure('jnd_bias_pct', abs(error.mean()), '%')
    figure('interval_coverage_pct', 100 * covered / options.percepts, '%')


def subjects(options):
    """Whole sessions of the stiffness study by simulated subjects on the twin, in this process: the percept takes what the strings gave."""
    from loop_rig import LoopRig
    study, inside = shipped('stiffness'), 0
    weber = study.hand['weber']
    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.subjects):
            motor, percept = (np.random.default_rng(Generator(word, number).bits()) for word in ('motor', 'percept'))
            felt = power.twin_felt(study, LoopRig(DEVICE), folder, motor)
            rows = power.counted(study, power.session_rows(study, f's{number + 1}', felt, Percept(weber, study.lapse, percept)))
            fit, _ = results.fit_rows(study, rows, seed=number)
            hit = fit is not None and fit.jnd_interval[0] <= JND_PER_WEBER * weber <= fit.jnd_interval[1]
            inside += hit
            found = fit.jnd_text() if fit else 'no fit'
            print(f's{number + 1}: {len(rows)} trials, {found}', flush=True)
    figure('subjects_within', inside, f'of_{options.subjects}')


def call(options, study, subject, output, *more):
    return [sys.executable, '-B', os.path.join(EXPERIMENT, 'experiment.py'), '--program', options.program, study, '--device', DEVICE,
            '--subject', subject, '--simulate', '1', '--output', output, *more]


class KilledSession:
    """A session of its own that is killed again and again, at random instants from its start on. A trial is complete once its last byte
    came over the marker line: from then on its row must be on disk."""

    def __init__(self, options, folder, study, number):
        self.options, self.folder, self.study, self.subject = options, folder, study, f's{number:02d}'
        self.choose = random.Random(f'{options.seed} {number}')
        self.path = os.path.join(folder, 'killed', f'sub-{self.subject}', 'ses-1')
        self.line, self.terminal = os.openpty()
        self.kills = self.complete = self.lost = 0

    def heard(self, patience):
        """Bytes that come within `patience` [s]; b'': none."""
        got = os.read(self.line, 4096) if select.select([self.line], [], [], patience)[0] else b''
        self.complete += got.count(bytes([CODES['trial_end']]))
        return got

    def rows(self):
        return session_folder.rows_of(os.path.join(self.path, 'trials.csv'))[0]

    def ended(self):
        """Rows of trials that ended, however: STOP of a machine that was late is a row as well."""
        return [r for r in self.rows() if r['status'] != 'interrupted']

    def kill(self):
        with open(os.path.join(self.folder, 'log'), 'ab') as log:
            words = call(self.options, self.study, self.subject, self.folder, '--marker-port', os.ttyname(self.terminal))
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        # One kill of twelve falls into the start of the stack, the others into trials and the writing between them.
        bytes_wanted = self.choose.randrange(0, 12)
        patience = time.monotonic() + KILL_PATIENCE
        while bytes_wanted > 0 and time.monotonic() < patience and process.poll() is None:
            bytes_wanted -= len(self.heard(0.2))
        time.sleep(1.5 * self.choose.random())
        process.send_signal(signal.SIGKILL)
        process.wait()
        while self.heard(0.1):
            pass
        self.kills += 1
        self.lost = max(self.lost, self.complete - len(self.ended()))

    def run(self, count):
        for number in range(count):
            self.kill()
            if number % 10 == 9:
                print(f'{self.subject}, {number + 1} kills: {self.complete} complete trials, {len(self.ended())} rows, '
                      f'{len(self.rows()) - len(self.ended())} interrupted', flush=True)
        return self

    def torn(self):
        """Rows that stand twice, or whose recording does not run again bit for bit."""
        count, trials, orders = 0, set(), set()
        for row in self.ended():
            ok = row['status'] == 'ok'
            try:
                sound = not ok or all(int(s.info['mismatches']) == 0 for s in
                                      session_data.read(os.path.join(self.path, row['recording']), self.options.program))
            except session_data.Refused:
                sound = False
            count += not sound or row['trial'] in trials or (ok and row['order'] in orders)
            trials.add(row['trial'])
            orders |= {row['order']} if ok else set()
        return count


def kills(options):
    """Several sessions beside each other: each waits most of its time."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'killed.yaml')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(KILL_STUDY)
        shares = [len(range(lane, options.kills, options.lanes)) for lane in range(options.lanes)]
        lanes = [KilledSession(options, folder, path, number + 1) for number in range(options.lanes)]
        with ThreadPoolExecutor(options.lanes) as pool:
            lanes = list(pool.map(KilledSession.run, lanes, shares))
            torn = sum(pool.map(KilledSession.torn, lanes))
        complete, rows = sum(lane.complete for lane in lanes), sum(len(lane.ended()) for lane in lanes)
        killed, lost = sum(lane.kills for lane in lanes), sum(lane.lost for lane in lanes)
    print(f'{killed} kills of {options.lanes} sessions: {complete} trials were complete, {rows} are whole rows, {torn} torn or twice')
    figure('kills', killed, '1')
    figure('trials_completed', complete, '1')
    figure('trials_lost', lost + torn, '1')


def markers(_):
    """From the call to the byte at the other end of a line, read by another process."""
    line, terminal = os.openpty()
    out, back = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))  # a trigger box has a processor of its own
        except PermissionError:
            pass
        times = []
        while len(times) < MARKERS:
            count = len(os.read(line, 16))
            times += [time.monotonic_ns()] * count
        os.write(back, np.array(times[:MARKERS], dtype=np.int64).tobytes())
        os._exit(0)
    sender, sent = EventMarkers(os.ttyname(terminal)), []
    for _ in range(MARKERS):
        time.sleep(0.002)
        sent.append(time.monotonic_ns())
        sender.send('answer', 1)
    data = b''
    while len(data) < 8 * MARKERS:
        data += os.read(out, 8 * MARKERS)
    os.waitpid(child, 0)
    latency = (np.frombuffer(data, dtype=np.int64) - np.array(sent)) * 1e-6
    print(f'{MARKERS} markers: median {np.median(latency):.4f} ms, largest {latency.max():.3f} ms')
    figure('marker_latency_ms_p99', float(np.quantile(latency, 0.99)), 'ms')


def machine(_):
    """For how long this machine keeps its processor from a thread that nothing else may interrupt: a loop at 10 kHz has 100 us a tick,
    and what is kept from it counts in `compute_missed` as its own."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except PermissionError:
        print('this user has no real-time priority', flush=True)
    gaps, spun = [], 0.0
    for _ in range(GAP_SPELLS):
        begin = last = time.monotonic_ns()
        while last - begin < GAP_SPELL * 1e9:
            now = time.monotonic_ns()
            if now - last > 1e9 / FASTEST:
                gaps.append((now - last) * 1e-3)
            last = now
        spun += (last - begin) * 1e-9
        time.sleep(GAP_SPELL)
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    figure('machine_gaps_per_s', len(gaps) / spun, '1/s')
    figure('machine_gap_us_max', max(gaps, default=0.0), 'us')


def string_force(table, hand, exits, knots):
    """Sum of the tensions along the strings at the recorded poses: neither the loop's structure matrix nor its wrench is used."""
    n = len(table)
    p = np.stack([table[f'{hand}.position_{a}'] for a in 'xyz'], axis=1)
    x, y, z, w = (np.array(table[f'{hand}.orientation_{a}']) for a in 'xyzw')
    R = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
                  2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1).reshape(n, 3, 3)
    force = np.zeros((n, 3))
    for s, (exit_s, knot) in enumerate(zip(exits, knots)):
        along = exit_s - (p + R @ knot)
        force += (np.array(table[f'{hand}.tension_{s}']) / np.linalg.norm(along, axis=1))[:, None] * along
    return p, force


def independent(measure, table, exits, knots, gap=8e-3):
    """Another estimator than presented.py's: medians of ratios where the tip moves slowly (stiffness) or fast (friction)."""
    hand = 'spidar'
    p, force = string_force(table, hand, exits, knots)
    v = np.gradient(p, np.array(table['time']), axis=0)
    v = np.stack([np.convolve(v[:, i], np.ones(21) / 21, 'same') for i in range(3)], axis=1)
    faded = np.array(table[f'{hand}.fade']) >= 1
    if measure == 'stiffness':
        depth = -gap - p[:, 2]
        rows = faded & (depth > 1e-3) & (np.abs(v[:, 2]) < 2e-3)
        return float(np.median(force[rows, 2] / depth[rows])) if rows.sum() > 20 else np.nan
    rows = faded & (np.abs(v[:, 0]) > 0.03) & (force[:, 2] > 0.3)
    return float(np.median(np.abs(force[rows, 0]) / force[rows, 2])) if rows.sum() > 20 else np.nan


def switch_jump(sessions):
    """(Largest change of the force in a tick while conditions change, ticks left out): from the tick in which a fade to silence began, or
    0.1 s before, until 0.6 s after the new condition began. After a lost tick the grip has gone on by several ticks' way: the
    AFTER_LOST seconds from it on are left out, and counted."""
    worst, lost = 0.0, 0
    for before, after in zip(sessions, sessions[1:]):
        rows = [np.stack([s.table[f'spidar.achieved_force_{a}'] for a in 'xyz'], axis=1) for s in (before, after)]
        changed = [at for at, what, _ in before.info['events'] if what == 'change a hand']
        silent = changed[-1:] if before.table['spidar.fade'][-1] < 1 else []  # the hand may have been let in before
        begin = max(0, round(min([before.table['time'][-1] - 0.1] + silent) * before.info['rate']))
        near = np.concatenate([rows[0][begin:], rows[1][:round(0.6 * after.info['rate'])]])
        late = np.concatenate([before.table['lost_periods'][begin:], after.table['lost_periods'][:round(0.6 * after.info['rate'])]]) > 0
        late = np.convolve(late, np.ones(round(AFTER_LOST * before.info['rate'])))[:len(late)] > 0
        change = np.linalg.norm(np.diff(near, axis=0), axis=1)
        lost += int(late[1:].sum())
        worst = max(worst, float(change[~late[1:]].max(initial=0)))
    return worst, lost


@dataclass
class Ran:
    """What a session of a shipped study came to."""
    trials: int = 0
    mismatches: int = 0
    missed: int = 0
    error: float = 0.0   # largest, of presented against independent [%]
    jump: float = 0.0    # [N]
    lost: int = 0        # ticks left out of that
    unjudged: int = 0    # intervals of which one of the two says nothing


def session(options, folder, name):
    """One session of a shipped study on the stack, at its own pace."""
    import haptic
    device = haptic.Device(DEVICE)
    exits, knots = np.array(device.exits), np.array(device.knots)
    with open(os.path.join(folder, name + '.log'), 'w+', encoding='utf-8') as log:
        code = subprocess.run(call(options, os.path.join(STUDIES, name + '.yaml'), 's01', folder), stdin=subprocess.DEVNULL, stdout=log,
                              stderr=log, check=False).returncode
        log.seek(0)
        if code:
            raise SystemExit(f'{name}: the session ended with {code}: {log.read()[-2000:]}')
    path = glob.glob(os.path.join(folder, name, 'sub-s01', 'ses-1'))[0]
    info, rows = session_folder.read(path)
    ran = Ran(missed=info['compute_missed'])
    for row in rows:
        if not row['recording']:
            continue
        ran.trials += 1
        recorded = session_data.read(os.path.join(path, row['recording']), options.program)
        ran.mismatches += sum(int(s.info['mismatches']) for s in recorded)
        jump, lost = switch_jump(recorded)
        ran.jump, ran.lost = max(ran.jump, jump), ran.lost + lost
        if name not in ('stiffness', 'friction'):
            continue
        for i, s in enumerate(recorded, 1):
            said, oracle = results.number(row[f'presented_{i}']), independent(name, s.table, exits, knots)
            if np.isfinite(said) and np.isfinite(oracle):
                ran.error = max(ran.error, 100 * abs(said / oracle - 1))
            else:
                ran.unjudged += 1
    print(f"{name}: {len(rows)} rows, {sum(r['status'] == 'ok' for r in rows)} ok, tenths of a second with a slow tick {ran.missed}, "
          f'presented against independent {ran.error:.3f} %, {ran.unjudged} intervals without, ticks after lost ones {ran.lost}', flush=True)
    return ran


def sessions(options):
    """One session of each shipped study, beside each other: each has a loop, a master and a folder of its own, and waits most of the time."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(len(options.studies)) as pool:
        ran = list(pool.map(lambda name: session(options, folder, name), options.studies))
    figure('replayed_trials', sum(r.trials for r in ran), '1')
    figure('replay_mismatches', sum(r.mismatches for r in ran), '1')
    figure('compute_missed', sum(r.missed for r in ran), '1')
    figure('presented_err_pct', max(r.error for r in ran), '%')
    figure('switch_home_force_jump_n', max(r.jump for r in ran), 'N')


def switches(options):
    """Conditions change while the hand presses: the force is faded out first."""
    import condition_scene
    from simulated_subject import SimulatedHand
    from stack_rig import HAND_PERIOD, StackRig
    study = shipped('stiffness')
    worst, left_out = 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        rig = StackRig(DEVICE, 'twin', os.path.join(folder, 'log'), options.program, simulated=True)
        scenes = [condition_scene.write(study, {'stiffness': k}, folder) for k in (1e7, 2e7)]
        rig.load(scenes[0], 1000.0)
        hand = SimulatedHand({'gap': 8e-3, 'press': 8e-3, 'period': 4.0}, 'stiffness', np.random.default_rng(1))
        for i in range(8):
            rig.recorder.forget()
            rig.load(scenes[i % 2], 1000.0)
            begin = time.monotonic()
            while time.monotonic() - begin < 2.0:  # half of a cycle: pressed most
                rig.lead(hand.position(time.monotonic() - begin))
                time.sleep(HAND_PERIOD)
            pressed = rig.force()
            rig.load(scenes[(i + 1) % 2], 1000.0)
            while rig.distance_home() > 2e-3:
                rig.lead((0, 0, 0))
                time.sleep(HAND_PERIOD)
            rig.whole_force()
            time.sleep(0.2)
            bag = os.path.join(folder, f'{i}.bag')
            rig.recorder.write(bag)
            jump, late = switch_jump(session_data.read(bag, options.program))
            print(f'switch while the hand felt {pressed:.2f} N: largest change in a tick {jump:.4f} N, {late} ticks after lost ones left '
                  'out', flush=True)
            left_out += late
            worst = max(worst, jump)
        rig.close()
    figure('switch_ticks_after_lost', left_out, '1')
    figure('switch_force_jump_n', worst, 'N')


PARTS = {'orders': orders, 'fits': fits, 'subjects': subjects, 'markers': markers, 'machine': machine, 'switches': switches,
         'sessions': sessions, 'kills': kills}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--program', required=True, help='session_table')
    parser.add_argument('--only', choices=PARTS)
    parser.add_argument('--percepts', type=int, default=PERCEPTS)
    parser.add_argument('--subjects', type=int, default=SUBJECTS)
    parser.add_argument('--kills', type=int, default=KILLS)
    parser.add_argument('--lanes', type=int, default=LANES)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--studies', nargs='+', default=NAMES, choices=NAMES)
    options = parser.parse_args()
    for name, part in PARTS.items():
        if options.only in (None, name):
            print(f'## {name}', flush=True)
            begin = time.monotonic()
            part(options)
            print(f'{name} took {time.monotonic() - begin:.0f} s', flush=True)


if __name__ == '__main__':
    main()
