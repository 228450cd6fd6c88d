"""What to choose: for each error the cheapest method and step that a hand at 1 kHz can hold, and what a peer would cost."""
import collections
import math

import pareto
from report_plan import DEFAULT, is_peer, is_wasm
from run_errors import METRICS

DECADES = (-2, -3, -4, -5, -6)
PERIOD = 1e-3  # [s] of the hand's loop
SHARE = 0.6    # of the time that a step has; the rest is for the device, the hand and the system

Choice = collections.namedtuple('Choice', 'decade ours theirs')
Choice.__doc__ = '''Cheapest runs of ours and of the peers with an error of at most 10^decade that the loop can hold; None: there is none.'''


def holds(run):
    """The loop at 1 kHz can hold it: steps no longer than the period, the worst of them within their share of their time."""
    return run.status == 'ok' and run.case.step <= PERIOD * (1 + 1e-9) and run.slowest <= SHARE * run.case.step


def errors_of(result):
    """(run, errors): total where the scene has a reference for all, else each against its own model."""
    return result.total or [(run, errors) for run, errors, _ in result.numerical]


def choices(result, metric):
    """A Choice for each decade. Ours are runs whose settings a scene can be given: of the default method, on shapes as they are."""
    held = [(run, errors[metric]) for run, errors in errors_of(result)
            if metric in errors and holds(run) and (is_peer(run.case.method) or can_be_written(run))]
    out = []
    for decade in DECADES:
        def cheapest(peers, limit=10.0 ** decade):
            return min((run for run, error in held if is_peer(run.case.method) == peers and error <= limit),
                       key=lambda run: run.cpu, default=None)
        out.append(Choice(decade, cheapest(False), cheapest(True)))
    return out


def can_be_written(run):
    """A scene can be given what this run of ours has: step, accuracy, stiffness; the method is no setting."""
    return run.case.method == DEFAULT and not run.case.facets


def written(run):
    """The settings of a run of ours as a scene has them."""
    case = run.case
    text = f'<haptic:scene step="{case.step:g}"' + (f' accuracy="{case.accuracy:g}"' if case.accuracy else '') + '>'
    return text + (' with stiffness="rigid"' if case.stiffness == math.inf else f' with stiffness="{case.stiffness:g}"' if case.stiffness else '')


def named(run):
    if can_be_written(run):
        return written(run)
    case = run.case
    more = ', rigid' if case.stiffness == math.inf else f', k {case.stiffness:.3g} N/m³' if case.stiffness else ''
    more += f', accuracy {case.accuracy:g}' if case.accuracy else ''
    return f'{case.method} at {1e3 * case.step:.3g} ms{more}' + (f', facets {case.facets}' if case.facets else '')


def advised(result):
    """(run, errors): what a scene should be given, of the settings that it can be given: of those that a loop at 1 kHz holds and that err by
    no more than twice the least error of position, the cheapest. (None, {}): none holds."""
    held = [(run, errors) for run, errors in errors_of(result) if holds(run) and can_be_written(run) and 'position' in errors]
    if not held:
        return None, {}
    least = max(min(errors['position'] for _, errors in held), 1e-9)  # a nanometre is as good as nothing
    return min((each for each in held if each[1]['position'] <= 2 * least), key=lambda each: each[0].cpu)


def sentence(result, metric):
    """One sentence: the smallest error of the list that ours reaches, how, and at what cost beside the peers'."""
    unit, name = METRICS[metric][0], metric.replace('_', ' ')
    kind = 'total' if result.total else 'numerical'
    reached = [choice for choice in choices(result, metric) if choice.ours]
    theirs = [choice for choice in choices(result, metric) if choice.theirs]
    if not reached:
        text = f'none of ours holds a {kind} {name} error of 1e{DECADES[0]} {unit} at 1 kHz'
        return text + (f'; {named(theirs[-1].theirs)} reaches 1e{theirs[-1].decade}.' if theirs else ', nor does a peer.')
    choice = reached[-1]
    run = choice.ours
    text = (f'for a {kind} {name} error of 1e{choice.decade} {unit} take {named(run)}: {100 * run.cpu:.2g} % of a core, worst '
            f'step {1e6 * run.slowest:.0f} µs')
    if result.scene.not_for_peers:
        return text + '; no peer here runs this scene.'
    if choice.theirs:
        ratio = choice.theirs.cpu / run.cpu
        return text + f'; a peer would cost {100 * choice.theirs.cpu:.2g} % ({named(choice.theirs)}), {ratio:.2g} times as much.'
    return text + (f'; peers reach 1e{theirs[-1].decade} at best.' if theirs else '; no peer reaches any of these errors.')


Holder = collections.namedtuple('Holder', 'engine setting runs scenes')
Holder.__doc__ = '''Of an engine the setting that holds most scenes: its cheapest run of each scene that it holds, of `scenes` in all.'''


def holders(results, default, peers):
    """[Holder] of our default, as the list has it, and of each engine whose times are comparable: who holds 1 kHz with all errors of the
    list within one percent, on the scenes that the peers run as well."""
    largest = {}
    for scene, metric, decade, _ in pareto.read_cells():
        largest.setdefault(scene, {}).setdefault(metric, decade)
    takes = pareto.comparisons(default)['chosen'][0]
    held, count = collections.defaultdict(dict), 0
    for result in results:
        limits = largest.get(result.scene.name, {})
        if not limits or not result.total or result.scene.not_for_peers:
            continue
        count += 1
        for run, errors in result.total:
            point = pareto.Point(run.cpu, 0, is_peer(run.case.method), result.own_stiffness(run.case), run)
            if is_wasm(run.case.method) or not (point.peer or takes(point)) or not holds(run):
                continue
            if all(errors.get(metric, math.inf) <= pareto.limit_of(decade) for metric, decade in limits.items()):
                of_setting = held[run.case.method]
                if result.scene.name not in of_setting or run.cpu < of_setting[result.scene.name].cpu:
                    of_setting[result.scene.name] = run
    engines = {'ours': [default]}
    for peer in peers:
        if not is_wasm(peer['name']):
            engines.setdefault(peer['name'].split('_')[0].rstrip('0123456789'), []).append(peer['name'])

    def best(settings):
        return max(settings, key=lambda name: (len(held[name]), -median_share(held[name].values())))
    return [Holder(engine, best(settings), held[best(settings)], count) for engine, settings in engines.items()]


def median_share(runs):
    """Of a core that runs take [1]; infinite where there is none."""
    shares = sorted(run.cpu for run in runs)
    return shares[len(shares) // 2] if shares else math.inf


def metric_of(result, fixed):
    """The metric that a scene's advice is about: the first of its list that any run has an error in."""
    entries = errors_of(result)
    for metric in result.metrics(fixed):
        if any(errors.get(metric, math.nan) > 0 for _, errors in entries):
            return metric
    return result.metrics(fixed)[0]
