#!/usr/bin/env python3
"""`./run report`: error against run time of every method and peer on every scene, stability, what scenes leave out.

Plans the runs, executes what is not kept from before on all cores or over a Dask cluster, compares with the references, and
writes one HTML page, a CSV, and the plots. Ends with `figure` lines.
"""
import argparse
import concurrent.futures
import csv
import glob
import os
import signal
import subprocess
import sys
import time

import numpy as np

import figures
import kept_results
import pareto
import plan_section
import programs
import report_page
import seed_section
import stability
from analysis import SceneResult
from programs import ROOT
from report_plan import describe
from task_pool import Kept, run_tasks, stamp_of

# Scene files that a quick report adds to the built-in scenes; a full one takes every file of urdf/scenes.
QUICK_FILES = ('a_cube', 'd_two_hands', 'chain', 'daruma')


def arguments(argv):
    parser = argparse.ArgumentParser(prog='./run report', description=__doc__.split('\n')[0])
    parser.add_argument('scenes', nargs='*', metavar='SCENE', help='names of the catalogue, or URDF or YAML files')
    parser.add_argument('--quick', action='store_true', help='fewer steps and repetitions, under three minutes')
    parser.add_argument('--only', choices=['stability', 'scenes'], help='a part of the report')
    parser.add_argument('--scheduler', metavar='ADDRESS', help='spread the runs over the Dask cluster there')
    parser.add_argument('--programs', default=os.path.join(ROOT, 'build', 'bench-v3'), help='build folder of the programs')
    parser.add_argument('--output', default=os.path.join(ROOT, 'build', 'report'), help='folder of page, CSV and runs')
    parser.add_argument('--keep', metavar='FOLDER', help='copy CSV and pictures there, small enough for a repository')
    parser.add_argument('--flags', default='', help='compiler flags, for the CSV')
    parser.add_argument('--workers', type=int, default=os.cpu_count(), help='processes at a time (all cores)')
    return parser.parse_args(argv)


def program(folder, name):
    return programs.find(folder, name) or sys.exit(f'report: {name} is not built below {folder}; run ./run report, which builds it')


def provenance(flags):
    """Where the numbers come from."""
    model = next((line.split(':', 1)[1].strip() for line in open('/proc/cpuinfo') if line.startswith('model name')), '?')
    commit = subprocess.run(['git', '-c', 'safe.directory=*', '-C', ROOT, 'describe', '--always', '--dirty'],
                            capture_output=True, text=True, check=False).stdout.strip() or 'unknown'
    compiler = subprocess.run(['g++', '--version'], capture_output=True, text=True, check=False).stdout.splitlines()[0]
    return {'machine': f'{model}, {os.cpu_count()} cores, {os.uname().sysname} {os.uname().release}', 'commit': commit,
            'compiler': compiler, 'flags': flags or '-O3 -DNDEBUG -ffp-contract=off',
            'load': f'{os.getloadavg()[1]:.1f}', 'date': time.strftime('%Y-%m-%d %H:%M UTC', time.gmtime())}


def chosen_scenes(options, run_program):
    scenes = describe(run_program, options.scenes)
    if options.scenes:
        return scenes, []
    files = sorted(glob.glob(os.path.join(ROOT, 'urdf', 'scenes', '*.urdf')) +
                   glob.glob(os.path.join(ROOT, 'urdf', 'scenes', '*.yaml')))
    if options.quick:
        files = [file for file in files if os.path.splitext(os.path.basename(file))[0] in QUICK_FILES]
    refused = []
    built_in = {scene.name for scene in scenes}  # files of the same name are the same scenes, without the exact solution
    for file in files:
        try:
            scenes += [scene for scene in describe(run_program, [file]) if scene.name not in built_in]
        except ValueError as error:
            refused.append((os.path.basename(file), str(error)))
    return scenes, refused


def run_scenes(scenes, options, run_program):
    stamp = stamp_of(run_program)
    results = [SceneResult(scene, options.quick) for scene in scenes]
    planned = [(result, case, task) for result in results for case, task in result.tasks(run_program, stamp)]
    kept = Kept(os.path.join(options.output, 'runs'))
    done = run_tasks([task for _, _, task in planned], kept, 'report', options.scheduler, options.workers)
    for result in results:
        result.take({case: done[task.key] for owner, case, task in planned if owner is result})
    return results


def draw(job):
    """The pictures of one scene, in a process of its own: [svg], orders."""
    result, fixed, folder = job
    metrics = result.metrics(fixed)
    pictures = []
    if result.total:
        pictures.append(figures.work_precision(result.scene, result.total, metrics, folder))
    metric = result.main_metric(fixed)
    entries = [(run, errors, doubt.get(metric, np.nan)) for run, errors, doubt in result.numerical]
    svg, orders = figures.numerical(result.scene, entries, metric, folder)
    pictures.append(svg)
    runs, references = result.grown()
    pictures.append(figures.growth(result.scene, runs, references, metrics, folder))
    return pictures, orders, metric


def write_csv(path, results, where):
    with open(path, 'w', newline='') as file:
        writer = None
        for result in results:
            for row in result.rows():
                row = {**row, **where}
                if writer is None:
                    writer = csv.DictWriter(file, list(row))
                    writer.writeheader()
                writer.writerow({key: f'{value:.6g}' if isinstance(value, float) else value for key, value in row.items()})


def main(argv):
    signal.signal(signal.SIGTERM, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()))
    start = time.time()
    options = arguments(argv)
    os.makedirs(options.output, exist_ok=True)
    where = provenance(options.flags)
    results, refused, cells, fixed = [], [], [], {}
    pictures = os.path.join(options.output, 'plots')
    if options.only != 'stability':
        run_program = program(options.programs, 'report_run')
        try:
            scenes, refused = chosen_scenes(options, run_program)
        except ValueError as error:
            sys.exit(f'report: {error}')
        results = run_scenes(scenes, options, run_program)
        points = {}
        for result in results:
            points.update(result.points())
        cells = pareto.reached_cells(points)
        for scene, metric, _ in pareto.read_cells():
            fixed.setdefault(scene, []).append(metric)
        with concurrent.futures.ProcessPoolExecutor(options.workers) as pool:
            drawn = pool.map(draw, [(result, fixed.get(result.scene.name, ()), pictures) for result in results])
            for result, (svgs, orders, metric) in zip(results, drawn):
                result.pictures, result.orders, result.order_metric = svgs, orders, metric
        write_csv(os.path.join(options.output, 'report.csv'), results, where)
    sections = []
    if not options.scenes and options.only != 'scenes':
        # Maps, certificates and plans take longer than a quick report may; `--only stability --quick` makes coarse maps.
        whole = options.only == 'stability' or not options.quick
        sections += stability.sections(options, pictures, whole)
        if options.only is None:
            sections += (plan_section.sections(options) if whole else []) + seed_section.sections(options, pictures)
    name = 'stability.html' if options.only == 'stability' else 'report.html'
    page = os.path.join(options.output, name)
    seconds = time.time() - start
    failed_shown = report_page.write(page, results, refused, cells, sections, where, options)
    if options.keep and results:
        kept_results.keep(options.output, options.keep, cells, fixed)
    print(f'report: {page}')
    if results:
        print(f'figure report.scenes {len(results)} scenes')
        print(f'figure report.runs {sum(len(result.runs) for result in results)} runs')
        print(f'figure report.failed_runs_shown {failed_shown} runs')
        print(f'figure report.failed_runs {sum(len(result.failed()) for result in results)} runs')
        print(f'figure report.pareto_cells {len(cells)} cells')
        print(f'figure report.pareto_wins {sum(pareto.is_won(cell) for cell in cells)} cells')
    print(f'figure report.html_kb {os.path.getsize(page) / 1024:.0f} kB')
    print(f'figure report.seconds {seconds:.1f} s')
    return 0


if __name__ == '__main__':
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit('report: interrupted; what is finished is kept, and the same command goes on from there')
