"""Plots of the report, as SVG that follows the page's light or dark colours, and as PNG."""
import html
import io
import math
import os
import re

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402  (the backend is chosen first)
from matplotlib import ticker  # noqa: E402
import numpy as np  # noqa: E402

import advice  # noqa: E402
from pareto import front  # noqa: E402
from report_plan import is_peer, is_wasm  # noqa: E402
from run_errors import METRICS, order_of  # noqa: E402

# Stand for colours of the page; replaced in the SVG.
INK, FAINT = '#102030', '#a0b0c0'
# Okabe and Ito's palette, which colour-blind eyes tell apart, in shades that are read on white and on black. Ours are cold and
# filled with round or square marks, peers warm with pointed ones.
STYLES = {
    'volume-verlet': ('#1f78c8', 'o'), 'volume-implicit': ('#b070c8', 's'),
    'volume-sdirk2': ('#8050b8', 's'), 'volume-automatic': ('#009e73', 'D'), 'point-verlet': ('#7d8894', 'h'),
    'ode_exact': ('#e69f00', '^'), 'ode_exact_firm': ('#e69f00', '>'), 'ode_quick20': ('#c08a10', '^'),
    'ode_quick10': ('#c08a10', 'v'), 'ode_quick100_firm': ('#c08a10', '>'), 'bullet10': ('#d55e00', 'P'),
    'bullet5': ('#d55e00', 'v'), 'bullet50': ('#b84a10', 'P'), 'bullet200_firm': ('#b84a10', '>'),
    'bullet_dantzig': ('#e07848', '*'), 'ode_quick20_sleeps': ('#c08a10', '<'), 'bullet10_sleeps': ('#d55e00', '<'),
    'mujoco_euler': ('#a08c10', 'X'), 'mujoco_rk4': ('#807010', 'X'),
    'mujoco_firm': ('#a08c10', '>'), 'mujoco_fast': ('#a08c10', 'v'),
    'mujoco3_euler': ('#6a4fb0', 'X'), 'mujoco3_implicitfast': ('#6a4fb0', 'o'), 'mujoco3_elliptic': ('#6a4fb0', 'D'),
    'mujoco3_firm': ('#6a4fb0', '>'), 'jolt': ('#b03060', 'X'), 'jolt_firm': ('#b03060', '>'), 'rapier': ('#7a3b10', 'X'),
    'rapier_firm': ('#7a3b10', '>'),
    'exact': (INK, None),
}
DEFAULT_COLOUR, THEIRS = '#009e73', '#d55e00'  # of our default and its front; of the peers' front
ACCURACY = 0.03  # of the default where a run says none
# What our names mean; the peers' say it themselves (`report_run --peers`).
MEANINGS = {
    'volume-verlet': 'pressure over the contact volume, velocity Verlet',
    'volume-implicit': 'the same, implicit Euler', 'volume-sdirk2': 'the same, SDIRK2 (implicit, second order)',
    'volume-automatic': 'implicit at second order where something touches, exact flight where nothing does, island by island',
    'point-verlet': 'a spring at the deepest point, velocity Verlet: for comparison',
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
    alt = '; '.join(filter(None, (alt_of(axes) for axes in figure.axes)))
    plt.close(figure)
    svg = buffer.getvalue()
    with open(os.path.join(folder, name + '.svg'), 'w') as file:
        file.write(svg)
    return for_page(svg, name, alt)


def alt_of(axes):
    """What a plot shows, for those who do not see it: its title, and its axes with their units."""
    named = [f'{way} {label}' for way, label in (('up', axes.get_ylabel()), ('to the right', axes.get_xlabel())) if label]
    return ': '.join(filter(None, (axes.get_title(), ', '.join(named))))


def _style_once(match):
    """A group of marks of one style, with the style on the group."""
    styles = set(re.findall(r' style="([^"]*)"', match.group(2)))
    if len(styles) != 1:
        return match.group(0)
    return f'<g{match.group(1)} style="{styles.pop()}">' + re.sub(r' style="[^"]*"', '', match.group(2)) + '</g>'


def for_page(svg, name, alt=''):
    """The <svg> element alone, with the page's colours, fluid in width."""
    svg = svg[svg.index('<svg'):]
    svg = re.sub(r'<metadata>.*?</metadata>', '', svg, flags=re.S)
    svg = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', f'role="img" aria-label="{html.escape(alt)}"', svg, count=1)
    svg = svg.replace(INK, 'currentColor').replace(FAINT, 'var(--faint)')
    svg = re.sub(r'(?<![>\d.])(\d+\.\d)\d+', r'\1', svg)  # tenths of a point are enough; labels keep their digits
    svg = re.sub(r'>\s+<', '><', svg)
    # What the page says once, or nobody needs: families of fonts, names of groups, turns by nothing, the same style per mark.
    svg = re.sub(r"(font: [\d.]+px) '[^;\"]*", r'\1 sans-serif', svg)
    svg = re.sub(r'<g id="\w+_\d+">', '<g>', svg)
    svg = re.sub(r' transform="rotate\(-?0 [^)]*\)"', '', svg)
    svg = svg.replace(' \n', '')
    svg = re.sub(r'<g([^>]*)>((?:<use [^>]*/>)+)</g>', _style_once, svg)
    return f'<figure id="{name}">{svg}</figure>'


def _log_limits(axes):
    """Logarithmic axes with decades as ticks, and 2 and 5 between them where there are few."""
    axes.set_xscale('log')
    axes.set_yscale('log')


def _ticks(axis, low, high):
    decades = math.log10(high / low)
    if decades < 2.5:
        axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    else:
        axis.set_major_locator(ticker.LogLocator(numticks=9))
    axis.set_major_formatter(ticker.FuncFormatter(lambda x, _: f'{x:g}'))
    axis.set_minor_locator(ticker.NullLocator())


def label_ticks(axes):
    _ticks(axes.xaxis, *axes.get_xlim())
    _ticks(axes.yaxis, *axes.get_ylim())


def cpu_of(run):
    return run.cpu


def worst_step_of(run):
    return 1e6 * run.slowest


def work_precision(scene, runs, metric, folder, is_default, links, close=(), cost=cpu_of, name='total', kind='total'):
    """Error against a cost: our default over its steps and over `accuracy`, the peers, faintly our other methods; failed runs on the upper
    edge. `runs`: (run, {metric: error}); `is_default` of a run: one of our default, at any accuracy; `links`: {id of a run: address};
    `close`: cases whose spread over repetitions is drawn, for little decides their cells; `cost` of a run: CPU time per simulated second
    [s], or of the worst step [µs]."""
    figure, axes = plt.subplots(figsize=(8.6, 5.2))
    _log_limits(axes)
    groups, sides, accuracies, wasm = {}, {False: [], True: []}, [], {}
    for run, errors in runs:
        if metric in errors and (is_wasm(run.case.method) or math.isnan(cost(run))):
            wasm.setdefault(run.case.method, []).append(max(errors[metric], 1e-17))
        elif metric in errors and math.isfinite(cost(run)) and cost(run) > 0:
            error = max(errors[metric], 1e-17)  # zero error: on the axis
            peer, point = is_peer(run.case.method), (cost(run), error)
            ours = is_default(run)
            if ours and math.isclose(run.case.step, 1e-3):
                accuracies.append((run.case.accuracy or ACCURACY, point))
            if run.case in close and cost is cpu_of:
                axes.plot((run.cpu_low, run.cpu_high), (error, error), '|-', color=INK, lw=0.8, ms=5, zorder=1)
            if peer or ours and not run.case.accuracy:
                sides[peer].append(point)
            group = run.case.method if peer else 'our default' if ours else 'our other methods'
            groups.setdefault(group, []).append((*point, links.get(id(run))))
    seen = {}
    for group, members in sorted(groups.items(), key=lambda item: item[0] != 'our other methods'):
        colour, marker = {'our default': (DEFAULT_COLOUR, 'D'), 'our other methods': (FAINT, 'o')}.get(group) or style_of(group)
        xs, ys, addresses = zip(*members)
        seen[group] = axes.scatter(xs, ys, s=12 if group == 'our other methods' else 30, marker=marker, color=colour, linewidths=0.9, zorder=2)
        seen[group].set_urls(addresses)
    if len(accuracies) > 1:
        accuracies.sort()
        seen['our default at 1 ms over accuracy'], = axes.plot(*zip(*(point for _, point in accuracies)), '-', color=DEFAULT_COLOUR, lw=2.2)
        for accuracy, point in (accuracies[0], accuracies[-1]):
            axes.annotate(f'{accuracy:g}', point, xytext=(4, -10), textcoords='offset points', color=DEFAULT_COLOUR, fontsize=8)
    for method, members in wasm.items():  # on the right edge: their times are not comparable, or not known
        colour, marker = style_of(method)
        seen[method + ', error only'], = axes.plot([0.99] * len(members), members, ls='none', marker=marker, color=colour, ms=5.5, mew=0.9,
                                                   mfc='none', transform=axes.get_yaxis_transform(), clip_on=False)
    for peers, colour, label, dash in ((False, DEFAULT_COLOUR, 'our default', ':'), (True, THEIRS, 'peers', '--')):
        line = front(sides[peers])
        if line:
            handle, = axes.plot([p[0] for p in line], [p[1] for p in line], dash, color=colour, lw=1.6, drawstyle='steps-post')
            seen['front of ' + label] = handle
            axes.annotate(label, line[-1], xytext=(7, 6), textcoords='offset points', color=colour, fontsize=10, weight='bold')
    failures(axes, [run for run, _ in runs if run.status != 'ok'], cost)
    axes.set_xlabel('CPU time per simulated second [s]' if cost is cpu_of else 'CPU time of the worst step [µs]')
    axes.set_ylabel(f'{metric.replace("_", " ")} error [{METRICS[metric][0]}]')
    axes.set_title(f'{scene.name}: {kind} error', pad=14)
    label_ticks(axes)
    if seen:
        figure.legend(seen.values(), seen.keys(), loc='lower center', ncol=5, bbox_to_anchor=(0.5, 0), fontsize=8)
    figure.tight_layout(rect=(0, 0.04 + 0.033 * math.ceil(len(seen) / 5), 1, 1))
    return save(figure, folder, f'{scene.name}-{name}')


def failures(axes, failed, cost):
    """Failed runs: a cross on the upper edge, at their cost where it is known, else at the left."""
    if not failed:
        return
    low = axes.get_xlim()[0] if axes.lines or axes.collections else 1e-4
    for run in failed:
        x = cost(run) if math.isfinite(cost(run)) and cost(run) > 0 else low
        axes.plot([x], [0.985], 'x', color=FAILED, ms=6, mew=1.4, transform=axes.get_xaxis_transform(), clip_on=False)
    axes.text(0.99, 0.94, f'{len(failed)} failed', color=FAILED, fontsize=8, ha='right', va='top', transform=axes.transAxes)


def holders(holding, folder):
    """How many scenes each engine holds at 1 kHz within one percent, and at which share of a core. `holding`: advice.Holder."""
    figure, axes = plt.subplots(figsize=(7.2, 0.62 * len(holding) + 0.9))
    axes.grid(False, axis='y')
    for row, holder in enumerate(reversed(holding)):
        count, ours = len(holder.runs), holder.engine == 'ours'
        axes.barh(row, count, height=0.6, color=DEFAULT_COLOUR if ours else THEIRS)
        share = f', {100 * advice.median_share(holder.runs.values()):.2g} % of a core' if holder.runs else ''
        axes.text(count + 0.01 * holder.scenes, row, f'{count}{share}', va='center', fontsize=9)
    axes.set_yticks(range(len(holding)), ['our default' if h.engine == 'ours' else h.setting for h in reversed(holding)])
    axes.set_xlim(0, 1.25 * max(1, max(h.scenes for h in holding)))
    axes.set_xlabel(f'scenes of {holding[0].scenes} held at 1 kHz with every error below 1 %')
    figure.tight_layout()
    return save(figure, folder, 'holders')


def numerical(scene, runs, metric, folder):
    """Error against the model's own converged solution: over the step with the observed order, and over cost.
    `runs`: (run, {metric: error}, how far the reference has converged)."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.2, 3.5))
    _log_limits(left)
    _log_limits(right)
    groups = {}
    for run, errors, doubt in runs:
        if metric in errors and run.case.facets == 0 and not run.case.accuracy:
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
    left.set_ylabel(f'numerical {metric.replace("_", " ")} error [{METRICS[metric][0]}]')
    left.set_title('over the step; dotted: convergence of the reference')
    right.set_xlabel('CPU time per simulated second [s]')
    right.set_title('the same over cost')
    label_ticks(left)
    label_ticks(right)
    handles, labels = left.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc='lower center', ncol=4, bbox_to_anchor=(0.5, 0), fontsize=7)
    figure.tight_layout(rect=(0, 0.06 + 0.05 * math.ceil(len(labels) / 4), 1, 1))
    return save(figure, folder, f'{scene.name}-numerical'), orders

