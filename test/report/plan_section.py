"""What each scene's plan leaves out, and what that saves: `bench_plan`, scene by scene."""
import csv
import io
import os

import programs
from page import Cell, table
from task_pool import Kept, Task, file_stamp, key_of, run_tasks, stamp_of

CPU_LIMIT = 120  # [s] of a scene


def sections(options):
    """[(title, anchor, html)]; empty when bench_plan is not built."""
    program = programs.find(options.programs, 'bench_plan')
    if not program:
        return []
    files = sorted(name for name in os.listdir(os.path.join(programs.ROOT, 'urdf', 'scenes')) if name.endswith(('.urdf', '.yaml')))
    stamp = stamp_of(program)
    tasks = [Task(key_of(stamp, 'plan', file, file_stamp(os.path.join(programs.ROOT, 'urdf', 'scenes', file))), (program, '--csv', file),
                  CPU_LIMIT, 1.0) for file in files]
    done = run_tasks(tasks, Kept(os.path.join(options.output, 'runs')), 'plans', None, options.workers)
    failed = [f'{file}: {done[task.key]["failure"]}' for file, task in zip(files, tasks) if done[task.key]['failure']]
    rows = []
    for task in tasks:
        lines = [line for line in done[task.key]['output'].splitlines() if not line.startswith('skipped')]
        for row in csv.DictReader(io.StringIO('\n'.join(lines))):
            planned, general = float(row['planned_instructions']), float(row['general_instructions'])
            same = row['bit_identical'] == '1'
            rows.append([row['scene'], Cell('yes' if same else 'NO', int(same), 'won' if same else 'lost'), general, planned,
                         100 * (1 - planned / general), float(row['step_us']), float(row['speedup']), row['left_out']])
    heads = ['scene', 'same bits', 'instructions, general', 'planned', 'saved [%]', 'step [µs]', 'speed-up', 'left out, and why']
    return [('What scenes leave out', 'plan', '<p>Each scene as its plan runs it, and as the general pipeline does, which visits '
             'everything in every step. Instructions of one step are counted one by one; the speed-up is the median of paired '
             'runs.</p>' + ''.join(f'<p>{line}</p>' for line in failed) + table(heads, rows))]
