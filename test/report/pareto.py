"""Who reaches an error with the least CPU time: the front, and the cells of the fixed list.

A cell is scene x metric x decade: the least CPU time per simulated second of any run whose total error is at most
10^decade. Cells that neither side reaches do not count; none of the others is left out. The list is the file
`pareto_cells.csv`, which is not derived from any result.
"""
import collections
import csv
import math
import os

CELLS = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'pareto_cells.csv')
MARGIN = 1.05     # a cell is won by 5 % or more; closer ones are level
CLOSE = 1.2       # of closer ones plots show the spread over repetitions
ROUNDING = 1e-9   # relative: a scene's list begins at one percent of its metre, radian, joule

Point = collections.namedtuple('Point', 'cpu error peer own run')
Point.__doc__ = '''A run in the plane of cost and error. `own`: with the stiffness of the scene itself.'''

Cell = collections.namedtuple('Cell', 'scene metric decade rounding ours our_run theirs their_run')
Cell.__doc__ = '''A reached cell: least CPU time per simulated second of ours and of the peers (inf: not reached), and the runs.
`rounding`: so small an error that it says nothing.'''


def read_cells(path=CELLS):
    """(scene, metric, decade, whether it is rounding) of the list."""
    cells = []
    with open(path, newline='') as file:
        for row in csv.DictReader(line for line in file if not line.startswith('#')):
            whole = int(row['largest']) + 2  # the decade of 100 %
            for decade in range(int(row['largest']), int(row['smallest']) - 1, -1):
                cells.append((row['scene'], row['metric'], decade, 10.0 ** (decade - whole) < 0.99 * ROUNDING))
    return cells


def read_defaults(path=CELLS):
    """{scene: which run of our default counts, 'said' or 'rigid'} of the list."""
    with open(path, newline='') as file:
        return {row['scene']: row['default'] for row in csv.DictReader(line for line in file if not line.startswith('#'))}


def best(points, limit):
    """(cpu, run) of the cheapest point with error <= limit; (inf, None) when there is none."""
    reached = [(p.cpu, p.run) for p in points if p.error <= limit and p.cpu > 0 and math.isfinite(p.cpu)]
    return min(reached, key=lambda pair: pair[0], default=(math.inf, None))


def limit_of(decade):
    return 10.0 ** decade * (1 + 1e-12)


def reached_cells(points, is_ours=lambda point: True, cells=None):
    """Cells that a peer or one of ours that `is_ours` takes reaches. `points`: {(scene, metric): [Point]}."""
    result = []
    for scene, metric, decade, rounding in cells if cells is not None else read_cells():
        of_cell = points.get((scene, metric), [])
        limit = limit_of(decade)
        ours = best([p for p in of_cell if not p.peer and is_ours(p)], limit)
        theirs = best([p for p in of_cell if p.peer], limit)
        if ours[1] is not None or theirs[1] is not None:
            result.append(Cell(scene, metric, decade, rounding, ours[0], ours[1], theirs[0], theirs[1]))
    return result


def only_wasm(wasm_points, cells_of_all, cells=None):
    """Cells of the list above rounding that an engine in WebAssembly reaches and nobody else; `cells_of_all`: what all others reach."""
    others = {(cell.scene, cell.metric, cell.decade) for cell in cells_of_all}
    return [(scene, metric, decade) for scene, metric, decade, rounding in (cells if cells is not None else read_cells())
            if not rounding and (scene, metric, decade) not in others and
            any(p.error <= limit_of(decade) for p in wasm_points.get((scene, metric), []))]


def verdict(cell):
    """won, lost, level (closer than the margin), only ours, only theirs."""
    if cell.our_run is None:
        return 'only theirs'
    if cell.their_run is None:
        return 'only ours'
    if MARGIN * cell.ours <= cell.theirs:
        return 'won'
    return 'lost' if MARGIN * cell.theirs <= cell.ours else 'level'


def decides_closely(cell):
    """Both reach it, and a fifth of the time or less decides."""
    return verdict(cell) in ('won', 'lost', 'level') and max(cell.ours, cell.theirs) < CLOSE * min(cell.ours, cell.theirs)


def counts(cells):
    """{verdict: number} above rounding, with 'contested' (both sides reach it), 'cells' and 'rounding' (listed apart)."""
    out = collections.Counter(verdict(cell) for cell in cells if not cell.rounding)
    out['contested'] = out['won'] + out['lost'] + out['level']
    out['cells'] = out['contested'] + out['only ours'] + out['only theirs']
    out['rounding'] = sum(cell.rounding for cell in cells)
    return out


def is_rigid(case):
    """All surfaces are said to be rigid, whatever the scene says."""
    return case.stiffness == math.inf


def comparisons(default):
    """The counts that stand side by side: {name: (what of ours takes part, for people)}. `chosen` is the headline: rigid or as the scene
    says, by the rule of the list."""
    as_it_comes = lambda p: p.run.case.method == default and not p.run.case.facets and not p.run.case.accuracy  # noqa: E731
    of_default = {'said': lambda p: p.own and as_it_comes(p), 'rigid': lambda p: is_rigid(p.run.case) and as_it_comes(p)}
    rule = read_defaults()
    return {'chosen': (lambda p: of_default[rule.get(p.run.case.scene, 'said')](p),
                       f'our default ({default}), rigid or with the stiffness that the scene says, as the list has it'),
            'default': (of_default['said'], f"our default ({default}), the scene's own stiffness"),
            'default_rigid': (of_default['rigid'], f'our default ({default}), all surfaces rigid'),
            'own_stiffness': (lambda p: p.own and not p.run.case.accuracy, "all our methods at the scene's own stiffness"),
            'all': (lambda p: True, 'all our methods at all stiffnesses and accuracies')}


def lost_ratio(cells):
    """The largest ratio by which ours loses a contested cell above rounding, and that cell; (1, None) when it loses none."""
    lost = [(cell.ours / cell.theirs, cell) for cell in cells if not cell.rounding and verdict(cell) == 'lost']
    return max(lost, key=lambda pair: pair[0], default=(1.0, None))


def front(points):
    """The points (cpu, error, ...) that no other point beats in both: by rising cost."""
    result = []
    for point in sorted((p for p in points if p[0] > 0 and p[1] >= 0), key=lambda p: (p[0], p[1])):
        if not result or point[1] < result[-1][1]:
            result.append(point)
    return result
