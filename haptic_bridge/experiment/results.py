"""From the rows of sessions to results: which trials count, what was fitted to them, and why the others are left out."""
import math
import os
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

import psychometric
import session_folder
import study as study_file
from strict_yaml import Refused
from trial_order import Order



@dataclass
class Session:
    """One session: its study, its info, its rows, and which of them count."""
    path: str
    info: dict
    study: object
    rows: list
    used: list = field(default_factory=list)
    left_out: Counter = field(default_factory=Counter)

    @property
    def subject(self):
        return self.info['subject']


def number(text):
    return float(text) if text != '' else math.nan


def read(path):
    info, rows = session_folder.read(path)
    study = study_file.read(os.path.join(path, 'study.yaml')) if os.path.exists(info['study_file']) is False else None
    if study is None:
        study = study_file.read(info['study_file'])
        if study.digest != info['study_sha256']:
            study = study_file.read(os.path.join(path, 'study.yaml'))
    session = Session(path, info, study, rows)
    for row in rows:
        reason = why_left_out(session.study, row)
        if reason:
            session.left_out[reason] += 1
        else:
            session.used.append(row)
    return session


def untouched(study, row, interval):
    """What should be presented there was not felt."""
    return study.measure != 'none' and row.get('nominal_' + interval, '') != '' and row.get('presented_' + interval) == ''


def why_left_out(study, row):
    if row['status'] != 'ok':
        return row['status']
    if row['trial_type'] == 'practice':
        return 'practice'
    if row['trial_type'] == 'catch':
        return 'catch'
    if row['within_tolerance'] == '0':
        return 'outside the tolerance'
    if row.get('contacts') == '0' or (study.task == 'two_interval' and any(untouched(study, row, i) for i in '12')):
        return 'nothing was touched'
    if study.task not in ('exploration',) and row['response'] == '':
        return 'no answer'
    return ''


def axis(study):
    """Name of the results' axis, and whether it is a logarithm of the ratio to the standard."""
    relative = study.standard.get(study.parameter, 0) > 0 if isinstance(study.standard.get(study.parameter), float) else False
    return (f'ln({study.parameter} / standard)' if relative else study.parameter), relative


def judged(study, rows):
    """(x, y) of two-answer trials. A staircase shows differences of one sign only: there x is signed by the interval, and y says that the
    second was answered; its PSE is the bias between intervals. Else y says that the comparison was judged greater."""
    _, relative = axis(study)
    x, y = [], []
    for row in rows:
        value = number(row['level'])
        value = math.log(value / study.standard[study.parameter]) if relative else value
        second = row['response'] == study.answers[1]
        if study.task == 'two_interval' and study.staircase:
            x.append(value if row['comparison'] == '2' else -value)
            y.append(second)
        elif study.task == 'two_interval':
            x.append(value)
            y.append(second == (row['comparison'] == '2'))
        else:
            x.append(value)
            y.append(second)
    return np.array(x), np.array(y, dtype=float)


def fit_rows(study, rows, seed=1):
    x, y = judged(study, rows)
    if len(x) == 0:
        return None, (x, y)
    return psychometric.fit(*psychometric.grouped(x, y), study.lapse, seed), (x, y)


def staircases(session):
    """[(track, levels by trial, reversals, threshold)] as the session's own rules give them."""
    study = session.study
    if not study.staircase:
        return []
    accepted = [r for r in session.rows if r['status'] in session_folder.ACCEPTED]
    answers = [{'1': True, '0': False}.get(r['correct']) for r in accepted]
    tracks, _ = Order(study, session.subject, session.info['session'], session.info['seed']).tracks(answers)
    out = []
    for track, staircase in tracks.items():
        levels = [number(r['level']) / study.standard[study.parameter] for r in accepted
                  if r['track'] == str(track) and r['trial_type'] == 'main']
        out.append((track, levels, staircase.reversals, staircase.threshold()))
    return out


def magnitudes(study, rows):
    """{level text: (n, geometric mean of the estimates over their session's mean, standard error of its log)}."""
    values = {}
    for row in rows:
        estimate = number(row['response'])
        if estimate > 0:
            values.setdefault(row['condition'], []).append(math.log(estimate))
    everything = np.concatenate([np.array(v) for v in values.values()]) if values else np.array([])
    centre = everything.mean() if len(everything) else 0.0
    return {name: (len(v), math.exp(np.mean(v) - centre), np.std(v, ddof=1) / math.sqrt(len(v)) if len(v) > 1 else math.nan)
            for name, v in values.items()}


def learning(rows):
    """(blocks of ten: share right), slope of right answers per trial with error and p."""
    right = np.array([1.0 if r['correct'] == '1' else 0.0 for r in rows if r['correct'] != ''])
    tens = [float(part.mean()) for part in np.split(right, range(10, len(right), 10)) if len(part)]
    return tens, psychometric.regression(np.arange(len(right)), right)


def response_times(rows):
    times = np.array([number(r['response_time']) for r in rows])
    times = times[np.isfinite(times)]
    return (len(times), *(float(q) for q in np.quantile(times, [0.25, 0.5, 0.75]))) if len(times) else (0,) + (math.nan,) * 3


def catches(session):
    rows = [r for r in session.rows if r['status'] == 'ok' and r['trial_type'] == 'catch' and r['correct'] != '']
    return len(rows), sum(r['correct'] == '1' for r in rows)


def same_study(sessions):
    digests = {s.info['study_sha256'] for s in sessions}
    if len(digests) > 1:
        raise Refused('the sessions are of different studies or of different texts of one: analyse each study by itself')
