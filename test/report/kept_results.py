"""The results that the repository keeps: CSV files and PNG pictures, small enough to be versioned."""
import csv
import glob
import gzip
import io
import os

from PIL import Image

import pareto

COLOURS = 64  # of a kept picture: lines and a few hues; a quarter of the bytes of the original
# Columns of the kept runs; the provenance, the same in every row, stands once in provenance.csv.
PROVENANCE = ('machine', 'commit', 'compiler', 'flags', 'load', 'date')


def keep_runs(source, folder, wanted):
    """Rows of report.csv for the metrics that a scene is judged by (`wanted`: {scene: metrics}), and failed runs."""
    with open(source, newline='') as file:
        rows = list(csv.DictReader(file))
    columns = [name for name in rows[0] if name not in PROVENANCE]
    lines = io.StringIO()
    writer = csv.DictWriter(lines, columns, extrasaction='ignore', lineterminator='\n')
    writer.writeheader()
    for row in rows:
        if row['status'] != 'ok' or row['metric'] in wanted.get(row['scene'], ('position', 'wrench')):
            writer.writerow({key: _short(value) for key, value in row.items()})
    with open(os.path.join(folder, 'runs.csv.gz'), 'wb') as file:  # without name and time: the same rows, the same file
        with gzip.GzipFile('', 'wb', 9, file, mtime=0) as packed:
            packed.write(lines.getvalue().encode())
    with open(os.path.join(folder, 'provenance.csv'), 'w', newline='') as file:
        writer = csv.DictWriter(file, PROVENANCE, extrasaction='ignore', lineterminator='\n')
        writer.writeheader()
        writer.writerow(rows[0])


def _short(value):
    """Four digits of a fraction: more is noise in a time and not read in an error."""
    try:
        return value if float(value) == int(float(value)) else f'{float(value):.4g}'
    except (ValueError, OverflowError):
        return value


def keep_cells(compared, folder):
    """`compared`: {comparison: cells}."""
    with open(os.path.join(folder, 'cells.csv'), 'w', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(['ours_of', 'scene', 'metric', 'error', 'verdict', 'ours_cpu_s_per_s', 'ours', 'ours_step_s', 'ours_k',
                         'peer_cpu_s_per_s', 'peer', 'peer_step_s'])
        for name, cells in compared.items():
            for cell in cells:
                ours, theirs = (run.case if run else None for run in (cell.our_run, cell.their_run))
                writer.writerow([name, cell.scene, cell.metric, f'1e{cell.decade}',
                                 pareto.verdict(cell) + (', rounding' if cell.rounding else ''), f'{cell.ours:.4g}',
                                 ours.method if ours else '', f'{ours.step:.4g}' if ours else '',
                                 f'{ours.stiffness:.4g}' if ours else '', f'{cell.theirs:.4g}', theirs.method if theirs else '',
                                 f'{theirs.step:.4g}' if theirs else ''])


def keep_counts(compared, folder):
    with open(os.path.join(folder, 'counts.csv'), 'w', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        columns = ('cells', 'contested', 'won', 'level', 'lost', 'only ours', 'only theirs', 'rounding')
        writer.writerow(['ours_of', *(name.replace(' ', '_') for name in columns)])
        for name, cells in compared.items():
            counts = pareto.counts(cells)
            writer.writerow([name, *(counts[column] for column in columns)])


def keep(output, folder, compared, wanted):
    """Copies what is worth keeping from a report's folder."""
    os.makedirs(folder, exist_ok=True)
    for old in glob.glob(os.path.join(folder, '*.png')):
        os.remove(old)
    keep_runs(os.path.join(output, 'report.csv'), folder, wanted)
    keep_cells(compared, folder)
    keep_counts(compared, folder)
    for picture in sorted(glob.glob(os.path.join(output, 'plots', '*.png'))):
        name = os.path.basename(picture)
        if name.endswith('-total.png') or name.startswith(('seed-', 'stability-')) or name in ('holders.png', 'tilt-numerical.png'):
            Image.open(picture).convert('RGB').quantize(COLOURS).save(os.path.join(folder, name), optimize=True)
    stability = os.path.join(output, 'stability.csv')
    if os.path.isfile(stability):
        with open(stability) as source, open(os.path.join(folder, 'stability.csv'), 'w') as target:
            target.write(source.read().replace('\r\n', '\n'))
