"""The first part of a report on one's own scene: three answers. What error at which run time, where the scene is stable, and what was left out of
its steps with the time that it saves."""
import html
import math
import os
import re
import subprocess

import matplotlib.pyplot as plt

import advice
import figures
from page import details, table, text
from pareto import front
from report_plan import DEFAULT, is_peer, is_wasm

COLUMN = 3.35   # [in]: one column of a two-column paper, 85 mm
# Of each engine: Okabe and Ito's colours, and a dash and a mark that tell them apart in grey.
ENGINES = {'this simulator': ('#000000', '-', 'o'), 'ode': ('#e69f00', '--', '^'), 'bullet': ('#0072b2', '-.', 's'), 'mujoco': ('#009e73', ':', 'D')}
NAMES = {'ode': 'ODE', 'bullet': 'Bullet', 'mujoco': 'MuJoCo'}
QUANTITIES = {'position': 'position error [m]', 'wrench': 'force error [N]'}
APART = 10       # [points] between labels
REPEATS = 5


def engine_of(run):
    if not is_peer(run.case.method):
        return 'this simulator'
    return re.match(r'[a-z]+', run.case.method).group(0)


def lines_of(result, metric):
    """{engine: [(CPU time per simulated second, error)]}: of each engine the runs that none of its own beats; of ours the default's alone."""
    points = {}
    for run, errors in advice.errors_of(result):
        usable = metric in errors and math.isfinite(run.cpu) and run.cpu > 0 and not is_wasm(run.case.method)
        if usable and (is_peer(run.case.method) or advice.can_be_written(run)):
            points.setdefault(engine_of(run), []).append((run.cpu, max(errors[metric], 1e-17)))
    return {engine: front(found) for engine, found in points.items()}


def picture(result, folder):
    """SVG and PDF of one column's width: a line per engine, its name at its end."""
    drawn = [metric for metric in QUANTITIES if any(len(line) for line in lines_of(result, metric).values()) and
             any(error > 1e-16 for line in lines_of(result, metric).values() for _, error in line)]
    if not drawn:
        return ''
    figure, axes = plt.subplots(len(drawn), 1, figsize=(COLUMN, 0.4 + 2.1 * len(drawn)), sharex=True, squeeze=False, layout='constrained')
    for axis, metric in zip(axes[:, 0], drawn):
        axis.set_xscale('log')
        axis.set_yscale('log')
        ends = []
        for engine, line in sorted(lines_of(result, metric).items()):
            colour, dash, mark = ENGINES.get(engine, ('#777777', '-', 'x'))
            colour = figures.INK if engine == 'this simulator' else colour
            x, y = [100 * cpu for cpu, _ in line], [error for _, error in line]
            axis.plot(x, y, dash, color=colour, marker=mark, markersize=4)
            ends.append((x[-1], y[-1], NAMES.get(engine, engine), colour))
        axis.set_ylabel(QUANTITIES[metric])
        axis.margins(x=0.35)
        figures.label_ticks(axis)
        axis.tick_params(labelsize=7)
        label(axis, ends)
    axes[-1, 0].set_xlabel('share of a core in real time [%]')
    os.makedirs(folder, exist_ok=True)
    figure.savefig(os.path.join(folder, result.scene.name + '-column.pdf'), metadata={'CreationDate': None})
    return figures.save(figure, folder, result.scene.name + '-column')


def label(axis, ends):
    """Each line's name beside its end, moved up where it would stand on another."""
    axis.figure.canvas.draw()
    scale, taken = 72 / axis.figure.dpi, -math.inf
    for x, y, name, colour in sorted(ends, key=lambda end: end[1]):
        at = axis.transData.transform((x, y))[1] * scale
        up = max(at, taken + APART) - at
        taken = at + up
        axis.annotate(name, (x, y), xytext=(5, up), textcoords='offset points', fontsize=8, color=colour, va='center')


def stability_rows(result):
    """[who, stable up to, first step that failed, why]: of the steps that were run."""
    rows = []
    methods = [DEFAULT, 'volume-verlet'] + sorted({run.case.method for run in result.runs if is_peer(run.case.method)})
    for method in methods:
        runs = sorted((run for run in result.runs if run.case.method == method and not run.case.accuracy and not run.case.facets and
                       result.own_stiffness(run.case)), key=lambda run: run.case.step)
        if not runs:
            continue
        if all(run.status == 'refused' for run in runs):
            rows.append([method, 'cannot run it', '', runs[0].reason])
            continue
        ok = [run for run in runs if run.status == 'ok']
        failed = [run for run in runs if run.status != 'ok' and (not ok or run.case.step > min(r.case.step for r in ok))]
        rows.append([method if is_peer(method) else {DEFAULT: 'this simulator', 'volume-verlet': 'explicit steps alone'}[method],
                     f'{1e3 * max(run.case.step for run in ok):.3g} ms' if ok else 'none of the steps',
                     f'{1e3 * failed[0].case.step:.3g} ms' if failed else 'none', failed[0].reason if failed else ''])
    return rows


def times(program, result, extra):
    """CPU times per simulated second [s] of the default at 1 ms, or [] where it does not run."""
    done = subprocess.run([program, result.scene.source, DEFAULT, '0.001', '--budget', '1', *extra], capture_output=True, text=True, check=False)
    words = dict(line.partition(' ')[::2] for line in done.stdout.splitlines())
    if words.get('status') != 'ok':
        return []
    return sorted(float(t) / float(words['time_reached']) for t in words['cpu_s'].split())


def saved(program, result):
    """Share of a step's time that what is left out saves [%]: median of pairs; NaN where it cannot be measured."""
    shares = []
    for _ in range(REPEATS):
        planned, general = times(program, result, []), times(program, result, ['--general'])
        if planned and general:
            shares.append(100 * (1 - planned[len(planned) // 2] / general[len(general) // 2]))
    return sorted(shares)[len(shares) // 2] if shares else math.nan


def plan_of(program, result):
    """(lines of what is left out, lines of the certificate)."""
    done = subprocess.run([program, '--plan', result.scene.source], capture_output=True, text=True, check=False)
    lines = [line.strip() for line in done.stdout.splitlines()]
    start = next((i for i, line in enumerate(lines) if line.startswith('certificate')), len(lines))
    return [line.removeprefix('left out ') for line in lines[:start] if line.startswith('left out')], lines[start:]


def error_words(result):
    """Smallest errors of the settings that are advised: (sentence, run)."""
    run, errors = advice.advised(result)
    if run is None:
        return 'No step of this simulator holds a loop of 1 kHz with this scene: the table of runs says why.', None
    kind = 'its exact motion' if result.total else 'its own converged motion'
    parts = [f"position within {errors['position']:.1e} m"] if 'position' in errors else []
    parts += [f"force within {errors['wrench']:.1e} N"] if 'wrench' in errors else []
    return (f"{' and '.join(parts)} of {kind} (rms over {result.scene.seconds:g} s), at {100 * run.cpu:.2g} % of a core; the "
            f'worst step takes {1e6 * run.slowest:.0f} µs.'), run


def section_of(result, program, folder):
    """(html, figures): of one scene."""
    sentence, run = error_words(result)
    left_out, certificate = plan_of(program, result)
    share = saved(program, result)
    body = f'<h3>What error, at which run time?</h3><p>{text(sentence[0].upper() + sentence[1:])}</p>' + \
        f'<div style="max-width:27rem">{picture(result, folder)}</div><p class=note>Each engine against its own converged motion; lower left is better. ' \
        f'The picture of one column\'s width: plots/{text(result.scene.name)}-column.pdf and .svg.</p>'
    if result.scene.not_for_peers:
        body += f'<p class=note>No other engine here runs this scene: {text(result.scene.not_for_peers)}.</p>'
    body += '<h3>Where is it stable?</h3>' + table(['who', 'longest step that ran well', 'first that failed', 'why'], stability_rows(result))
    body += details('The certificate of explicit steps at rest', f'<pre>{html.escape(chr(10).join(certificate))}</pre>')
    saving = f'It saves {share:.0f} % of the time of a step.' if math.isfinite(share) else ''
    body += '<h3>What is left out of its steps, and what does that save?</h3>' + (
        f'<p>{saving} The motion is the same to the last bit.</p><ul>' + ''.join(f'<li>{text(line)}</li>' for line in left_out) + '</ul>'
        if left_out else '<p>Nothing can be left out.</p>')
    last = f'Write into the scene: {advice.written(run)}; {sentence}' if run else sentence
    body += f'<p><b>{text(last)}</b></p>'
    return body, {'saved_pct': share, 'force_shown': bool(run and 'wrench' in advice.advised(result)[1]), 'peers': not result.scene.not_for_peers and
                  any(is_peer(r.case.method) and r.status == 'ok' for r in result.runs), 'last': last}
