"""Who reaches an error with the least CPU time: the front, and the cells of the fixed list.

A cell is scene x metric x decade: the least CPU time per simulated second of any run whose total error is at most
10^decade. Cells that nobody reaches do not count; none of the others is left out. The list is the file
`pareto_cells.csv`, which is not derived from any result.
"""
import collections
import csv
import math
import os

CELLS = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'pareto_cells.csv')

Cell = collections.namedtuple('Cell', 'scene metric decade ours our_run theirs their_run')
Cell.__doc__ = '''A reached cell: least CPU time per simulated second of ours and of the peers (inf: not reached), and the runs.'''


def read_cells(path=CELLS):
    """(scene, metric, decade) of the list."""
    cells = []
    with open(path, newline='') as file:
        for row in csv.DictReader(line for line in file if not line.startswith('#')):
            for decade in range(int(row['largest']), int(row['smallest']) - 1, -1):
                cells.append((row['scene'], row['metric'], decade))
    return cells


def best(points, limit):
    """(cpu, run) of the cheapest point with error <= limit; (inf, None) when there is none. Points: (cpu, error, run)."""
    reached = [(cpu, run) for cpu, error, run in points if error <= limit and cpu > 0 and math.isfinite(cpu)]
    return min(reached, key=lambda pair: pair[0], default=(math.inf, None))


def reached_cells(points, cells=None):
    """Cells that anyone reaches. `points`: {(scene, metric): [(cpu, error, is_peer, run)]}."""
    result = []
    for scene, metric, decade in cells if cells is not None else read_cells():
        of_cell = points.get((scene, metric), [])
        limit = 10.0 ** decade * (1 + 1e-12)
        ours = best([(cpu, error, run) for cpu, error, peer, run in of_cell if not peer], limit)
        theirs = best([(cpu, error, run) for cpu, error, peer, run in of_cell if peer], limit)
        if ours[1] is not None or theirs[1] is not None:
            result.append(Cell(scene, metric, decade, ours[0], ours[1], theirs[0], theirs[1]))
    return result


def is_won(cell):
    """Ours reaches it with less CPU time than every peer."""
    return cell.ours < cell.theirs


def front(points):
    """The points (cpu, error, ...) that no other point beats in both: by rising cost."""
    result = []
    for point in sorted((p for p in points if p[0] > 0 and p[1] >= 0), key=lambda p: (p[0], p[1])):
        if not result or point[1] < result[-1][1]:
            result.append(point)
    return result
