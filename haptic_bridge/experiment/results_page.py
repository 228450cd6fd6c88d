"""Results of a study as one page in the style of the page of a session (penalty_sim/session): tables in words, figures, both themes."""
import math
import os
from html import escape

import numpy as np
from scipy import stats

import psychometric
import results

HERE = os.path.dirname(os.path.abspath(__file__))
CSS = os.path.join(os.path.dirname(os.path.dirname(HERE)), 'penalty_sim', 'session', 'session_page.css')
STYLE = '''.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 24rem), 1fr)); gap: 0.5rem 1.5rem; }
.figures svg { width: 100%; height: auto; } .figures text { fill: var(--ink); font: 12px system-ui, sans-serif; }
.frame { fill: none; stroke: var(--faint); } .curve { fill: none; stroke: var(--c1); stroke-width: 2; } .band { fill: var(--c1); opacity: 0.18; }
.point { fill: var(--c0); } .bar { stroke: var(--c0); stroke-width: 1.5; } .table table { min-width: 34rem; } .kept { white-space: nowrap; }'''
SCRIPT = '''const root = document.documentElement, dark = matchMedia('(prefers-color-scheme: dark)');
const set = to => { root.dataset.theme = to ? 'dark' : 'light'; };
set(dark.matches); dark.addEventListener('change', event => set(event.matches));
document.getElementById('theme').addEventListener('click', () => set(root.dataset.theme !== 'dark'));'''
WIDTH, HEIGHT, LEFT, RIGHT, BOTTOM = 420, 280, 46, 18, 44
TASKS = {'two_interval': 'comparisons of two intervals', 'two_alternative': 'two answers to one interval', 'yes_no': 'yes or no',
         'magnitude': 'estimates of magnitude', 'exploration': 'exploration'}


def rounded(value, width):
    """A number to a tenth of the width of its interval."""
    if not math.isfinite(value):
        return ''
    digits = max(0, 1 - math.floor(math.log10(width))) if width > 0 else 3
    return signed(f'{round(value, digits) + 0.0:.{digits}f}')  # + 0.0: no -0


def with_interval(value, interval):
    low, high = interval
    width = (high - low) if math.isfinite(high) else abs(low)
    if not math.isfinite(value):
        side = f', at most {rounded(high, high)}' if math.isfinite(high) else f', at least {rounded(low, low)}' if low > 0 else ''
        return f'not identified{side}'
    return f'{rounded(value, width)} ({rounded(low, width)} to {rounded(high, width)})'


def shown(value, digits=3):
    return '' if value is None or (isinstance(value, float) and not math.isfinite(value)) else f'{value:.{digits}g}'


def signed(text):
    """With the sign that stands in print."""
    return text.replace('-', '\N{MINUS SIGN}')


def ticks(low, high):
    """Three to six round values."""
    rough = (high - low) / 4 or 1.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = power * next(f for f in (1, 2, 5, 10) if f * power >= rough * (1 - 1e-9))
    return [round(i * step, 12) + 0.0 for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


class Plot:
    """An SVG in data coordinates; colours are the page's."""

    def __init__(self, title, x_label, y_label, x_range, y_range):
        (self.x0, self.x1), (self.y0, self.y1) = x_range, y_range
        self.out = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title)}"><text x="{WIDTH / 2}" y="16" '
                    f'text-anchor="middle">{escape(title)}</text><rect class="frame" x="{LEFT}" y="26" width="{WIDTH - LEFT - RIGHT}" '
                    f'height="{HEIGHT - BOTTOM - 26}"/>']
        for value in ticks(self.x0, self.x1):
            self.out.append(f'<text x="{self.x(value):.1f}" y="{HEIGHT - BOTTOM + 15}" text-anchor="middle">{signed(f"{value:.6g}")}</text>')
        for value in ticks(self.y0, self.y1):
            self.out.append(f'<text x="{LEFT - 5}" y="{self.y(value) + 4:.1f}" text-anchor="end">{signed(f"{value:.6g}")}</text>')
        self.out.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 8}" text-anchor="middle">{escape(x_label)}</text>')
        self.out.append(f'<text transform="translate(12,{HEIGHT / 2}) rotate(-90)" text-anchor="middle">{escape(y_label)}</text>')

    def x(self, value):
        return LEFT + (value - self.x0) / ((self.x1 - self.x0) or 1) * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        return HEIGHT - BOTTOM - (value - self.y0) / ((self.y1 - self.y0) or 1) * (HEIGHT - BOTTOM - 26)

    def path(self, points):
        return ' '.join(f'{self.x(x):.1f},{self.y(y):.1f}' for x, y in points)

    def curve(self, points):
        self.out.append(f'<polyline class="curve" points="{self.path(points)}"/>')

    def band(self, x, low, high):
        self.out.append(f'<polygon class="band" points="{self.path(list(zip(x, high)) + list(zip(x, low))[::-1])}"/>')

    def point(self, x, y, radius=3.0, bar=None):
        if bar:
            self.out.append(f'<line class="bar" x1="{self.x(x):.1f}" x2="{self.x(x):.1f}" y1="{self.y(bar[0]):.1f}" y2="{self.y(bar[1]):.1f}"/>')
        self.out.append(f'<circle class="point" cx="{self.x(x):.1f}" cy="{self.y(y):.1f}" r="{radius:.1f}"/>')

    def svg(self):
        return '<figure>' + ''.join(self.out) + '</svg></figure>'


def wilson(k, n):
    """95 % interval of a share (Wilson, JASA 22, 1927)."""
    z = 1.959964
    middle, half = (k + z * z / 2) / (n + z * z), z * math.sqrt(k * (n - k) / n + z * z / 4) / (n + z * z)
    return middle - half, middle + half


def binned(x, y):
    """Levels, counts, positives; many levels that were visited once (staircases) in eight bins."""
    levels, count, positive = psychometric.grouped(x, y)
    if len(levels) <= 12:
        return levels, count, positive
    place = np.clip(np.searchsorted(np.quantile(x, np.linspace(0, 1, 9)), x, 'right') - 1, 0, 7)
    kept = [i for i in range(8) if (place == i).any()]
    return [x[place == i].mean() for i in kept], [(place == i).sum() for i in kept], [y[place == i].sum() for i in kept]


def psychometric_plot(title, study, fit, x, y):
    label = 'share: second answered' if study.staircase and study.task == 'two_interval' else 'share: judged greater'
    low, high = float(x.min()), float(x.max())
    plot = Plot(title, results.axis(study)[0], label, (low, high), (0, 1))
    if fit and fit.identified:
        grid = np.linspace(low, high, 60)
        below, middle, above = fit.band(grid)
        plot.band(grid, below, above)
        plot.curve(list(zip(grid, middle)))
    for level, n, k in zip(*binned(x, y)):
        plot.point(level, k / n, 2 + 0.5 * math.sqrt(n), wilson(k, n))
    return plot.svg()


def session_figures(session):
    """(figures, thresholds): staircases and the learning curve of one session."""
    out, thresholds = [], []
    for track, levels, reversals, threshold in results.staircases(session):
        if not levels:
            continue
        thresholds.append(threshold)
        title = f'{session.subject}, track {track}: {len(reversals)} reversals, threshold {shown(threshold, 4)}'
        plot = Plot(title, 'trial', 'ratio to the standard', (1, max(2, len(levels))), (1, max(levels)))
        plot.curve([(i + 1, level) for i, level in enumerate(levels)])
        for i, level in enumerate(levels):
            plot.point(i + 1, level)
        out.append(plot.svg())
    tens, (slope, error, p) = results.learning(session.used)
    if len(tens) > 1:
        plot = Plot(f'{session.subject}: right answers, slope {shown(slope)} ± {shown(error)} a trial, p {shown(p, 2)}', 'trial', 'share right',
                    (0, 10 * len(tens)), (0, 1))
        for i, share in enumerate(tens):
            plot.point(10 * i + 5, share, 4, wilson(10 * share, 10))
        out.append(plot.svg())
    return out, thresholds


def html_table(head, rows):
    """Numbers right, words left; `head`: (text, kind): a number, words that stay in one line (None), or words that may break."""
    kind = lambda number: ' class="number"' if number else ' class="kept"' if number is None else ''  # noqa: E731
    cells = lambda tag, row: ''.join(f'<{tag}{kind(number)}>{escape(str(value))}</{tag}>' for value, (_, number) in zip(row, head))  # noqa: E731
    return ('<div class="table"><table><thead><tr>' + cells('th', [text for text, _ in head]) + '</tr></thead><tbody>' +
            ''.join(f"<tr>{cells('td', row)}</tr>" for row in rows) + '</tbody></table></div>')


def summary(rows, fits):
    """What was found, a line a subject."""
    has_fit, has_threshold = any(fits.values()), any(math.isfinite(r.get('threshold') or math.nan) for r in rows)
    has_catch, has_time = any(r['catch_trials'] for r in rows), any(math.isfinite(r['median_response_time']) for r in rows)
    head = [('subject', False), ('trials', True), ('left out', False)]
    head += [('JND (95 %)', None), ('PSE (95 %)', None), ('lapses', True), ('goodness of fit p', True)] if has_fit else []
    head += [('threshold', True)] * has_threshold + [('median answer [s]', True)] * has_time + [('catch trials right', True)] * has_catch
    out = []
    for row in rows:
        fit, cells = fits.get(row['subject']), [row['subject'], row['trials'], row['left_out']]
        if has_fit:
            cells += [with_interval(fit.jnd, fit.jnd_interval)] if fit else ['no slope to see']
            cells += [with_interval(fit.pse, fit.pse_interval), f'{100 * fit.lapse:.1f} %', f'{fit.fit_p:.2f}'] \
                if fit and fit.identified else [''] * 3
        cells += [shown(row.get('threshold'))] * has_threshold + [shown(row['median_response_time'])] * has_time
        cells += [f"{row['catch_right']} of {row['catch_trials']}"] * has_catch
        out.append(cells)
    return html_table(head, out)


def presented_table(sessions):
    """Presented stimuli against nominal ones, by condition."""
    found = {}
    for session in sessions:
        for row in session.used:
            for i in ('1', '2'):
                nominal, value = results.number(row['nominal_' + i]), results.number(row['presented_' + i])
                if math.isfinite(nominal) and math.isfinite(value) and nominal > 0:
                    found.setdefault(f'{nominal:.4g}', []).append(100 * (value / nominal - 1))
    rows = [(level, len(e), f'{np.mean(e):+.2f}', f'{np.max(np.abs(e)):.2f}') for level, e in sorted(found.items(), key=lambda kv: float(kv[0]))]
    head = [('nominal', True), ('intervals', True), ('mean error [%]', True), ('largest [%]', True)]
    return '<h2>What the device presented</h2>' + html_table(head, rows) if rows else ''


def over_subjects(fits):
    """Mean JND over subjects, on the log scale, with its t interval."""
    values = np.log([fit.jnd for fit in fits if fit and fit.identified])
    if len(values) < 2:
        return ''
    half = stats.t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
    mean, ends = math.exp(values.mean()), (math.exp(values.mean() - half), math.exp(values.mean() + half))
    return f'<p>JND over {len(values)} subjects: {with_interval(mean, ends)}, by t on the log scale.</p>'


def magnitudes_table(magnitudes):
    head = [('condition', False), ('trials', True), ('estimate over the mean', True), ('standard error of its log', True)]
    rows = [(name, n, f'{value:.3f}', shown(error)) for name, (n, value, error) in sorted(magnitudes.items())]
    return '<h2>Magnitudes</h2>' + html_table(head, rows) if rows else ''


def note_of(study):
    return (f'PSE and JND are of {results.axis(study)[0]}: JND is half the way from 25 % to 75 % of a cumulative normal, whose lapse rate is '
            f'estimated with {100 * study.lapse:g} % expected. Intervals are 95 % of the posterior; the shaded band is that of the curve, bars are '
            '95 % of each share. A goodness of fit near 0 says that no such curve gave these answers.')


def page(study, sessions, rows, fits, figures, magnitudes):
    with open(CSS, encoding='utf-8') as file:
        css = file.read()
    cards = [('sessions', len(sessions)), ('subjects', len({s.subject for s in sessions})),
             ('trials that count', sum(len(s.used) for s in sessions)), ('task', TASKS[study.task])]
    note = note_of(study) if any(fits.values()) else ''
    return ('<!DOCTYPE html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">'
            f'<title>{escape(study.title)}</title><style>{css}{STYLE}</style><button id="theme" type="button">light / dark</button>'
            f'<h1>{escape(study.title)}</h1><div class="cards">' +
            ''.join(f'<div>{escape(name)}<b>{escape(str(value))}</b></div>' for name, value in cards) + '</div>' +
            summary(rows, fits) + over_subjects([fits.get(r['subject']) for r in rows if r['subject'] != 'all']) +
            f'<p class="note">{escape(note)}</p><h2>Figures</h2><div class="figures">{"".join(figures)}</div>' +
            magnitudes_table(magnitudes) + presented_table(sessions) + f'<script>{SCRIPT}</script></html>')
