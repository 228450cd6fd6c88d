"""From what report_run prints to errors: of position, orientation, energy, momentum, and of the wrench at the hand."""
import collections
import math

import numpy as np

from report_plan import is_wasm

# Name, unit and meaning of each metric; errors are rms over the sample times, of the worst body.
METRICS = {
    'position': ('m', 'distance of a body from where it should be'),
    'orientation': ('rad', 'angle between its axes and where they should be'),
    'velocity': ('m/s', 'of the body frame'),
    'energy': ('J', 'kinetic and potential, of all bodies together'),
    'momentum': ('N s', 'of all bodies together'),
    'angular_momentum': ('N m s', 'of all bodies together, about the origin'),
    'wrench': ('N', 'force at the hand'),
    # Of scenes with a measure of their own (report_scene.h): over all samples, no reference motion is needed.
    'penetration': ('m', 'deepest corner of a body inside the floor or a wall'),
    'energy_gain': ('J', 'largest rise of the mechanical energy above its least value so far'),
    'momentum_drift': ('N s', 'largest change of the conserved momentum'),
    'angular_momentum_drift': ('N m s', 'largest change of the conserved angular momentum'),
    'angular_momentum_rel': ('1', 'largest change of the angular momentum, relative (Gazebo)'),
    'energy_rel': ('1', 'largest change of the energy, relative (Gazebo)'),
    'energy_squared': ('J^2', 'mean of the squared change of the energy (SimBenchmark)'),
    'velocity_squared': ('m^2/s^2', 'mean of the squared velocity errors of box and ball (SimBenchmark)'),
    'overlap': ('m^2', 'mean of the sum of squared overlaps of true balls and ground (SimBenchmark)'),
    'fallen': ('s', 'time for which the tower does not stand (SimBenchmark)'),
    'slip': ('m', 'largest slip of the cube in the fingers after friction was lowered (MotrixSim)'),
    'last_ball': ('1', 'speed that the last ball of the cradle lacks, relative'),
    'spread': ('m', 'rms distance of the end places from their mean, 100 starts (Chung, Pollard)'),
}

Run = collections.namedtuple(
    'Run', 'case role status reason cpu cpu_low cpu_high p50 p99 p999 slowest touching steps allocations unconverged iterations '
           'iterations_worst evaluations_worst gain measures trajectory')
Run.__doc__ = '''A finished case. Status: ok, diverged, refused, failed. `cpu`: median CPU time per simulated second [s], with the least
and the largest repetition. Step times: CPU time [s]; `touching`: median of ours over steps that
computed a contact. `gain`: energy that the ledger gained over the largest exchanged.
`measures`: {metric: error} of the scene's own. `trajectory`: None unless it ran.'''

Trajectory = collections.namedtuple('Trajectory', 'time energy momentum angular_momentum hands pose twist')
Trajectory.__doc__ = '''Arrays over samples: time (s), energy (s), momenta (s, 3), hands (s, hands, 6) torque first, pose (s, bodies, 7)
position and quaternion w first, twist (s, bodies, 6) angular first.'''


def parse_samples(lines):
    """Trajectory of the `sample` lines; None when there is none."""
    rows = [[float(word) for word in line.split()[1:]] for line in lines if line.startswith('sample ')]
    if not rows:
        return None
    hands, bodies = int(rows[0][8]), int(rows[0][9])
    data = np.array(rows)
    states = data[:, 10 + 6 * hands:].reshape(len(rows), bodies, 13)
    return Trajectory(data[:, 0], data[:, 1], data[:, 2:5], data[:, 5:8], data[:, 10:10 + 6 * hands].reshape(len(rows), hands, 6),
                      states[:, :, :7], states[:, :, 7:])


def parse_run(case, result, role='run'):
    """The run that a task's result tells of."""
    nothing = (math.nan,) * 8 + (0, 0, 0, 0, 0, 0, math.nan, {}, None)
    if result['failure']:
        return Run(case, role, 'failed', result['failure'], *nothing)
    lines = result['output'].splitlines()
    trajectory = parse_samples(lines)
    if case.method == 'exact':
        return Run(case, role, 'ok', '', *nothing[:-1], trajectory)
    words = {}
    for line in lines:
        key, _, rest = line.partition(' ')
        words.setdefault(key, rest)
    if 'status' not in words:
        return Run(case, role, 'failed', 'printed nothing', *nothing)
    if words['status'] == 'refused':
        return Run(case, role, 'refused', words['reason'], *nothing)
    simulated = float(words['time_reached'])
    cpu = sorted(float(t) / simulated for t in words['cpu_s'].split()) if simulated > 0 else [math.nan]
    times = [float(words[f'step_{name}_s']) for name in ('p50', 'p99', 'p999', 'max', 'touching_p50')]
    if is_wasm(case.method):
        cpu, times = [math.nan], [math.nan] * len(times)  # another process took them, at another speed
    counts = [int(words[name]) for name in ('steps', 'allocations', 'unconverged', 'iterations', 'iterations_worst',
                                            'evaluations_worst')]
    measures = {key.removeprefix('measure_'): float(value) for key, value in words.items() if key.startswith('measure_')}
    return Run(case, role, words['status'], words['reason'], cpu[len(cpu) // 2], cpu[0], cpu[-1], *times, *counts,
               float(words['energy_gain']), measures, trajectory)


def angle_between(a, b):
    """Angle of the rotation between unit quaternions (.., 4), precise for small ones too [rad]."""
    w = np.abs(np.sum(a * b, axis=-1))
    vector = (a[..., :1] * b[..., 1:] - b[..., :1] * a[..., 1:] - np.cross(a[..., 1:], b[..., 1:]))
    return 2 * np.arctan2(np.linalg.norm(vector, axis=-1), w)


def error_over_time(trajectory, reference):
    """Metric -> error at each sample time (of the worst body), as far as the run got."""
    n = min(len(trajectory.time), len(reference.time))
    if n == 0:
        return {}

    def distance(a, b):
        return np.linalg.norm(a[:n] - b[:n], axis=-1)
    errors = {
        'position': distance(trajectory.pose[..., :3], reference.pose[..., :3]).max(axis=1),
        'orientation': angle_between(trajectory.pose[:n, :, 3:], reference.pose[:n, :, 3:]).max(axis=1),
        'velocity': distance(trajectory.twist[..., 3:], reference.twist[..., 3:]).max(axis=1),
        'energy': np.abs(trajectory.energy[:n] - reference.energy[:n]),
        'momentum': distance(trajectory.momentum, reference.momentum),
        'angular_momentum': distance(trajectory.angular_momentum, reference.angular_momentum),
    }
    if trajectory.hands.shape[1] and reference.hands.shape[1]:
        errors['wrench'] = distance(trajectory.hands[..., 3:], reference.hands[..., 3:]).max(axis=1)
    return errors


def errors_against(run, reference):
    """Metric -> rms error of a complete run against a trajectory; empty when it failed."""
    if run.status != 'ok' or run.trajectory is None or reference is None:
        return {}
    errors = {metric: float(np.sqrt(np.mean(np.square(values))))
              for metric, values in error_over_time(run.trajectory, reference).items()}
    return {metric: error for metric, error in errors.items() if not math.isnan(error)}  # NaN: an engine from outside does not say it


LEDGER_BOUND = 0.1  # of the largest energy exchanged: a run whose ledger gained more than that from nothing has failed


def judged(run, reference, size):
    """The run, failed where it is: a body farther than `size` [m] from the reference (None: there is none), a ledger out of
    bounds, steps that did not converge."""
    if run.status != 'ok':
        return run
    reasons = []
    if reference is not None and run.trajectory is not None:
        away = float(np.max(error_over_time(run.trajectory, reference)['position']))
        if not away <= size:
            reasons.append(f'a body is {away:.3g} m from the reference, more than {size:.3g} m')
    if run.gain > LEDGER_BOUND:
        reasons.append(f'the ledger gained {100 * run.gain:.0f} % of the largest energy exchanged')
    if run.unconverged:
        reasons.append(f'{run.unconverged} of {run.steps} steps did not converge')
    return run._replace(status='failed', reason='; '.join(reasons)) if reasons else run


def order_of(steps, errors):
    """Observed order: least-squares slope of log(error) over log(step), and the number of points it rests on. What lies
    within three times the smallest error is the floor of rounding (or of the reference) and does not count."""
    pairs = sorted((h, e) for h, e in zip(steps, errors) if e > 0 and math.isfinite(e))
    if not pairs:
        return math.nan, 0
    floor = 3 * min(e for _, e in pairs)
    kept = [pair for pair in pairs if pair[1] > floor]
    # The largest point of the floor is where the slope ends.
    below = [pair for pair in pairs if pair[1] <= floor]
    kept = below[-1:] + kept
    if len(kept) < 2:
        return math.nan, len(kept)
    x, y = np.log([h for h, _ in kept]), np.log([e for _, e in kept])
    return float(np.polyfit(x, y, 1)[0]), len(kept)
