"""Sections of the page: summary, Pareto cells, one section per scene."""
import math

import pareto
from analysis import model_error
from page import Cell, details, document, number, section, table, text
from run_errors import METRICS


def _step(case):
    return Cell(f'{1e3 * case.step:.4g}', case.step)


def _run_rows(result, metrics):
    total = {id(entry[0]): entry[1] for entry in result.total}
    numerical = {id(entry[0]): entry[1] for entry in result.numerical}
    rows, kinds = [], []
    for run in result.runs:
        case = run.case
        row = [case.method, _step(case), case.stiffness or math.nan, Cell(str(case.facets or '–'), case.facets),
               run.status if run.status == 'ok' else f'{run.status}: {run.reason}', run.cpu,
               Cell(f'{number(1e6 * run.p50)} / {number(1e6 * run.p99)} / {number(1e6 * run.slowest)}', run.p50)]
        for metric in metrics:
            if result.exact is not None:
                row.append(total.get(id(run), {}).get(metric, math.nan))
            row.append(numerical.get(id(run), {}).get(metric, math.nan))
        row += [Cell(str(run.allocations), run.allocations), Cell(str(run.unconverged), run.unconverged), run.balance]
        rows.append(row)
        kinds.append('' if run.status == 'ok' else 'failed')
    heads = ['method', 'step [ms]', 'k [N/m³]', 'facets', 'status', 'CPU s per s', 'step p50 / p99 / max [µs]']
    for metric in metrics:
        name = metric.replace('_', ' ')
        if result.exact is not None:
            heads.append(f'{name}, total [{METRICS[metric][0]}]')
        heads.append(f'{name}, numerical [{METRICS[metric][0]}]')
    heads += ['allocations', 'unconverged steps', 'ledger off by']
    return heads, rows, kinds


def _order_table(result):
    rows = [[method, stiffness or math.nan, order if count >= 3 else math.nan, Cell(str(count), count)]
            for (method, stiffness), (order, count) in sorted(result.orders.items())]
    return table(['method', 'k [N/m³]', 'observed order', 'points'], rows) if rows else ''


def _reference_table(result, metrics):
    rows = []
    for model, case, failure, doubt in result.reference_notes:
        label = model if isinstance(model, str) else f'{model[0]}, k {model[1]:.0e}' if model[1] else f'{model[0]}, k of the file'
        if not isinstance(model, str) and model[2]:
            label += f', facets {model[2]}'
        rows.append([label, f'{case.method} at {1e3 * case.step:.4g} ms' + (f' ({failure})' if failure else '')] +
                    [doubt.get(metric, math.nan) for metric in metrics])
    heads = ['model', 'converged by'] + [f'{m.replace("_", " ")} changes on halving [{METRICS[m][0]}]' for m in metrics]
    return table(heads, rows) if rows else ''


def _verdict(result):
    """What a reader must know before the plots."""
    failed, runs = len(result.failed()), len(result.runs)
    if failed == runs:
        return '<p><b>Every method failed on this scene.</b> The table says how each of them did.</p>'
    lines = [f'{runs} runs, {failed} failed']
    if not result.scene.exact:
        lines.append('no exact solution: errors are against the same model at a tiny step')
        doubt = [d.get('position', math.nan) for _, _, _, d in result.reference_notes]
        worst = max((d for d in doubt if math.isfinite(d)), default=math.nan)
        if not math.isfinite(worst):
            lines.append('no reference could be computed')
        elif worst > 1e-4:
            lines.append(f'the references themselves move by up to {worst:.1e} m when their step is halved: the motion is '
                         'chaotic or has not converged, and errors below that say nothing')
    if result.scene.not_for_peers:
        lines.append('no peer: ' + result.scene.not_for_peers)
    return '<p>' + '. '.join(text(line) for line in lines) + '.</p>'


def scene_section(result, fixed):
    scene, metrics = result.scene, result.metrics(fixed)
    body = f'<p>{text(scene.parameters)}; {scene.seconds:g} s. Reference: {text(scene.reference or "the same model, converged")}.</p>'
    body += _verdict(result)
    captions = (['Total error against CPU time. Line: Pareto front. Hollow: another stiffness than the scene\'s. '
                 'Crosses: failed runs.'] if result.total else []) + \
        ['Numerical error: against the same model\'s converged solution. Hollow: another stiffness.',
         'Error over simulated time at about 1 ms' + ('' if result.exact is not None else ', each against its own model') + '.']
    for picture, caption in zip(result.pictures, captions):
        body += picture.replace('</figure>', f'<figcaption>{text(caption)}</figcaption></figure>')
    main = result.order_metric
    tables = f'<h4>Observed order of the {main.replace("_", " ")} error</h4>' + _order_table(result)
    tables += '<h4>Convergence of the references</h4>' + _reference_table(result, metrics)
    if result.exact is not None:
        errors = model_error(result, main)
        if errors:
            tables += f'<h4>Model error: converged against exact, {main.replace("_", " ")}</h4>' + \
                table(['k [N/m³]', f'[{METRICS[main][0]}]'], [list(pair) for pair in errors])
    body += details('Orders, references, model errors', tables)
    body += details(f'All {len(result.runs)} runs', table(*_run_rows(result, metrics)))
    return section(scene.title, 'scene-' + scene.name, body, 3)


def pareto_section(cells):
    won = sum(pareto.is_won(cell) for cell in cells)
    body = (f'<p>Cells of the fixed list (test/report/pareto_cells.csv) that anyone reaches: {len(cells)}; ours reaches '
            f'{won} of them with the least CPU time. Errors are total: against the exact rigid solution.</p>')
    rows, kinds = [], []
    for cell in cells:
        ours, theirs = (run.case if run else None for run in (cell.our_run, cell.their_run))

        def label(case):
            return f'{case.method} {1e3 * case.step:.3g} ms' if case else 'not reached'
        good = pareto.is_won(cell)
        ratio = cell.theirs / cell.ours if math.isfinite(cell.ours) else 0.0
        rows.append([cell.scene, cell.metric, Cell(f'1e{cell.decade}', 10.0 ** cell.decade), label(ours),
                     cell.ours if ours else math.nan, label(theirs), cell.theirs if theirs else math.nan,
                     Cell('won' if good else 'lost', int(good), 'won' if good else 'lost'),
                     Cell('only ours' if not theirs else f'{ratio:.3g}', ratio)])
        kinds.append('')
    body += details('All cells', table(['scene', 'metric', 'error', 'best of ours', 'CPU s per s', 'best peer', 'CPU s per s',
                                        'cell', 'peer / ours'], rows, kinds))
    lost = [row for row, cell in zip(rows, cells) if not pareto.is_won(cell)]
    if lost:
        body += '<h4>Cells that a peer wins</h4>' + table(['scene', 'metric', 'error', 'best of ours', 'CPU s per s',
                                                           'best peer', 'CPU s per s', 'cell', 'peer / ours'], lost)
    return section('Pareto cells', 'pareto', body)


def _scene_overview(results):
    rows = []
    for result in results:
        cheapest = min((run.cpu for run in result.runs if run.status == 'ok'), default=math.nan)
        rows.append([result.scene.name, result.scene.title, 'exact' if result.scene.exact else 'converged',
                     Cell(str(len(result.runs)), len(result.runs)),
                     Cell(str(len(result.failed())), len(result.failed())), cheapest])
    return table(['scene', '', 'reference', 'runs', 'failed', 'cheapest [CPU s per s]'], rows)


def write(path, results, refused, cells, sections, where, options):
    """Writes the page; returns how many failed runs stand in its tables."""
    import pareto as lists
    fixed = {}
    for scene, metric, _ in lists.read_cells():
        fixed.setdefault(scene, []).append(metric)
    contents, body = [], ''
    if results:
        overview = _scene_overview(results)
        if refused:
            overview += '<h4>Files that could not be loaded</h4>' + table(['file', 'reason'], [list(pair) for pair in refused])
        absent = sorted({(run.case.method, run.reason) for result in results for run in result.runs
                         if run.status == 'refused' and 'not installed' in run.reason})
        for method, reason in absent:
            overview += f'<p class=note>Skipped: {text(method)}: {text(reason)}</p>'
        body += section('Scenes', 'scenes', overview)
        contents.append(('scenes', 'Scenes'))
        if cells:
            body += pareto_section(cells)
            contents.append(('pareto', 'Pareto cells'))
    for title, anchor, content in sections:
        body += section(title, anchor, content)
        contents.append((anchor, title))
    if results:
        body += section('Error against run time', 'work', ''.join(
            scene_section(result, fixed.get(result.scene.name, ())) for result in results))
        contents += [('scene-' + result.scene.name, result.scene.title) for result in results]
    runs = sum(len(result.runs) for result in results)
    won = sum(lists.is_won(cell) for cell in cells)
    cards = [(len(results), 'scenes'), (runs, 'runs'), (sum(len(result.failed()) for result in results), 'failed runs, shown'),
             (f'{won} of {len(cells)}', 'Pareto cells won')] if results else []
    kind = 'quick, ' if options.quick else ''
    lead = (f'<p class=note>{kind}{text(where["date"])}; {text(where["machine"])}, load average {text(where["load"])}; commit '
            f'{text(where["commit"])}; {text(where["compiler"])}; {text(where["flags"])}. Run time is CPU time of the stepping '
            'thread per simulated second, median of repetitions; the bar spans the repetitions. Step times are wall times and '
            'feel other load on the machine.</p>')
    whole = document('Error against run time, and where it is stable', lead, cards, contents, body)
    with open(path, 'w') as file:
        file.write(whole)
    if results:
        return whole.count('<tr class="failed">')
    return 0


