"""Plots of the report, as SVG that follows the page's light or dark colours, and as PNG."""
import io
import math
import os
import re

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402  (the backend is chosen first)
import numpy as np  # noqa: E402

from pareto import front  # noqa: E402
from run_errors import METRICS, error_over_time, order_of  # noqa: E402

# Stand for colours of the page; replaced in the SVG.
INK, FAINT = '#102030', '#a0b0c0'
# Readable on white and on black. Ours are cold and solid, peers warm.
STYLES = {
    'volume-euler': ('#3f9bd8', 'o'), 'volume-verlet': ('#2367d1', 'o'), 'volume-implicit': ('#8a63d2', 's'),
    'volume-sdirk2': ('#5b3fb0', 's'), 'volume-automatic': ('#1c9c84', 'D'), 'point-verlet': ('#7d8894', 'v'),
    'ode_exact': ('#e07b1a', '^'), 'ode_quick20': ('#e8a94c', '^'), 'bullet10': ('#d65a5a', 'P'),
    'bullet50': ('#b53030', 'P'), 'mujoco_euler': ('#b8a11f', 'X'), 'mujoco_rk4': ('#8d7b10', 'X'),
    'exact': (INK, None),
}
FAILED = '#e0245e'

plt.rcParams.update({
    'svg.fonttype': 'none', 'font.size': 9, 'font.family': 'sans-serif', 'text.color': INK, 'axes.edgecolor': INK,
    'axes.labelcolor': INK, 'xtick.color': INK, 'ytick.color': INK, 'axes.grid': True, 'grid.color': FAINT,
    'grid.linewidth': 0.4, 'axes.spines.top': False, 'axes.spines.right': False, 'axes.titlesize': 9,
    'legend.frameon': False, 'legend.fontsize': 8, 'axes.linewidth': 0.7, 'lines.linewidth': 1.2,
})


def style_of(method):
    return STYLES.get(method, ('#888888', '.'))


def save(figure, folder, name):
    """Writes NAME.svg and NAME.png into the folder, closes the figure, and returns the SVG for the page."""
    os.makedirs(folder, exist_ok=True)
    plt.rcParams['svg.hashsalt'] = name  # the same data give the same file; ids do not clash on one page
    figure.savefig(os.path.join(folder, name + '.png'), dpi=110, facecolor='white')
    buffer = io.StringIO()
    figure.savefig(buffer, format='svg', transparent=True, metadata={'Date': None})
    plt.close(figure)
    svg = buffer.getvalue()
    with open(os.path.join(folder, name + '.svg'), 'w') as file:
        file.write(svg)
    return for_page(svg, name)


def for_page(svg, name):
    """The <svg> element alone, with the page's colours, fluid in width."""
    svg = svg[svg.index('<svg'):]
    svg = re.sub(r'<metadata>.*?</metadata>', '', svg, flags=re.S)
    svg = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', 'role="img"', svg, count=1)
    svg = svg.replace(INK, 'currentColor').replace(FAINT, 'var(--faint)')
    svg = re.sub(r'(\d+\.\d)\d+', r'\1', svg)  # tenths of a point are enough
    svg = re.sub(r'>\s+<', '><', svg)
    return f'<figure id="{name}">{svg}</figure>'


def _log_limits(axes):
    axes.set_xscale('log')
    axes.set_yscale('log')


def _panels(count, width, height):
    """`count` panels in rows of two, and room for a legend below."""
    rows = math.ceil(count / 2)
    figure, panels = plt.subplots(rows, min(2, count), figsize=(width * min(2, count) + 0.4, height * rows + 0.6),
                                  squeeze=False)
    for axes in panels.flat[count:]:
        axes.set_visible(False)
    return figure, list(panels.flat[:count]), 0.6 / (height * rows + 0.6)


def work_precision(scene, runs, metrics, folder):
    """Total error against CPU time per simulated second, one panel per metric; failed runs on the upper edge.
    `runs`: (run, {metric: error})."""
    figure, panels, below = _panels(len(metrics), 4.6, 3.3)
    seen = {}
    for axes, metric in zip(panels, metrics):
        _log_limits(axes)
        groups = {}
        for run, errors in runs:
            if metric in errors and math.isfinite(run.cpu):
                own = not run.case.stiffness or run.case.stiffness == scene.stiffness
                # Zero error: on the axis.
                groups.setdefault((run.case.method, own), []).append((run, max(errors[metric], 1e-17)))
        for (method, own), members in groups.items():
            colour, marker = style_of(method)
            x = np.array([run.cpu for run, _ in members])
            spread = [x - [run.cpu_low for run, _ in members], [run.cpu_high for run, _ in members] - x]
            handle = axes.errorbar(x, [error for _, error in members], xerr=np.maximum(spread, 0), fmt=marker, color=colour,
                                   ms=4.5, elinewidth=0.5, mew=0.8, mfc=colour if own else 'none')
            seen.setdefault(method, handle)
        line = front([(run.cpu, error) for members in groups.values() for run, error in members])
        if line:
            axes.plot([p[0] for p in line], [p[1] for p in line], '-', color=INK, lw=0.8, zorder=0, drawstyle='steps-post')
        failures(axes, [run for run, _ in runs if run.status != 'ok'])
        axes.set_xlabel('CPU time per simulated second [s]')
        axes.set_title(f'{metric.replace("_", " ")} error [{METRICS[metric][0]}]', pad=10)
    if seen:
        figure.legend(seen.values(), seen.keys(), loc='lower center', ncol=6, bbox_to_anchor=(0.5, 0))
    figure.tight_layout(rect=(0, below, 1, 1))
    return save(figure, folder, f'{scene.name}-total')


def failures(axes, failed):
    """Failed runs: a cross on the upper edge, at their cost where it is known, else at the left."""
    if not failed:
        return
    low = axes.get_xlim()[0] if axes.lines or axes.collections else 1e-4
    for run in failed:
        x = run.cpu if math.isfinite(run.cpu) and run.cpu > 0 else low
        axes.plot([x], [0.985], 'x', color=FAILED, ms=6, mew=1.4, transform=axes.get_xaxis_transform(), clip_on=False)
    axes.text(0.99, 0.94, f'{len(failed)} failed', color=FAILED, fontsize=8, ha='right', va='top', transform=axes.transAxes)


def numerical(scene, runs, metric, folder):
    """Error against the model's own converged solution: over the step with the observed order, and over cost.
    `runs`: (run, {metric: error}, how far the reference has converged)."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.2, 3.5))
    _log_limits(left)
    _log_limits(right)
    groups = {}
    for run, errors, doubt in runs:
        if metric in errors and run.case.facets == 0:
            groups.setdefault((run.case.method, run.case.stiffness), []).append((run, errors[metric], doubt))
    orders = {}
    for (method, stiffness), members in sorted(groups.items()):
        members.sort(key=lambda m: m[0].case.step)
        colour, marker = style_of(method)
        steps = [m[0].case.step for m in members]
        errors = [max(m[1], 1e-17) for m in members]
        order, count = order_of(steps, errors)
        orders[(method, stiffness)] = (order, count)
        own = not stiffness or stiffness == scene.stiffness
        label = method + ('' if own else f', k {stiffness:.0e}') + (f': order {order:.1f}' if count >= 3 else '')
        left.plot([1e3 * h for h in steps], errors, '-' if own else '--', marker=marker, color=colour, ms=4,
                  mfc=colour if own else 'none', label=label)
        right.plot([m[0].cpu for m in members], errors, '-' if own else '--', marker=marker, color=colour, ms=4,
                   mfc=colour if own else 'none')
        worst = max((m[2] for m in members if math.isfinite(m[2])), default=0)
        if worst > 0:
            left.axhline(worst, color=colour, lw=0.6, ls=':')
    left.set_xlabel('step [ms]')
    left.set_title(f'numerical {metric} error [{METRICS[metric][0]}]; dotted: convergence of the reference')
    right.set_xlabel('CPU time per simulated second [s]')
    right.set_title(f'the same against cost [{METRICS[metric][0]}]')
    handles, labels = left.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc='lower center', ncol=4, bbox_to_anchor=(0.5, 0), fontsize=7)
    figure.tight_layout(rect=(0, 0.06 + 0.05 * math.ceil(len(labels) / 4), 1, 1))
    return save(figure, folder, f'{scene.name}-numerical'), orders


def growth(scene, runs, references, metrics, folder):
    """Errors over simulated time. `runs`: one per method; `references`: trajectory of each."""
    figure, panels, below = _panels(len(metrics), 4.6, 2.7)
    handles = {}
    for axes, metric in zip(panels, metrics):
        axes.set_yscale('log')
        for run, reference in zip(runs, references):
            values = error_over_time(run.trajectory, reference).get(metric)
            if values is None:
                continue
            colour, _ = style_of(run.case.method)
            line, = axes.plot(reference.time[:len(values)], np.maximum(values, 1e-17), color=colour, lw=1.1)
            handles.setdefault(run.case.method, line)
        axes.set_xlabel('simulated time [s]')
        axes.set_title(f'{metric.replace("_", " ")} error [{METRICS[metric][0]}]')
    if handles:
        figure.legend(handles.values(), handles.keys(), loc='lower center', ncol=6, bbox_to_anchor=(0.5, 0))
    figure.tight_layout(rect=(0, below, 1, 1))
    return save(figure, folder, f'{scene.name}-growth')
