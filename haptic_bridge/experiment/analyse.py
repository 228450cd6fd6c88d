#!/usr/bin/python3
"""Results of sessions: one HTML page and two CSV files. Every number says of how many trials it is, and which were left out and why.

A page is of all sessions that were ever analysed into it: PREFIX.sessions.json names them, and a call adds to them."""
import argparse
import csv
import io
import json
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE]

import numpy as np  # noqa: E402

import bids  # noqa: E402
import results  # noqa: E402
import results_page  # noqa: E402
from session_folder import COLUMNS, write_whole  # noqa: E402
from strict_yaml import Refused  # noqa: E402

FIT_COLUMNS = ('subject', 'trials', 'left_out', 'pse', 'pse_low', 'pse_high', 'jnd', 'jnd_low', 'jnd_high', 'identified', 'slope', 'lapse',
               'fit_p', 'threshold', 'median_response_time', 'catch_right', 'catch_trials')


def fit_row(study, name, sessions):
    """(row of FIT_COLUMNS, fit or None, figures)."""
    rows = [r for s in sessions for r in s.used]
    left = sum((s.left_out for s in sessions), start=type(sessions[0].left_out)())
    row = {'subject': name, 'trials': len(rows), 'left_out': '; '.join(f'{why} {n}' for why, n in sorted(left.items())) or 'none'}
    figures, fit = [], None
    if study.task in ('two_interval', 'two_alternative', 'yes_no'):
        fit, (x, y) = results.fit_rows(study, rows)
        if fit:
            row.update(pse=fit.pse, pse_low=fit.pse_interval[0], pse_high=fit.pse_interval[1], jnd=fit.jnd, jnd_low=fit.jnd_interval[0],
                       jnd_high=fit.jnd_interval[1], identified=int(fit.identified), slope=fit.slope, lapse=fit.lapse, fit_p=fit.fit_p)
        if len(x):
            figures.append(results_page.psychometric_plot(f'{name}: {len(x)} trials', study, fit, x, y))
    row['median_response_time'] = results.response_times(rows)[2]
    seen = [results.catches(s) for s in sessions]
    row['catch_trials'], row['catch_right'] = sum(n for n, _ in seen), sum(k for _, k in seen)
    return row, fit, figures


def csv_text(columns, rows):
    out = io.StringIO(newline='')
    writer = csv.DictWriter(out, columns, lineterminator='\n', extrasaction='ignore')
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def all_sessions(prefix, given):
    """Folders of the sessions of this page, those of earlier calls first; what is gone is said."""
    here = os.path.dirname(os.path.abspath(prefix))
    try:
        with open(prefix + '.sessions.json', encoding='utf-8') as file:
            known = [os.path.join(here, path) for path in json.load(file)]
    except (OSError, ValueError):
        known = []
    for path in known:
        if not os.path.exists(os.path.join(path, 'session.json')):
            print(f'analyse: {os.path.relpath(path)} is not there any more and is left out', file=sys.stderr)
    paths = [path for path in known if os.path.exists(os.path.join(path, 'session.json'))] + [os.path.abspath(path) for path in given]
    return sorted(set(map(os.path.normpath, paths)))


def analysed(study, sessions):
    """(rows, fits by name, figures): each subject, then all where there are several."""
    rows, fits, figures = [], {}, []
    for subject in sorted({s.subject for s in sessions}):
        own = [s for s in sessions if s.subject == subject]
        row, fits[subject], more = fit_row(study, subject, own)
        thresholds = []
        for session in own:
            drawn, found = results_page.session_figures(session)
            more += drawn
            thresholds += [t for t in found if math.isfinite(t)]
        row['threshold'] = float(np.exp(np.mean(np.log(thresholds)))) if thresholds else math.nan
        rows.append(row)
        figures += more
    if len(rows) > 1:
        row, fits['all'], more = fit_row(study, 'all', sessions)
        rows.append(row)
        figures = more + figures
    return rows, fits, figures


def main():
    parser = argparse.ArgumentParser(prog='./run analyse', description=__doc__)
    parser.add_argument('sessions', metavar='SESSION', nargs='+', help='folders sub-ID/ses-N of one study')
    parser.add_argument('--output', metavar='PREFIX', help='path and name of the files without ending; results beside the first session')
    options = parser.parse_args()
    try:
        root = os.path.dirname(os.path.dirname(os.path.abspath(options.sessions[0])))
        prefix = options.output or os.path.join(root, 'results')
        paths = all_sessions(prefix, options.sessions)
        sessions = [results.read(path) for path in paths]
        results.same_study(sessions)
        study = sessions[0].study
        rows, fits, figures = analysed(study, sessions)
        magnitudes = results.magnitudes(study, [r for s in sessions for r in s.used]) if study.task == 'magnitude' else {}
        write_whole(prefix + '.html', results_page.page(study, sessions, rows, fits, figures, magnitudes))
        write_whole(prefix + '.csv', csv_text(FIT_COLUMNS, rows))
        trials = [{'subject': s.subject, 'session': s.info['session'], **r} for s in sessions for r in s.rows]
        write_whole(prefix + '.trials.csv', csv_text(['subject', 'session', *COLUMNS], trials))
        here = os.path.dirname(os.path.abspath(prefix))
        write_whole(prefix + '.sessions.json', json.dumps([os.path.relpath(path, here) for path in paths], indent=2) + '\n')
        bids.write(root, study.title)
    except Refused as refusal:
        print(f'analyse: {refusal}', file=sys.stderr)
        return 1
    for row in rows:
        fit = fits.get(row['subject'])
        found = f'; {fit.jnd_text()}' if fit else ''
        if fit and fit.identified:
            found += f', PSE {fit.pse:+.4f} ({fit.pse_interval[0]:+.4f} to {fit.pse_interval[1]:+.4f})'
        print(f"{row['subject']}: {row['trials']} trials, left out: {row['left_out']}{found}")
    print(f'analyse: {prefix}.html of {len(sessions)} sessions, {prefix}.csv, {prefix}.trials.csv; the folder is a BIDS dataset')
    return 0


if __name__ == '__main__':
    sys.exit(main())
