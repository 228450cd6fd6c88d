"""Stability section: maps of where each method is stable, the extreme cases against peers, certificates of scenes."""
import csv
import glob
import io
import math
import os
import subprocess

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap

import figures
import programs
from page import Cell, details, table, text
from task_pool import Kept, Task, file_stamp, key_of, run_tasks, stamp_of

CPU_LIMIT = 20  # [s] per cell: one that works takes a second at most
# Verdicts of stability_cell and their colours, from good to bad.
VERDICTS = ('stable', 'restless', 'wrong', 'launch', 'diverged', 'unavailable')
COLOURS = ('#2e9e6b', '#e3c341', '#e08a2e', '#d2455a', '#7d1f3d', '#9aa4ad')
# Of a quick report: every other value of each axis and the methods that tell most.
QUICK_METHODS = ('verlet', 'implicit_euler', 'automatic', 'ode', 'bullet', 'mujoco')


def title(name):
    """Of a map: its last word is the axis of steps, or of the other quantity."""
    first, last = name.rsplit('_', 1)
    return f'{first.replace("_", " ")} against {last}'


def read_maps(program):
    """{map: {axis: (name, unit, [values])}} and the methods."""
    listed = subprocess.run([program, '--list'], capture_output=True, text=True, check=True).stdout
    maps = {}
    for row in csv.reader(io.StringIO(listed)):
        if len(row) > 4 and row[1] in ('x', 'y'):
            maps.setdefault(row[0], {})[row[1]] = (row[2], row[3], row[4:])
    methods = subprocess.run([program, '--methods'], capture_output=True, text=True, check=True).stdout.split()
    return maps, methods


def cell_tasks(program, maps, methods, quick):
    """{(map, method, x, y): Task}; the values stay text, as the program printed them."""
    stamp = stamp_of(program)
    cells = {}
    for name, axes in maps.items():
        xs, ys = axes['x'][2], axes['y'][2]
        if quick:
            xs, ys = xs[::2], ys[::2]
        for method in methods:
            for x in xs:
                for y in ys:
                    command = (program, name, method, x, y)
                    cells[(name, method, x, y)] = Task(key_of(stamp, *command[1:]), command, CPU_LIMIT, 1.0)
    return cells


def verdict_of(result):
    """Verdict of a cell; what crashes, hangs or prints nothing has diverged."""
    if result['failure']:
        return 'diverged'
    lines = [line for line in result['output'].splitlines() if line.count(',') >= 4]
    word = lines[-1].split(',')[4] if lines else ''
    return word if word in VERDICTS else 'diverged'


def draw_map(name, axes, methods, verdicts, quick, folder):
    """One picture per map, one panel per method."""
    xs, ys = (axes[axis][2][::2] if quick else axes[axis][2] for axis in 'xy')
    columns = min(4, len(methods))
    rows = math.ceil(len(methods) / columns)
    figure, panels = plt.subplots(rows, columns, figsize=(2.7 * columns + 0.6, 2.3 * rows + 0.9), squeeze=False, sharex=True,
                                  sharey=True)
    norm = BoundaryNorm(np.arange(len(VERDICTS) + 1) - 0.5, len(VERDICTS))
    for axis in panels.flat[len(methods):]:
        axis.set_visible(False)
    for axis, method in zip(panels.flat, methods):
        grid = [[VERDICTS.index(verdicts[(name, method, x, y)]) for x in xs] for y in ys]
        axis.imshow(grid, origin='lower', aspect='auto', cmap=ListedColormap(COLOURS), norm=norm, interpolation='nearest')
        axis.set_title(method)
        axis.grid(False)
        for which, values, place in ((axis.set_xticks, xs, 'x'), (axis.set_yticks, ys, 'y')):
            every = max(1, len(values) // 4)
            which(range(0, len(values), every), [f'{float(v):.0e}' for v in values[::every]])
            axis.tick_params(axis=place, labelsize=7)
    figure.supxlabel(f'{axes["x"][0]} [{axes["x"][1]}]', fontsize=9)
    figure.supylabel(f'{axes["y"][0]} [{axes["y"][1]}]', fontsize=9)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colour) for colour in COLOURS]
    figure.legend(handles, VERDICTS, loc='upper center', ncol=6, fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.93 if rows > 1 else 0.88))
    return figures.save(figure, folder, f'stability-{name}')


def map_section(program, options, folder):
    maps, methods = read_maps(program)
    if options.quick:
        methods = [method for method in methods if method in QUICK_METHODS] or methods
    cells = cell_tasks(program, maps, methods, options.quick)
    kept = Kept(os.path.join(options.output, 'runs'))
    results = run_tasks(list(cells.values()), kept, 'stability', options.scheduler, options.workers)
    verdicts = {cell: verdict_of(results[task.key]) for cell, task in cells.items()}
    with open(os.path.join(options.output, 'stability.csv'), 'w', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(['map', 'method', 'x', 'y', 'verdict', 'rms_error', 'rise', 'steps', 'cpu_s'])
        for cell, task in cells.items():
            lines = results[task.key]['output'].strip().splitlines()
            row = lines[-1].split(',') if lines and lines[-1].count(',') >= 8 else [*cell, verdicts[cell], '', '', '', '']
            writer.writerow(row[:4] + [verdicts[cell]] + row[5:])
    body = (f'<p>{len(cells)} cells, each a process of its own. Stable: at rest where it belongs. Restless: still moving. '
            'Wrong: at rest elsewhere. Launch: rose by more than its size. Diverged: not finite, crashed or hung.</p>')
    share = []
    for name, axes in maps.items():
        body += draw_map(name, axes, methods, verdicts, options.quick, folder).replace(
            '</figure>', f'<figcaption>{text(title(name))}</figcaption></figure>')
        of_map = [cell for cell in cells if cell[0] == name]
        share.append([title(name)] + [
            100.0 * sum(verdicts[c] == 'stable' for c in of_map if c[1] == method) /
            max(1, sum(c[1] == method for c in of_map)) for method in methods])
    return body + '<h4>Stable cells [%]</h4>' + table(['map'] + methods, share)


def extreme_section(program, options):
    """The twelve extreme cases by each method: a process per case."""
    listed = subprocess.run([program, '--list'], capture_output=True, text=True, check=True).stdout.splitlines()
    cases = [line.split(' ', 1)[1] for line in listed if line.startswith('case ')]
    methods = [line.split(' ', 1)[1] for line in listed if line.startswith('method ')]
    stamp = stamp_of(program)
    tasks = {}
    steps = ('1e-3',) if options.quick else ('1e-3', '1e-2')
    for step in steps:
        for method in methods:
            for index in range(len(cases)):
                command = (program, str(index), method, step)
                tasks[(index, method, step)] = Task(key_of(stamp, *command[1:]), command, 3 * CPU_LIMIT, 5.0)
    results = run_tasks(list(tasks.values()), Kept(os.path.join(options.output, 'runs')), 'extremes', options.scheduler,
                        options.workers)
    body = ''
    for step in steps:
        rows, sums = [], [0] * len(methods)
        for index, case in enumerate(cases):
            row = [case]
            for k, method in enumerate(methods):
                result = results[tasks[(index, method, step)].key]
                words = result['failure'] or result['output'].strip() or 'printed nothing'
                passed = words.startswith('passed')
                sums[k] += passed
                row.append(Cell('passed' if passed else words.split(':')[-1].strip()[:40], int(passed), 'won' if passed else 'lost'))
            rows.append(row)
        rows.append(['passed'] + [Cell(str(count), count) for count in sums])
        body += f'<h4>Steps of {1e3 * float(step):g} ms</h4>' + table(['case'] + methods, rows)
    return body


def certificates(program, root, options):
    """Certificate text of each scene file, from scene_check."""
    stamp = stamp_of(program)
    files = sorted(glob.glob(os.path.join(root, 'urdf', 'scenes', '*.urdf')))
    tasks = {file: Task(key_of(stamp, file_stamp(file), 'certificate', file), (program, '--all', file), 6 * CPU_LIMIT, 1.0)
             for file in files}
    results = run_tasks(list(tasks.values()), Kept(os.path.join(options.output, 'runs')), 'certificates', options.scheduler,
                        options.workers)
    rows = ''
    for file, task in tasks.items():
        result = results[task.key]
        output = result['failure'] or result['output'][max(result['output'].rfind('certificate'), 0):]
        rows += details(os.path.basename(file), f'<pre>{text(output)}</pre>')
    return rows


def sections(options, folder, whole):
    """[(title, anchor, html)] of what is built; a program that is missing is named in its place. `whole`: with the maps and
    certificates, not the extreme cases alone."""
    out = []
    cell_program, extreme_program, check_program = (programs.find(options.programs, name) for name in
                                                    ('stability_cell', 'extreme_cell', 'scene_check'))
    if whole:
        out.append(('Stability maps', 'stability', map_section(cell_program, options, folder) if cell_program else
                    '<p>stability_cell is not built.</p>'))
    if extreme_program:
        out.append(('Extreme cases', 'extremes', extreme_section(extreme_program, options)))
    if whole and check_program:
        out.append(('Certificates', 'certificates', '<p>What `./run check` says of each scene: the largest stable step of velocity Verlet '
                    'of its contacts and islands.</p>' + certificates(check_program, programs.ROOT, options)))
    return out
