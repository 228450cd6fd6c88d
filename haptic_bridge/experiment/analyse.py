#!/usr/bin/python3
"""Results of sessions: one HTML page and two CSV files. Every number says of how many trials it is, and which were left out and why."""
import argparse
import csv
import io
import math
import os
import sys
from html import escape

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE]

import numpy as np  # noqa: E402

import psychometric  # noqa: E402
import results  # noqa: E402
from session_folder import COLUMNS, write_whole  # noqa: E402
from strict_yaml import Refused  # noqa: E402

STYLE = ('body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}table{border-collapse:collapse}'
         'td,th{border:1px solid #bbb;padding:.2em .6em;text-align:right}th{background:#eee}svg{margin:.5em 1em .5em 0}'
         'td:first-child,th:first-child{text-align:left}')
WIDTH, HEIGHT, MARGIN = 420, 280, 44
FIT_COLUMNS = ('subject', 'trials', 'left_out', 'pse', 'pse_low', 'pse_high', 'jnd', 'jnd_low', 'jnd_high', 'slope', 'deviance_p',
               'threshold', 'median_response_time', 'catch_right', 'catch_trials')


def shown(value, digits=3):
    return '' if value is None or (isinstance(value, float) and not math.isfinite(value)) else f'{value:.{digits}g}'


def plot(title, x_label, y_label, points, curves, x_range, y_range):
    """An SVG of points (x, y, radius) and curves (list of (x, y))."""
    x0, x1 = x_range
    y0, y1 = y_range
    to_x = lambda v: MARGIN + (v - x0) / ((x1 - x0) or 1) * (WIDTH - MARGIN - 10)  # noqa: E731
    to_y = lambda v: HEIGHT - MARGIN - (v - y0) / ((y1 - y0) or 1) * (HEIGHT - MARGIN - 26)  # noqa: E731
    out = [f'<svg width="{WIDTH}" height="{HEIGHT}" role="img" aria-label="{escape(title)}"><text x="{WIDTH / 2}" y="16" '
           f'text-anchor="middle">{escape(title)}</text><rect x="{MARGIN}" y="26" width="{WIDTH - MARGIN - 10}" '
           f'height="{HEIGHT - MARGIN - 26}" fill="none" stroke="#888"/>']
    for value in (x0, 0.5 * (x0 + x1), x1):
        out.append(f'<text x="{to_x(value):.1f}" y="{HEIGHT - MARGIN + 15}" text-anchor="middle" font-size="12">{value:.3g}</text>')
    for value in (y0, 0.5 * (y0 + y1), y1):
        out.append(f'<text x="{MARGIN - 5}" y="{to_y(value) + 4:.1f}" text-anchor="end" font-size="12">{value:.3g}</text>')
    out.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 8}" text-anchor="middle" font-size="13">{escape(x_label)}</text>')
    out.append(f'<text transform="translate(12,{HEIGHT / 2}) rotate(-90)" text-anchor="middle" font-size="13">{escape(y_label)}</text>')
    for curve in curves:
        path = ' '.join(f'{to_x(x):.1f},{to_y(y):.1f}' for x, y in curve)
        out.append(f'<polyline points="{path}" fill="none" stroke="#c33" stroke-width="1.5"/>')
    for x, y, radius in points:
        out.append(f'<circle cx="{to_x(x):.1f}" cy="{to_y(y):.1f}" r="{radius:.1f}" fill="#36c" fill-opacity=".7"/>')
    return ''.join(out) + '</svg>'


def psychometric_plot(title, study, fit, x, y):
    levels, count, positive = psychometric.grouped(x, y)
    if len(levels) > 12:  # a staircase visits many levels once: they are shown in bins
        edges = np.quantile(x, np.linspace(0, 1, 9))
        place = np.clip(np.searchsorted(edges, x, 'right') - 1, 0, 7)
        kept = [i for i in range(8) if (place == i).any()]
        levels = np.array([x[place == i].mean() for i in kept])
        count = np.array([(place == i).sum() for i in kept], float)
        positive = np.array([y[place == i].sum() for i in kept])
    points = [(a, k / n, 2 + math.sqrt(n)) for a, n, k in zip(levels, count, positive)]
    low, high = float(x.min()), float(x.max())
    grid = np.linspace(low, high, 80)
    curves = []
    if fit:
        p = psychometric.probability(grid, fit.pse, fit.sigma, study.lapse / 2, study.lapse / 2, fit.shape)
        curves = [list(zip(grid, p))]
    label = 'second answered' if study.staircase and study.task == 'two_interval' else 'judged greater'
    return plot(title, results.axis(study)[0], label, points, curves, (low, high), (0, 1))


def fit_row(study, name, sessions):
    """(row of FIT_COLUMNS, figures)."""
    rows = [r for s in sessions for r in s.used]
    left = sum((s.left_out for s in sessions), start=type(sessions[0].left_out)())
    row = {'subject': name, 'trials': len(rows), 'left_out': '; '.join(f'{why} {n}' for why, n in sorted(left.items())) or 'none'}
    figures = []
    if study.task in ('two_interval', 'two_alternative', 'yes_no'):
        fit, (x, y) = results.fit_rows(study, rows)
        if fit:
            row.update(pse=fit.pse, pse_low=fit.pse_interval[0], pse_high=fit.pse_interval[1], jnd=fit.jnd, jnd_low=fit.jnd_interval[0],
                       jnd_high=fit.jnd_interval[1], slope=fit.slope, deviance_p=fit.deviance_p)
        if len(x):
            figures.append(psychometric_plot(f'{name}, {len(x)} trials', study, fit, x, y))
    row['median_response_time'] = results.response_times(rows)[2]
    seen = [results.catches(s) for s in sessions]
    row['catch_trials'], row['catch_right'] = sum(n for n, _ in seen), sum(k for _, k in seen)
    return row, figures


def session_figures(session):
    """Staircases and the learning curve of one session."""
    out, thresholds = [], []
    for track, levels, reversals, threshold in results.staircases(session):
        if not levels:
            continue
        thresholds.append(threshold)
        points = [(i + 1, level, 3) for i, level in enumerate(levels)]
        title = f'{session.subject}, track {track}: {len(reversals)} reversals, {shown(threshold, 4)}'
        out.append(plot(title, 'trial', 'ratio to the standard', points, [[p[:2] for p in points]], (1, max(2, len(levels))),
                        (1, max(levels))))
    tens, (slope, error, p) = results.learning(session.used)
    if len(tens) > 1:
        points = [(10 * i + 5, share, 4) for i, share in enumerate(tens)]
        title = f'{session.subject}: right answers, slope {shown(slope)} ± {shown(error)} a trial, p {shown(p)}'
        out.append(plot(title, 'trial', 'share right', points, [[q[:2] for q in points]], (0, 10 * len(tens)), (0, 1)))
    return out, thresholds


def presented_table(sessions):
    """Presented stimuli against nominal ones, by condition."""
    found = {}
    for session in sessions:
        for row in session.used:
            for i in ('1', '2'):
                nominal, value = results.number(row['nominal_' + i]), results.number(row['presented_' + i])
                if math.isfinite(nominal) and math.isfinite(value) and nominal > 0:
                    found.setdefault(f'{nominal:.4g}', []).append(100 * (value / nominal - 1))
    lines = [f'<tr><td>{level}</td><td>{len(e)}</td><td>{np.mean(e):+.2f}</td><td>{np.max(np.abs(e)):.2f}</td></tr>'
             for level, e in sorted(found.items(), key=lambda kv: float(kv[0]))]
    return ('<h2>Presented stimuli</h2><table><tr><th>nominal</th><th>n</th><th>mean error [%]</th><th>largest [%]</th></tr>' +
            ''.join(lines) + '</table>') if lines else ''


def over_subjects(rows):
    """Mean JND over subjects, on the log scale, with its t interval."""
    from scipy import stats
    values = np.log([r['jnd'] for r in rows if r.get('jnd')])
    if len(values) < 2:
        return ''
    half = stats.t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
    mean = values.mean()
    return (f'<p>JND over {len(values)} subjects: {math.exp(mean):.4g}, 95 % interval {math.exp(mean - half):.4g} to '
            f'{math.exp(mean + half):.4g} (t, on the log scale).</p>')


def page(study, sessions, rows, figures, magnitudes):
    head = ''.join(f'<th>{escape(name)}</th>' for name in FIT_COLUMNS)
    body = ''.join('<tr>' + ''.join(f'<td>{escape(shown(r.get(c)) if isinstance(r.get(c), float) else str(r.get(c, "")))}</td>'
                                    for c in FIT_COLUMNS) + '</tr>' for r in rows)
    table = ''
    if magnitudes:
        table = ('<h2>Magnitudes</h2><table><tr><th>condition</th><th>n</th><th>estimate over the mean</th><th>s.e. of its log</th></tr>' +
                 ''.join(f'<tr><td>{escape(name)}</td><td>{n}</td><td>{value:.3f}</td><td>{shown(error)}</td></tr>'
                         for name, (n, value, error) in sorted(magnitudes.items())) + '</table>')
    note = ('PSE and JND are of ' + results.axis(study)[0] + f'; P rises as a cumulative normal, guess and lapse rate {study.lapse / 2:g} '
            'each; intervals are 95 %, parametric bootstrap of 500 draws; JND is half the way from 25 % to 75 %.')
    return (f'<!DOCTYPE html><meta charset="utf-8"><title>{escape(study.title)}</title><style>{STYLE}</style><h1>{escape(study.title)}</h1>'
            f'<p>{len(sessions)} sessions of {len({s.subject for s in sessions})} subjects. {escape(note)}</p>'
            f'<table><tr>{head}</tr>{body}</table>{over_subjects(rows[:-1])}{table}{presented_table(sessions)}'
            f'<h2>Figures</h2>{"".join(figures)}')


def csv_text(columns, rows):
    out = io.StringIO(newline='')
    writer = csv.DictWriter(out, columns, lineterminator='\n', extrasaction='ignore')
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def main():
    parser = argparse.ArgumentParser(prog='./run analyse', description=__doc__)
    parser.add_argument('sessions', metavar='SESSION', nargs='+', help='folders sub-ID/ses-N of one study')
    parser.add_argument('--output', metavar='PREFIX', help='path and name of the files without ending; results beside the first session')
    options = parser.parse_args()
    try:
        sessions = [results.read(path) for path in options.sessions]
        results.same_study(sessions)
        study = sessions[0].study
        rows, figures = [], []
        for subject in sorted({s.subject for s in sessions}):
            row, more = fit_row(study, subject, [s for s in sessions if s.subject == subject])
            thresholds = []
            for session in (s for s in sessions if s.subject == subject):
                drawn, found = session_figures(session)
                more += drawn
                thresholds += [t for t in found if math.isfinite(t)]
            row['threshold'] = float(np.exp(np.mean(np.log(thresholds)))) if thresholds else math.nan
            rows.append(row)
            figures += more
        row, more = fit_row(study, 'all', sessions)
        rows.append(row)
        magnitudes = results.magnitudes(study, [r for s in sessions for r in s.used]) if study.task == 'magnitude' else {}
        prefix = options.output or os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(options.sessions[0]))), 'results')
        write_whole(prefix + '.html', page(study, sessions, rows, more + figures, magnitudes))
        write_whole(prefix + '.csv', csv_text(FIT_COLUMNS, rows))
        trials = [{'subject': s.subject, 'session': s.info['session'], **r} for s in sessions for r in s.rows]
        write_whole(prefix + '.trials.csv', csv_text(['subject', 'session', *COLUMNS], trials))
    except Refused as refusal:
        print(f'analyse: {refusal}', file=sys.stderr)
        return 1
    for row in rows:
        print(f"{row['subject']}: {row['trials']} trials, left out: {row['left_out']}" +
              (f"; JND {row['jnd']:.4f} ({row['jnd_low']:.4f} to {row['jnd_high']:.4f}), PSE {row['pse']:+.4f} "
               f"({row['pse_low']:+.4f} to {row['pse_high']:+.4f})" if 'jnd' in row else ''))
    print(f'analyse: {prefix}.html, {prefix}.csv, {prefix}.trials.csv')
    return 0


if __name__ == '__main__':
    sys.exit(main())
