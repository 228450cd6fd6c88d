"""What to choose: for each error the cheapest method and step that a hand at 1 kHz can hold, and what a peer would cost."""
import collections
import math

from report_plan import is_peer
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
    """A Choice for each decade."""
    held = [(run, errors[metric]) for run, errors in errors_of(result) if metric in errors and holds(run)]
    out = []
    for decade in DECADES:
        def cheapest(peers, limit=10.0 ** decade):
            return min((run for run, error in held if is_peer(run.case.method) == peers and error <= limit),
                       key=lambda run: run.cpu, default=None)
        out.append(Choice(decade, cheapest(False), cheapest(True)))
    return out


def named(run):
    case = run.case
    more = ', rigid' if case.stiffness == math.inf else f', k {case.stiffness:.3g} N/m³' if case.stiffness else ''
    return f'{case.method} at {1e3 * case.step:.3g} ms{more}' + (f', facets {case.facets}' if case.facets else '')


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


def metric_of(result, fixed):
    """The metric that a scene's advice is about: the first of its list that any run has an error in."""
    entries = errors_of(result)
    for metric in result.metrics(fixed):
        if any(errors.get(metric, math.nan) > 0 for _, errors in entries):
            return metric
    return result.metrics(fixed)[0]
