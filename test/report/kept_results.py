"""The results that the repository keeps: CSV files and PNG pictures, small enough to be versioned."""
import csv
import glob
import os

from PIL import Image

COLOURS = 64  # of a kept picture: lines and a few hues; a quarter of the bytes of the original
# Columns of the kept runs; the provenance, the same in every row, stands once in provenance.csv.
PROVENANCE = ('machine', 'commit', 'compiler', 'flags', 'load', 'date')


def keep_runs(source, folder, wanted):
    """Rows of report.csv for the metrics that a scene is judged by (`wanted`: {scene: metrics}), and failed runs."""
    with open(source, newline='') as file:
        rows = list(csv.DictReader(file))
    columns = [name for name in rows[0] if name not in PROVENANCE]
    with open(os.path.join(folder, 'runs.csv'), 'w', newline='') as file:
        writer = csv.DictWriter(file, columns, extrasaction='ignore', lineterminator='\n')
        writer.writeheader()
        for row in rows:
            if row['status'] == 'ok' and row['metric'] not in wanted.get(row['scene'], ('position', 'wrench')):
                continue
            writer.writerow({key: _short(value) for key, value in row.items()})
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


def keep_cells(cells, folder):
    with open(os.path.join(folder, 'cells.csv'), 'w', newline='') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(['scene', 'metric', 'error', 'ours_cpu_s_per_s', 'ours', 'ours_step_s', 'peer_cpu_s_per_s', 'peer',
                         'peer_step_s'])
        for cell in cells:
            ours, theirs = (run.case if run else None for run in (cell.our_run, cell.their_run))
            writer.writerow([cell.scene, cell.metric, f'1e{cell.decade}', f'{cell.ours:.4g}', ours.method if ours else '',
                             f'{ours.step:.4g}' if ours else '', f'{cell.theirs:.4g}', theirs.method if theirs else '',
                             f'{theirs.step:.4g}' if theirs else ''])


def keep(output, folder, cells, wanted):
    """Copies what is worth keeping from a report's folder."""
    os.makedirs(folder, exist_ok=True)
    for old in glob.glob(os.path.join(folder, '*.png')):
        os.remove(old)
    keep_runs(os.path.join(output, 'report.csv'), folder, wanted)
    keep_cells(cells, folder)
    for picture in sorted(glob.glob(os.path.join(output, 'plots', '*.png'))):
        name = os.path.basename(picture)
        if name.endswith('-total.png') or name.startswith(('seed-', 'stability-')) or name == 'tilt-numerical.png':
            Image.open(picture).convert('RGB').quantize(COLOURS).save(os.path.join(folder, name), optimize=True)
    stability = os.path.join(output, 'stability.csv')
    if os.path.isfile(stability):
        with open(stability) as source, open(os.path.join(folder, 'stability.csv'), 'w') as target:
            target.write(source.read().replace('\r\n', '\n'))
