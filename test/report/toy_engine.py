#!/usr/bin/env python3
"""An engine as others may add theirs: a point mass that falls along a slope too steep for it, one JSON line per run.

It knows one scene of the report, `slope_slide`, with its constant acceleration g (sin a - mu cos a), tan a = 0.75. `toy_exact` falls as
the formula says; `toy_euler` by symplectic Euler, which is ahead by a h t / 2.
"""
import json
import math
import time

import programs

G, MU, TANGENT, MASS, SECONDS, SAMPLES = 9.8, 0.5, 0.75, 0.1, 0.5, 20


def fall(setting, step):
    """Positions and speeds along the slope at the sample times."""
    angle = math.atan(TANGENT)
    a = G * (math.sin(angle) - MU * math.cos(angle))
    steps = round(SECONDS / SAMPLES / step)
    h, states, x, v = SECONDS / SAMPLES / steps, [], 0.0, 0.0
    for _ in range(SAMPLES):
        for _ in range(steps):
            if setting == 'toy_exact':
                x += v * h + a * h * h / 2
                v += a * h
            else:
                v += a * h
                x += v * h
        states.append((x, v))
    return states


def run(setting, step):
    began = time.process_time()
    states = fall(setting, step)
    spent = time.process_time() - began
    return {'schema': 1, 'engine': 'toy', 'version': '1', 'licence': 'BSD-3-Clause', 'setting': setting,
            'meaning': 'a point mass that falls', 'machine': programs.machine(), 'scene': 'slope_slide', 'step_s': step, 'status': 'ok',
            'cpu_s_per_s': [spent / SECONDS], 'time_s': [SECONDS * (i + 1) / SAMPLES for i in range(SAMPLES)],
            'pose': [[[x, 0, 0.05, 1, 0, 0, 0]] for x, _ in states], 'twist': [[[0, 0, 0, v, 0, 0]] for _, v in states]}


if __name__ == '__main__':
    for name in ('toy_exact', 'toy_euler'):
        for length in (1e-3, 1e-2 / 3, 1e-2):
            print(json.dumps(run(name, length)))
