"""Our hand beside the god object: `bench_peers haptic`, as a table of its figures and one of what it prints beside them."""
import os

import programs
from page import Cell, details, table, text
from task_pool import Kept, Task, key_of, run_tasks, stamp_of

CPU_LIMIT = 600  # [s]: it counts instructions too
MEANINGS = {'god': 'god object, a ball of 5 mm', 'god_point': 'god object, a point', 'ours': 'ours, virtual coupling',
            'ours_direct': 'ours, direct coupling, bounded', 'haptic': 'all'}


def rows_of(output):
    """(renderer, trial or '', quantity, value, unit) of each `figure RENDERER.[TRIAL.]QUANTITY VALUE UNIT`."""
    rows = []
    for line in output.splitlines():
        if line.startswith('figure '):
            name, value, unit = line.split()[1:4]
            renderer, *trial, quantity = name.split('.')
            rows.append((renderer, '.'.join(trial), quantity, float(value), unit))
    return rows


def sections(options):
    """[(title, anchor, html)]; empty when bench_peers is not built."""
    program = programs.find(options.programs, 'bench_peers')
    if not program:
        return []
    task = Task(key_of(stamp_of(program), 'haptic'), (program, 'haptic'), CPU_LIMIT, 1.0)
    result = run_tasks([task], Kept(os.path.join(options.output, 'runs')), 'haptic', None, 1)[task.key]
    title, anchor = 'A haptic peer: the god object', 'haptic'
    if result['failure']:
        return [(title, anchor, f'<p>bench_peers: {text(result["failure"])}</p>')]
    rows = [[MEANINGS.get(renderer, renderer), trial or 'all', quantity.replace('_', ' '), Cell(f'{value:.4g}', value), unit]
            for renderer, trial, quantity, value, unit in rows_of(result['output'])]
    notes = [[line.removeprefix('peers haptic ')] for line in result['output'].splitlines() if line.startswith('peers haptic ')]
    body = ('<p>A point or a ball on a spring of 1 kN/m that surfaces stop (Zilles and Salisbury, Ruspini, CHAI3D\'s three constraints, a '
            'cone of friction), and our hand on the same meshes with the same spring. The god object has no mass, torque or volume, '
            'which makes it exact and cheap; ours is a body in a world. Its direct coupling is a wall of bounded stiffness, which is '
            'another law than the rigid one that forces are held against.</p>')
    return [(title, anchor, body + table(['renderer', 'trial', 'quantity', 'value', 'unit'], rows) +
             details(f'{len(notes)} single results', table(['renderer, trial, result'], notes)))]
