"""Sections of the page: the answer, the counts of cells, failures, settings, and one section per scene."""
import collections
import math
import os
import re

import advice
import figures
import pareto
import programs
from analysis import model_error
from page import Cell, details, document, later_table, number, section, shown_failures, table, text
from report_plan import chosen_stiffness, is_peer
from run_errors import LEDGER_BOUND, METRICS

VERDICTS = ('won', 'level', 'lost', 'only ours', 'only theirs')


def _runs_table(result, metrics):
    """Every run of a scene, failed ones with their reason."""
    total = {id(entry[0]): entry[1] for entry in result.total}
    numerical = {id(entry[0]): entry[1] for entry in result.numerical}
    heads = ['method', 'step [ms]', 'k [N/m³]', 'facets', 'accuracy', 'status', 'CPU s per s', 'least', 'most', 'step p50 [µs]', 'p99', 'p99.9',
             'worst', 'Newton, mean', 'worst', 'evaluations, worst']
    for kind, present in (('total', bool(result.total)), ('numerical', bool(result.numerical))):
        heads += [f'{metric.replace("_", " ")}, {kind} [{METRICS[metric][0]}]' for metric in metrics if present]
    heads += ['allocations', 'unconverged steps', 'ledger gained', 'report_run …']
    rows, failed = [], []
    for run in result.runs:
        case = run.case
        row = [case.method, 1e3 * case.step, case.stiffness or math.nan, case.facets or math.nan, case.accuracy or math.nan,
               run.status if run.status == 'ok' else f'{run.status}: {run.reason}', run.cpu, run.cpu_low, run.cpu_high,
               *(1e6 * t for t in (run.p50, run.p99, run.p999, run.slowest)), run.iterations / max(1, run.steps),
               run.iterations_worst, run.evaluations_worst]
        for errors, present in ((total, bool(result.total)), (numerical, bool(result.numerical))):
            row += [errors.get(id(run), {}).get(metric, math.nan) for metric in metrics if present]
        row += [run.allocations, run.unconverged, run.gain, words_of(case)]
        if run.status != 'ok':
            failed.append(len(rows))
        rows.append(row)
    return later_table(heads, rows, failed)


def words_of(case):
    """What report_run takes to run a case again."""
    words = [case.scene if '/' not in case.scene else os.path.relpath(case.scene, programs.ROOT), case.method, repr(case.step)]
    if case.stiffness or case.facets:
        words.append('rigid' if case.stiffness == math.inf else f'{case.stiffness:g}')
    return ' '.join(words + ([str(case.facets)] if case.facets else []) + ([f'--accuracy {case.accuracy:g}'] if case.accuracy else []))


def stiffness_words(result):
    return 'rigid' if chosen_stiffness(result.scene) == math.inf else 'with the stiffness that the scene says'


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
    if result.scene.chaotic:
        lines.append('no motion is the right one: judged by ' + ', '.join(METRICS[m][1] for m in result.scene.measures))
    elif not result.scene.exact:
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
    if result.not_converging:
        lines.append('does not converge to the reference: ' + ', '.join(result.not_converging))
    return '<p>' + '. '.join(text(line) for line in lines) + '.</p>'


def _advice_table(result, metric):
    rows = []
    for choice in advice.choices(result, metric):
        row = [Cell(f'1e{choice.decade} {METRICS[metric][0]}', 10.0 ** choice.decade)]
        for run in (choice.ours, choice.theirs):
            row += [advice.named(run) if run else 'none', 100 * run.cpu if run else math.nan,
                    1e6 * run.slowest if run else math.nan]
        rows.append(row)
    return table(['error', 'ours', 'of a core [%]', 'worst step [µs]', 'cheapest peer', 'of a core [%]', 'worst step [µs]'], rows)


def _cell_table(cells):
    rows = []
    for cell in cells:
        ours, theirs = (advice.named(run) if run else 'not reached' for run in (cell.our_run, cell.their_run))
        rows.append([cell.metric, 10.0 ** cell.decade, ours, cell.ours if cell.our_run else math.nan, theirs,
                     cell.theirs if cell.their_run else math.nan, pareto.verdict(cell) + (' (rounding)' if cell.rounding else ''),
                     cell.theirs / cell.ours if cell.our_run and cell.their_run else math.nan])
    return later_table(['metric', 'error', 'best of ours', 'CPU s per s', 'best peer', 'CPU s per s', 'cell', 'peer / ours'], rows, [])


def scene_section(result, fixed, cells):
    scene, metrics = result.scene, result.metrics(fixed)
    metric = advice.metric_of(result, fixed)
    reference = scene.reference or ('conserved quantities and what may not overlap' if scene.chaotic else 'the same model, converged')
    body = f'<p>{text(scene.parameters)}; {scene.seconds:g} s. Reference: {text(reference)}. A run fails beyond {scene.size:g} m.</p>'
    if scene.benchmark:
        body += f'<p class=note>{text(scene.benchmark)}</p>'
    body += f'<p><b>Advice:</b> {text(advice.sentence(result, metric))}</p>' + _verdict(result)
    kind = 'Total' if result.total else 'Numerical'
    captions = [f'{kind} error against CPU time. Green: our default, {stiffness_words(result)}, at its steps, and as a line over accuracy at '
                '1 ms; dotted: its front, dashed: that of the peers. Grey: our other methods and stiffnesses. Crosses above: failed runs. A '
                'mark leads to its run in the table, and to its command.', 'The same errors against the worst step.']
    if len(result.pictures) > 2:
        captions.append('Numerical error: against the same model\'s converged solution. Hollow: another stiffness.')
    pictures = [picture.replace('</figure>', f'<figcaption>{text(caption)}</figcaption></figure>')
                for picture, caption in zip(result.pictures, captions)]
    body += ''.join(pictures[:1])
    body += details('For errors of 1e-2 to 1e-6: what a hand at 1 kHz can hold', _advice_table(result, metric))
    body += details('Against the worst step', ''.join(pictures[1:2]))
    own = [cell for cell in cells if cell.scene == scene.name]
    if own:
        body += details(f'Cells of the fixed list ({len(own)})', _cell_table(own))
    main = result.order_metric
    tables = f'<h4>Observed order of the {main.replace("_", " ")} error</h4>' + _order_table(result)
    tables += '<h4>Convergence of the references</h4>' + _reference_table(result, metrics)
    if result.exact is not None:
        errors = model_error(result, main)
        if errors:
            tables += f'<h4>Model error: converged against exact, {main.replace("_", " ")}</h4>' + \
                table(['k [N/m³]', f'[{METRICS[main][0]}]'], [list(pair) for pair in errors])
    body += details('Numerical errors, orders, references', ''.join(pictures[2:]) + tables)
    body += details(f'All {len(result.runs)} runs', _runs_table(result, metrics))
    return section(scene.title, 'scene-' + scene.name, body, 3)


def counts_section(compared, default):
    """The counts side by side. `compared`: {comparison: cells}."""
    names = {name: words for name, (_, words) in pareto.comparisons(default).items()}
    rows = []
    for name, cells in compared.items():
        c = pareto.counts(cells)
        rows.append([names[name]] + [Cell(str(c[key]), c[key]) for key in ('cells', 'contested', *VERDICTS, 'rounding')])
    return ('<p>A cell is scene × metric × decade of total error (test/report/pareto_cells.csv), reached with the least CPU time. It is '
            'won by 5 % or more against all settings of all peers; closer ones are level. What only one side reaches is counted apart, '
            f'and so are errors below {pareto.ROUNDING:g} relative, which are rounding.</p>' +
            table(['ours', 'cells', 'contested', *VERDICTS, 'rounding, apart'], rows))


def failure_section(results):
    """Who failed where, and why, grouped."""
    groups = collections.OrderedDict()
    for result in results:
        for run in result.runs:
            key = (result.scene.name, run.case.method)
            count = groups.setdefault(key, [0, []])
            count[0] += 1
            if run.status != 'ok':
                count[1].append(run)
    rows = []
    for (scene, method), (all_runs, failed) in groups.items():
        if failed:
            steps = ', '.join(sorted({f'{1e3 * run.case.step:.3g}' for run in failed}, key=float))
            rows.append([scene, method, Cell(f'{len(failed)} of {all_runs}', len(failed)), steps,
                         f'{failed[0].status}: {failed[0].reason}'])
    everyone = table(['scene', 'method', 'failed', 'at steps [ms]', 'the first of them'], rows)
    return ('<p>A run fails when a body is farther from the reference than the scene\'s bound, when its ledger gained more than '
            f'{100 * LEDGER_BOUND:g} % of the largest energy exchanged (at least what lifts the bodies by a millionth of the '
            'scene\'s size), when a step did not converge, or when it broke off. It reaches no cell.</p>' +
            details(f'{sum(len(result.failed()) for result in results)} failed runs by scene and method', everyone))


def settings_section(peers, results):
    rows = [[peer['name'], peer['purpose'], peer['meaning']] for peer in peers]
    rows += [[name, 'ours', meaning] for name, meaning in figures.MEANINGS.items()]
    body = table(['method', 'for', 'setting'], rows)
    body += ('<p class=note>All peers: friction is the geometric mean of both bodies, started without overlap, true spheres, cylinders, '
             'capsules, cones (Bullet) and planes where a scene says so; where a scene\'s contact is elastic ODE and Bullet get restitution '
             '1, MuJoCo springs without damping (solref −1/(2h)², 0). Every run of ours keeps its energy ledger.</p>')
    lost = [[result.scene.name, ', '.join(result.not_converging)] for result in results if result.not_converging]
    if lost:
        body += details('Peers whose error does not fall with their step', table(['scene', 'settings'], lost))
    return body


def _scene_overview(results):
    rows = []
    for result in results:
        cheapest = min((run.cpu for run in result.runs if run.status == 'ok'), default=math.nan)
        kind = 'exact' if result.scene.exact else 'conserved' if result.scene.chaotic else 'converged'
        rows.append([result.scene.name, result.scene.title, kind, Cell(str(len(result.runs)), len(result.runs)),
                     Cell(str(len(result.failed())), len(result.failed())), cheapest])
    return table(['scene', '', 'reference', 'runs', 'failed', 'cheapest [CPU s per s]'], rows)


def _first(holding, picture):
    """The first screen: who holds 1 kHz within one percent, in one sentence and one picture."""
    def words(holder):
        if not holder.runs:
            return 'none'
        steps = sorted(run.case.step for run in holder.runs.values())
        return (f'{len(holder.runs)} at {100 * advice.median_share(holder.runs.values()):.2g} % of a core (median) in steps of '
                f'{1e3 * steps[len(steps) // 2]:.2g} ms')
    peers = '; '.join(f'{holder.setting} {words(holder)}' for holder in holding[1:])
    return (f'<p class=lead>To hold a loop of 1 kHz with every error below 1 %, of {holding[0].scenes} scenes that all engines here can run: our '
            f'default holds {words(holding[0])}; of each peer the setting that holds most: {text(peers)}.</p>' + picture +
            '<p class=note>1 %: of a metre, radian, metre per second, newton or joule, in all measures that the list of cells has of a scene. Held: '
            f'the worst step, without the first, takes no more than {100 * advice.SHARE:g} % of its time. Scenes that rest or fly free '
            'are among them, for all.</p>')


def _losses(cells):
    """Where our default loses cells that both reach, or leaves them to a peer, and the reasons of test/report/README.md."""
    rows = []
    for scene in dict.fromkeys(cell.scene for cell in cells):
        own = [cell for cell in cells if cell.scene == scene and not cell.rounding]
        lost = [cell for cell in own if pareto.verdict(cell) == 'lost']
        left = [cell for cell in own if pareto.verdict(cell) == 'only theirs']
        if not lost and not left:
            continue
        worst = max(lost, key=lambda cell: cell.ours / cell.theirs, default=None)
        rows.append([scene, Cell(str(len(own)), len(own)), Cell(str(len(lost)), len(lost)), Cell(str(len(left)), len(left)),
                     worst.ours / worst.theirs if worst else math.nan, advice.named((worst or left[0]).their_run)])
    rows.sort(key=lambda row: -row[2].key - row[3].key)
    with open(os.path.join(programs.ROOT, 'test', 'report', 'README.md')) as file:
        reasons = file.read().split('## Where we lose, and why\n', 1)[1].split('\n## ', 1)[0]
    items = ''.join(f'<li>{text(re.sub("[*`]", "", item))}</li>' for item in reasons.replace('\n  ', ' ').split('- *')[1:])
    return table(['scene', 'cells', 'lost', 'only a peer', 'most time over the peer\'s', 'to'], rows) + f'<ul>{items}</ul>'


def _answer(results, compared, default, fixed):
    """What to choose, who wins, what failed."""
    rows = [[result.scene.name, advice.sentence(result, advice.metric_of(result, fixed.get(result.scene.name, ())))]
            for result in results]
    out = ''
    if compared:
        c = pareto.counts(compared['chosen'])
        out += (f'<p class=lead>Our default ({text(default)}; rigid or with the stiffness that the scene says, by a rule of the list) '
                'against all settings of all peers: of '
                f'{c["contested"]} contested cells ours wins {c["won"]}, the peers {c["lost"]}, {c["level"]} are level; {c["only ours"]} '
                f'more only ours reaches, {c["only theirs"]} only a peer.</p>')
    body = table(['scene', 'advice for a hand at 1 kHz'], rows)
    return out + (body if len(rows) <= 6 else details('What to choose for a hand at 1 kHz, scene by scene', body))


def benchmark_section(results):
    """The field's own benchmarks by their own measures: the step of 1 ms, or the one nearest to it."""
    rows = []
    for result in results:
        if not result.scene.benchmark:
            continue
        measures = result.scene.measures or ['position']
        for metric in measures:
            best = {}
            for run, errors in advice.errors_of(result):
                if run.status != 'ok' or metric not in errors or not (is_peer(run.case.method) or result.own_stiffness(run.case)):
                    continue
                key = abs(math.log(run.case.step / 1e-3))
                if run.case.facets == 0 and (run.case.method not in best or key < best[run.case.method][0]):
                    best[run.case.method] = (key, run, errors[metric])
            for method, (_, run, error) in best.items():
                rows.append([result.scene.name, metric, METRICS[metric][0], method,
                             Cell(f'{1e3 * run.case.step:.3g}', run.case.step), error, run.cpu, 1e6 * run.slowest])
    if not rows:
        return ''
    heads = ['scene', 'measure', 'unit', 'method', 'step [ms]', 'value', 'CPU s per s', 'worst step [µs]']
    return ('<p>Each by its own error measure, at the step nearest to 1 ms. Sources and published figures stand with the '
            'scenes.</p>' + details(f'{len(rows)} results', table(heads, rows)))


def write(path, results, refused, compared, sections, where, options, peers, default, fixed):
    """Writes the page; returns how many failed runs stand in its tables."""
    contents, parts = [], []
    first = ''
    if compared:
        holding = advice.holders(results, default, peers)
        first = _first(holding, figures.holders(holding, os.path.join(options.output, 'plots'))) if holding[0].scenes else ''

    def add(title, anchor, body):
        if body:
            parts.append(section(title, anchor, body))
            contents.append((anchor, title))
    own = [each for each in sections if each[1].startswith('own-')]  # of a report on scenes that the user named: first
    for title, anchor, content in own:
        add(title, anchor, content)
    if results:
        add('What to choose', 'answer', _answer(results, compared, default, fixed))
        if compared:
            add('Cells', 'pareto', counts_section(compared, default))
            add('Where we lose, and why', 'lost', _losses(compared['chosen']))
        add('Failures', 'failures', failure_section(results))
        add('Settings of every method', 'settings', settings_section(peers, results))
        overview = _scene_overview(results)
        if refused:
            overview += '<h4>Files that could not be loaded</h4>' + table(['file', 'reason'], [list(pair) for pair in refused])
        absent = sorted({(run.case.method, run.reason) for result in results for run in result.runs
                         if run.status == 'refused' and 'not installed' in run.reason})
        for method, reason in absent:
            overview += f'<p class=note>Skipped: {text(method)}: {text(reason)}</p>'
        add('Scenes', 'scenes', details(f'{len(results)} scenes', overview) if len(results) > 6 else overview)
        add('The field\'s own benchmarks', 'benchmarks', benchmark_section(results))
        cells = compared['all'] if compared else []
        parts.append(section('Error against run time', 'work', ''.join(
            scene_section(result, fixed.get(result.scene.name, ()), cells) for result in results)))
        contents += [('scene-' + result.scene.name, result.scene.title) for result in results]
    for title, anchor, content in sections:
        if not anchor.startswith('own-'):
            add(title, anchor, content)
    failed = sum(len(result.failed()) for result in results)
    cards = [(len(results), 'scenes'), (sum(len(result.runs) for result in results), 'runs'), (failed, 'failed runs, shown')] if results \
        else []
    if compared:
        c = pareto.counts(compared['chosen'])
        cards.insert(0, (f'{c["won"]} of {c["contested"]}', 'contested cells that our default wins'))
    kind = 'quick, ' if options.quick else ''
    lead = (f'<p class=note>{kind}{text(where["date"])}; {text(where["machine"])}, load average {text(where["load"])}; commit '
            f'{text(where["commit"])}; {text(where["compiler"])}; {text(where["flags"])}. Times are CPU times of the stepping thread, '
            'median of repetitions; the worst step is the median over repetitions of the largest, without the first.</p>')
    meanings = {**{peer['name']: peer['meaning'] for peer in peers}, **figures.MEANINGS}
    whole = document('Error against run time, and where it is stable', first + lead, cards, contents, ''.join(parts), meanings)
    with open(path, 'w') as file:
        file.write(whole)
    return shown_failures(whole)
