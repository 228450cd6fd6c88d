"""Runs of engines that the report does not know: files of one JSON object per line and run. The README states the schema.

Errors are computed here from the states, as for everybody else; what a file says of its own errors is not asked for.
"""
import json
import math
import re

import numpy as np

import programs
from report_plan import Case
from run_errors import Run, Trajectory

SCHEMA = 1
TEXTS = ('engine', 'version', 'licence', 'setting', 'meaning', 'machine', 'scene')


class Outside:
    """A line: `run` with its trajectory, `peer` as describe_peers has them, `scene`, and where it stands for messages."""

    def __init__(self, line, where):
        try:
            data = json.loads(line)
            self._check(data)
            self.run = _run_of(data)
        except (ValueError, KeyError, TypeError, IndexError) as error:
            missing = f'there is no {error}' if isinstance(error, KeyError) else error
            raise ValueError(f'{where}: {missing}; see "An engine" in test/report/README.md') from None
        self.scene, self.where = data['scene'], where
        self.peer = {'name': data['setting'], 'purpose': 'from a file',
                     'meaning': f'{data["engine"]} {data["version"]}, {data["licence"]}: {data["meaning"]}'}

    @staticmethod
    def _check(data):
        if not isinstance(data, dict) or data.get('schema') != SCHEMA:
            raise ValueError(f'the line is no object with "schema": {SCHEMA}')
        for key in TEXTS:
            if not isinstance(data[key], str) or not data[key]:
                raise ValueError(f'{key} is no text')
        if not re.fullmatch('[a-z0-9_]+', data['setting']):  # ours have a hyphen (report_plan.is_peer)
            raise ValueError(f'setting "{data["setting"]}" has other signs than a-z, 0-9 and _')
        if not (isinstance(data['step_s'], float) and 0 < data['step_s'] < math.inf):
            raise ValueError('step_s is no number of seconds')
        if data['status'] not in ('ok', 'diverged', 'refused', 'failed'):
            raise ValueError(f'status "{data["status"]}" is none of ok, diverged, refused, failed')


def _array(data, key, shape):
    """NaN everywhere where the line does not have it."""
    if key not in data:
        return np.full(shape, math.nan)
    values = np.array(data[key], dtype=float)
    if values.shape != shape or not np.isfinite(values).all():
        raise ValueError(f'{key} has not {" x ".join(map(str, shape))} finite numbers')
    return values


def _run_of(data):
    case = Case(data['scene'], data['setting'], data['step_s'], 0, 0)
    # Times of another machine are not comparable: then its errors alone count, as those of an engine in WebAssembly.
    here = data['machine'] == programs.machine()
    cpu = sorted(float(seconds) for seconds in data.get('cpu_s_per_s', [])) if here else []
    cpu = cpu or [math.nan]
    steps = data.get('step_us', {}) if here else {}
    times = [1e-6 * float(steps.get(name, math.nan)) for name in ('p50', 'p99', 'p999', 'max')]
    trajectory = None
    if data['status'] == 'ok':
        count = len(data['time_s'])
        bodies = len(data['pose'][0])
        trajectory = Trajectory(_array(data, 'time_s', (count,)), _array(data, 'energy_j', (count,)), _array(data, 'momentum_ns', (count, 3)),
                                _array(data, 'angular_momentum_nms', (count, 3)), np.zeros((count, 0, 6)),
                                _array(data, 'pose', (count, bodies, 7)), _array(data, 'twist', (count, bodies, 6)))
        if not np.allclose(np.linalg.norm(trajectory.pose[..., 3:], axis=-1), 1, atol=1e-9):
            raise ValueError('a quaternion is not of unit length')
    return Run(case, 'run', data['status'], str(data.get('reason', '')), cpu[len(cpu) // 2], cpu[0], cpu[-1], *times, math.nan,
               0, 0, int(data.get('unconverged', 0)), 0, 0, 0, math.nan, {}, trajectory)


def read(paths, known):
    """All lines of all files. Raises ValueError with one line: a file is not readable, a line is not of the schema, a setting has a name
    of `known` (the peers that the report runs itself), or a run stands twice."""
    found, seen = [], set()
    for path in paths:
        try:
            with open(path) as file:
                lines = file.read().splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise ValueError(f'{path}: {getattr(error, "strerror", None) or "is no text"}') from None
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            outside = Outside(line, f'{path}:{number}')
            if outside.run.case.method in known:
                raise ValueError(f'{outside.where}: setting "{outside.run.case.method}" is one of the report\'s own')
            if outside.run.case in seen:
                raise ValueError(f'{outside.where}: this scene, setting and step stand there already')
            seen.add(outside.run.case)
            found.append(outside)
    return found


def peers_of(found):
    """[{name, purpose, meaning}], each setting once."""
    return list({outside.peer['name']: outside.peer for outside in found}.values())


def check_samples(outside, scene):
    """Raises ValueError with one line unless the states are at the scene's sample times, of the scene's bodies."""
    trajectory = outside.run.trajectory
    if trajectory is None:
        return
    times = scene.seconds * np.arange(1, scene.samples + 1) / scene.samples
    if len(trajectory.time) != scene.samples or not np.allclose(trajectory.time, times, rtol=1e-9, atol=0):
        raise ValueError(f'{outside.where}: time_s is not that of {scene.name}: {scene.samples} samples to {scene.seconds:g} s')
    if trajectory.pose.shape[1] != scene.bodies:
        raise ValueError(f'{outside.where}: {trajectory.pose.shape[1]} bodies where {scene.name} compares {scene.bodies}')
