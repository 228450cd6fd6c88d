#!/usr/bin/python3
"""Trials of a study, their time, their order for a subject and seed, and the hand's forces in every condition."""
import argparse
import math
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), 'penalty_sim', 'session')]

import yaml  # noqa: E402

import condition_scene  # noqa: E402
import study as study_file  # noqa: E402
from preview import UNITS, Previews  # noqa: E402
from strict_yaml import Refused  # noqa: E402
from trial_order import Order  # noqa: E402

SHOWN_TRIALS = 12
SWITCH_SECONDS = 1.5      # to load a condition and fade the force in
ANSWER_SECONDS = 2.0      # a subject takes, about


def trial_seconds(study):
    p = study.phases
    interval = p.home_seconds + SWITCH_SECONDS + p.explore_seconds
    return study.intervals() * interval + (0 if study.task == 'exploration' else ANSWER_SECONDS) + p.feedback_seconds + p.pause_seconds


def expected(study, order):
    """(trials, seconds); of a staircase two thirds of the most."""
    trials = order.expected_trials()
    if study.staircase:
        trials = study.practice + round(2 / 3 * (trials - study.practice))
    breaks = trials // study.break_every * study.break_seconds if study.break_every else 0
    return trials, trials * trial_seconds(study) + breaks


def conditions_of(study):
    """Each condition that is felt, once."""
    out = []
    levels = []
    if study.staircase:
        value = study.standard[study.staircase.parameter]
        levels = [{study.staircase.parameter: value * study.staircase.start}]
    for condition in [study.standard] * bool(study.standard and study.task == 'two_interval') + study.conditions + levels:
        felt = {**study.standard, **condition}
        if felt not in out:
            out.append(felt)
    return out


def most_rate(device):
    """Highest rate that the wire of a device's file carries [Hz]."""
    with open(device, encoding='utf-8') as file:
        known = yaml.safe_load(file)
    return float(known.get('max_rate', math.inf))


def device_line(study, device):
    most = most_rate(device)
    beyond = [f'{rate:g}' for rate in study.rates() if rate > most]
    return (f"device {os.path.basename(device)}: carries {most:g} Hz" +
            (f"; cannot run {', '.join(beyond)} Hz: on the real device those conditions are refused, the twin runs them" if beyond else ''))


def hand_line(program, device, scene, rate):
    """What scene_check says of a relaxed hand there."""
    done = subprocess.run([program, '--device', device, '--rate', repr(float(rate)), scene], capture_output=True, text=True, check=False)
    lines = [line for line in done.stdout.splitlines() if line.startswith('hand on')]
    return lines[0] if lines else (done.stderr.strip().splitlines() or ['no word of scene_check'])[-1]


def name_of(study, condition):
    differing = [k for k in condition if k != 'name' and (k == study.parameter or any(c.get(k) != condition[k] for c in study.conditions))]
    return condition.get('name') or ' '.join(f'{k}={condition[k]:g}' if isinstance(condition[k], float) else f'{k}={condition[k]}'
                                             for k in differing or condition)


def order_lines(study, order):
    if study.staircase:
        rules = study.staircase
        share = 0.5 ** (1 / rules.down)
        yield (f'order: {len(rules.tracks)} interleaved staircases, {rules.down} down {rules.up} up, from {rules.start:g} times '
               'the standard' + (f'; each settles at {100 * share:.1f} % right' if rules.up == 1 else ''))
    else:
        yield f'order ({study.order}, seed {order.seed}) of {order.subject}, session {order.session}:'
    plan = order.plan or [order.next([])]
    for trial in plan[:SHOWN_TRIALS]:
        side = f', comparison in interval {trial.comparison + 1}' if study.task == 'two_interval' else ''
        yield f'  {trial.index + 1:4d}  block {trial.block}  {trial.kind}: {trial.name(study)}{side}'
    if order.plan and len(plan) > SHOWN_TRIALS:
        yield f'  ... {len(plan) - SHOWN_TRIALS} more; --order shows all'


def condition_lines(study, device, program, folder):
    from loop_rig import LoopRig
    previews = Previews(study, LoopRig(device), folder)
    unit = UNITS[study.measure]
    for condition in conditions_of(study):
        look = previews.of(condition)
        rate = condition.get('rate', study.rate)
        error = 100 * (look.presented.value / look.nominal - 1) if look.nominal else math.nan
        felt = (f'{study.measure} {look.nominal:.4g} {unit}'.rstrip() + f', presented {look.presented.value:.4g} ({error:+.2f} %)'
                if math.isfinite(look.presented.value) and math.isfinite(look.nominal) else 'nothing measured')
        limits = ', '.join(look.clamps) or 'none'
        yield (f'{name_of(study, condition)} at {rate:g} Hz: {felt}; contact {look.stiffness:.4g} N/m, '
               f'the hand is given {100 * look.share:.0f} % of it at least; peak {look.peak:.2f} N; limits that act: {limits}')
        yield '    ' + hand_line(program, device, condition_scene.write(study, condition, folder), rate)


def main():
    parser = argparse.ArgumentParser(prog='./run check', description=__doc__)
    parser.add_argument('study', metavar='STUDY')
    parser.add_argument('--subject', default='s01', metavar='ID')
    parser.add_argument('--session', type=int, default=1, metavar='N')
    parser.add_argument('--seed', type=int, metavar='N')
    parser.add_argument('--order', action='store_true', help='every trial')
    parser.add_argument('--device', required=True, help=argparse.SUPPRESS)
    parser.add_argument('--program', required=True, help=argparse.SUPPRESS)
    options = parser.parse_args()
    try:
        study = study_file.read(options.study)
        order = Order(study, options.subject, options.session, options.seed)
        trials, seconds = expected(study, order)
        print(f'study {study.name}: {study.title}')
        print(f'task {study.task}, {len(study.conditions)} conditions, {study.blocks} blocks, {study.practice} trials of practice')
        print(f"trials: {'about ' if study.staircase else ''}{trials}{f', at most {order.expected_trials()}' if study.staircase else ''}; "
              f'about {seconds / 60:.0f} min, {trial_seconds(study):.1f} s each')
        print(device_line(study, options.device))
        if options.order and order.plan:
            for trial in order.plan:
                print(f'{trial.index + 1} {trial.block} {trial.kind} {trial.name(study)} {trial.comparison + 1}')
        else:
            print('\n'.join(order_lines(study, order)))
        with tempfile.TemporaryDirectory(prefix='haptic_study_') as folder:
            print('what the hand gets, by the simulated hand on the twin:')
            for line in condition_lines(study, options.device, options.program, folder):
                print('  ' + line)
    except Refused as refusal:
        print(f'check: {refusal}', file=sys.stderr)
        return 1
    print(f'figure check.study_trials {trials} 1')
    return 0


if __name__ == '__main__':
    sys.exit(main())
