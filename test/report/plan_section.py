"""What each scene's plan leaves out, and what that saves: `bench_plan`, scene by scene."""
import csv
import io
import os

import programs
from page import Cell, table
from task_pool import Kept, Task, key_of, run_tasks, stamp_of

CPU_LIMIT = 600  # [s]: all scenes of the catalogue in one process


def sections(options):
    """[(title, anchor, html)]; empty when bench_plan is not built."""
    program = programs.find(options.programs, 'bench_plan')
    if not program:
        return []
    task = Task(key_of(stamp_of(program), 'plan'), (program, '--csv'), CPU_LIMIT, 1.0)
    result = run_tasks([task], Kept(os.path.join(options.output, 'runs')), 'plans', None, 1)[task.key]
    if result['failure']:
        return [('What scenes leave out', 'plan', f'<p>bench_plan: {result["failure"]}</p>')]
    lines = [line for line in result['output'].splitlines() if not line.startswith('skipped')]
    rows = []
    for row in csv.DictReader(io.StringIO('\n'.join(lines))):
        planned, general = float(row['planned_instructions']), float(row['general_instructions'])
        same = row['bit_identical'] == '1'
        rows.append([row['scene'], Cell('yes' if same else 'NO', int(same), 'won' if same else 'lost'), general, planned,
                     100 * (1 - planned / general), float(row['step_us']), float(row['speedup']), row['left_out']])
    heads = ['scene', 'same bits', 'instructions, general', 'planned', 'saved [%]', 'step [µs]', 'speed-up', 'left out, and why']
    return [('What scenes leave out', 'plan', '<p>Each scene as its plan runs it, and as the general pipeline does, which visits '
             'everything in every step. Instructions of one step are counted one by one; the speed-up is the median of paired '
             'runs.</p>' + table(heads, rows))]
