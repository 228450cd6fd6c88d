#!/usr/bin/env python3
"""`./run report`: error against run time of every method and peer on every scene, stability, what scenes leave out.

Plans the runs, executes those that are not kept from before on all cores or over a Dask cluster, compares with the references, and
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

import advice
import engine_results
import figures
import haptic_section
import kept_results
import pareto
import plan_section
import programs
import report_page
import seed_section
import stability
from analysis import SceneResult
import npm_modules  # found by programs
import own_page
from programs import ROOT
from report_plan import QUICK_MOST_BODIES, QUICK_PEERS, default_method, describe, describe_peers, is_wasm, parts_of
from task_pool import Kept, run_tasks, stamp_of

# Scene files that a quick report adds to the built-in scenes; a full one takes every file of urdf/scenes.
QUICK_FILES = ('a_cube', 'd_two_hands', 'chain', 'daruma')


def arguments(argv):
    parser = argparse.ArgumentParser(prog='./run report', description=__doc__.split('\n')[0])
    parser.add_argument('scenes', nargs='*', metavar='SCENE', help='names of the catalogue, or URDF or YAML files')
    parser.add_argument('--quick', action='store_true', help='fewer steps and settings, about six minutes')
    parser.add_argument('--only', choices=['stability', 'scenes'], help='a part of the report')
    parser.add_argument('--results', metavar='FILE', action='append', default=[],
                        help='runs of another engine, a JSON line each (test/report/README.md); again for further files')
    parser.add_argument('--scheduler', metavar='ADDRESS', help='spread the runs over the Dask cluster there')
    parser.add_argument('--programs', default=os.path.join(ROOT, 'build', 'bench'), help='build folder of the programs')
    parser.add_argument('--output', default=os.path.join(ROOT, 'build', 'report'), help='folder of page, CSV and runs')
    parser.add_argument('--keep', metavar='FOLDER', help='copy CSV and pictures there, small enough for a repository')
    parser.add_argument('--flags', default='', help='compiler flags, for the CSV')
    parser.add_argument('--workers', type=int, default=os.cpu_count(), help='processes at a time (all cores)')
    return parser.parse_args(argv)


def program(folder, name):
    return programs.find(folder, name) or sys.exit(f'report: {name} is not built below {folder}; run ./run report, which builds it')


def provenance(flags):
    """Where the numbers come from."""
    commit = subprocess.run(['git', '-c', 'safe.directory=*', '-C', ROOT, 'describe', '--always', '--dirty'],
                            capture_output=True, text=True, check=False).stdout.strip() or 'unknown'
    compiler = subprocess.run(['g++', '--version'], capture_output=True, text=True, check=False).stdout.splitlines()[0]
    return {'machine': programs.machine(), 'commit': commit,
            'compiler': compiler, 'flags': flags or '-O3 -DNDEBUG -ffp-contract=off',
            'load': f'{os.getloadavg()[1]:.1f}', 'date': time.strftime('%Y-%m-%d %H:%M UTC', time.gmtime())}


def with_wasm(peers):
    """The peers without those in WebAssembly, where their packages cannot be had; else their folder is told to the runs."""
    wanted = [peer for peer in peers if is_wasm(peer['name'])]
    if wanted and 'HAPTIC_WASM_PEERS' not in os.environ:
        try:
            os.environ['HAPTIC_WASM_PEERS'] = npm_modules.modules(programs.WASM_PEERS)
        except npm_modules.Unavailable as reason:
            print(f'report: without the engines in WebAssembly: {reason}')
            return [peer for peer in peers if peer not in wanted]
    return peers


def chosen_scenes(options, run_program):
    scenes = describe(run_program, options.scenes)
    if options.scenes:
        return scenes, []
    files = sorted(glob.glob(os.path.join(ROOT, 'urdf', 'scenes', '*.urdf')) +
                   glob.glob(os.path.join(ROOT, 'urdf', 'scenes', '*.yaml')))
    if options.quick:
        scenes = [scene for scene in scenes if scene.bodies <= QUICK_MOST_BODIES]
        files = [file for file in files if os.path.splitext(os.path.basename(file))[0] in QUICK_FILES]
    refused = []
    built_in = {scene.name for scene in scenes}  # files of the same name are the same scenes, without the exact solution
    for file in files:
        try:
            scenes += [scene for scene in describe(run_program, [file]) if scene.name not in built_in]
        except ValueError as error:
            refused.append((os.path.basename(file), str(error)))
    return scenes, refused


def run_scenes(scenes, peers, options, run_program, outside):
    by_name = {scene.name: scene for scene in scenes}
    for each in outside:
        if each.scene in by_name:
            engine_results.check_samples(each, by_name[each.scene])
        else:
            print(f'report: {each.where}: scene {each.scene} is no part of this report')
    stamp = stamp_of(run_program)
    results = [SceneResult(scene, options.quick, peers) for scene in scenes]
    kept = Kept(os.path.join(options.output, 'runs'))
    told = [{} for _ in results]  # of each scene {case: its part of a process's result}
    while planned := [(parts, row, task) for parts, result in zip(told, results) for row, task in result.tasks(run_program, stamp, parts)]:
        done = run_tasks([task for _, _, task in planned], kept, 'report', options.scheduler, options.workers)
        for parts, row, task in planned:
            parts.update(parts_of(row, done[task.key], options.quick))
    for parts, result in zip(told, results):
        result.take(parts)
        result.add([each.run for each in outside if each.scene == result.scene.name])
        result.find_not_converging(peers + [peer['name'] for peer in engine_results.peers_of(outside)])
    return results


def compare(results, default):
    """{comparison: cells}; empty without cells."""
    points = {}
    for result in results:
        points.update(result.points())
    compared = {name: pareto.reached_cells(points, takes) for name, (takes, _) in pareto.comparisons(default).items()}
    return compared if any(compared.values()) else {}


def draw(job):
    """The pictures of one scene, in a process of its own: [svg], orders."""
    result, fixed, folder, cells = job
    metric = advice.metric_of(result, fixed)
    entries, kind = advice.errors_of(result), 'total' if result.total else 'numerical'
    links = {id(run): f'#run={result.scene.name}:{index}' for index, run in enumerate(result.runs)}
    close = {run.case for cell in cells if cell.scene == result.scene.name and cell.metric == metric and pareto.decides_closely(cell)
             for run in (cell.our_run, cell.their_run)}
    drawn = (result.scene, entries, metric, folder, result.is_default, links, close)
    pictures = [figures.work_precision(*drawn, kind=kind), figures.work_precision(*drawn, figures.worst_step_of, 'worst', kind)]
    metric, orders = result.main_metric(fixed), {}
    if result.numerical:
        entries = [(run, errors, doubt.get(metric, np.nan)) for run, errors, doubt in result.numerical]
        svg, orders = figures.numerical(result.scene, entries, metric, folder)
        pictures.append(svg)
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
    results, refused, compared, peers, fixed, default = [], [], {}, [], {}, ''
    pictures = os.path.join(options.output, 'plots')
    if options.only != 'stability':
        run_program = program(options.programs, 'report_run')
        try:
            scenes, refused = chosen_scenes(options, run_program)
            peers, default = describe_peers(run_program), default_method(run_program)
            # Files of engines are read before anything runs.
            outside = engine_results.read([os.path.abspath(path) for path in options.results], {peer['name'] for peer in peers})
        except ValueError as error:
            sys.exit(f'report: {error}')
        if options.quick:
            peers = [peer for peer in peers if peer['name'] in QUICK_PEERS]
        peers = with_wasm(peers)
        try:
            results = run_scenes(scenes, [peer['name'] for peer in peers], options, run_program, outside)
        except ValueError as error:
            sys.exit(f'report: {error}')
        peers += engine_results.peers_of(outside)
        compared = compare(results, default)
        for scene, metric, _, _ in pareto.read_cells():
            fixed.setdefault(scene, []).append(metric)
        with concurrent.futures.ProcessPoolExecutor(options.workers) as pool:
            drawn = pool.map(draw, [(result, fixed.get(result.scene.name, ()), pictures, compared.get('chosen', ())) for result in results])
            for result, (svgs, orders, metric) in zip(results, drawn):
                result.pictures, result.orders, result.order_metric = svgs, orders, metric
        write_csv(os.path.join(options.output, 'report.csv'), results, where)
    sections = []
    if not options.scenes and options.only != 'scenes':
        # Maps, certificates and plans take longer than a quick report may; `--only stability --quick` makes coarse maps.
        whole = options.only == 'stability' or not options.quick
        sections += stability.sections(options, pictures, whole)
        if options.only is None:
            sections += (plan_section.sections(options) + haptic_section.sections(options) if whole else []) + seed_section.sections(options, pictures)
    own = {}
    if options.scenes:
        for result in results:
            body, own[result.scene.name] = own_page.section_of(result, run_program, pictures)
            sections.insert(0, (f'{result.scene.name}: error, stability, what is left out', 'own-' + result.scene.name, body))
    name = 'stability.html' if options.only == 'stability' else 'report.html'
    page = os.path.join(options.output, name)
    failed_shown = report_page.write(page, results, refused, compared, sections, where, options, peers, default, fixed)
    if options.keep and results:
        kept_results.keep(options.output, options.keep, compared, fixed)
    print(f'report: {page}')
    if options.scenes:
        print_own(results, own)
    if results:
        print_figures(results, compared, peers, failed_shown, default)
    print(f'figure report.html_kb {os.path.getsize(page) / 1024:.0f} kB')
    print(f'figure report.seconds {time.time() - start:.1f} s')
    return 0


def print_own(results, own):
    print(f"figure own_report.scenes_with_peers {sum(each['peers'] for each in own.values())} of_{len(own)}")
    for each in own.values():
        print(f"figure own_report.saved_pct {each['saved_pct']:.1f} %")
        print(f"figure own_report.force_err_shown {int(each['force_shown'])} 1")
    for result in results:
        print(f"{result.scene.name}: {own[result.scene.name]['last']}")


def print_figures(results, compared, peers, failed_shown, default):
    def figure(name, value, unit):
        print(f'figure report.{name} {value} {unit}')
    figure('scenes', len(results), 'scenes')
    figure('public_benchmarks', sum(bool(result.scene.benchmark) for result in results), 'scenes')
    figure('runs', sum(len(result.runs) for result in results), 'runs')
    figure('failed_runs_shown', failed_shown, 'runs')
    figure('failed_runs', sum(len(result.failed()) for result in results), 'runs')
    figure('ok_runs_beyond_bound', sum(result.beyond_bound() for result in results), 'runs')
    figure('peer_settings', len(peers), 'settings')
    figure('peers_not_converging', sum(len(result.not_converging) for result in results), 'rows')
    ours = [run for result in results for run in result.runs
            if run.case.method == default and not run.case.facets and result.own_stiffness(run.case) and run.p50 > 0]
    figure('default_unconverged', sum(run.unconverged > 0 for run in ours), 'runs')
    # A step of a free body takes less than the interrupts of the system: p99.9 stands beside the worst.
    figure('default_worst_over_median_max', f'{max((run.slowest / run.p50 for run in ours), default=0):.1f}', '1')
    figure('default_p999_over_median_max', f'{max((run.p999 / run.p50 for run in ours), default=0):.1f}', '1')
    # The same over the median step that computed a contact: what stands or flies costs next to nothing, and makes any worst step look bad.
    touching = [run for run in ours if run.touching > 0]
    figure('default_worst_over_touching_median_max', f'{max((run.slowest / run.touching for run in touching), default=0):.1f}', '1')
    figure('default_p999_over_touching_median_max', f'{max((run.p999 / run.touching for run in touching), default=0):.1f}', '1')
    for name, cells in compared.items():
        c = pareto.counts(cells)
        figure(f'cells_{name}_won', c['won'], 'cells')
        figure(f'cells_{name}_lost', c['lost'], 'cells')
        figure(f'cells_{name}_contested', c['contested'], 'cells')
        figure(f'cells_{name}_only_ours', c['only ours'], 'cells')
        figure(f'cells_{name}_only_theirs', c['only theirs'], 'cells')
    if compared:
        chosen = pareto.counts(compared['chosen'])
        figure('default_share', f'{chosen["won"] / max(1, chosen["contested"]):.3f}', '1')
        figure('only_theirs', chosen['only theirs'], 'cells')
        ratio, cell = pareto.lost_ratio(compared['chosen'])
        figure('lost_ratio_max', f'{ratio:.1f}', '1')
        wasm = {}
        for result in results:
            wasm.update(result.points(wasm=True))
        if wasm:
            figure('only_wasm', len(pareto.only_wasm(wasm, compared['all'])), 'cells')
        if cell:
            print(f'report: the cell lost by most: {cell.scene}, {cell.metric}, 1e{cell.decade}, to {cell.their_run.case.method}')
        figure('cells_contested', pareto.counts(compared['all'])['contested'], 'cells')
        figure('cells_rounding', pareto.counts(compared['all'])['rounding'], 'cells')


if __name__ == '__main__':
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit('report: interrupted; what is finished is kept, and the same command goes on from there')
