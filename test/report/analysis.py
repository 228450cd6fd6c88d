"""One scene of the report: its runs, their errors against each reference, and what is plotted and listed."""
import math

import numpy as np

from report_plan import Case, cases_of, is_peer, model_of, references_of, task_of
from run_errors import METRICS, error_over_time, errors_against, parse_run


class SceneResult:
    """Runs and errors of one scene. `total` and `numerical`: lists of (run, {metric: error}); numerical ones also carry
    the convergence of their reference per metric."""

    def __init__(self, scene, quick):
        self.scene, self.quick = scene, quick
        self.cases = cases_of(scene, quick)
        self.references = references_of(scene, self.cases, quick)
        self.runs, self.total, self.numerical, self.orders, self.pictures = [], [], [], {}, []
        self.exact, self.converged, self.reference_notes = None, {}, []

    def tasks(self, program, stamp):
        """(case, task) of everything that must run."""
        cases = list(self.cases) + [case for pair in self.references.values() for case in pair]
        if self.scene.exact:
            cases.append(Case(self.scene.source, 'exact', 0, 0, 0))
        return [(case, task_of(case, program, stamp, self.quick, self.scene)) for case in cases]

    def take(self, results):
        """`results`: {case: result of its task}."""
        scene = self.scene
        if scene.exact:
            self.exact = parse_run(Case(scene.source, 'exact', 0, 0, 0),
                                   results[Case(scene.source, 'exact', 0, 0, 0)], 'reference').trajectory
        for model, (coarse, fine) in self.references.items():
            a, b = (parse_run(case, results[case], 'reference') for case in (coarse, fine))
            doubt = errors_against(a, b.trajectory) if b.status == 'ok' else {}
            best = b if b.status == 'ok' else a
            self.converged[model] = (best if best.status == 'ok' else None, doubt)
            self.reference_notes.append((model, fine, b.status if b.status != 'ok' else '', doubt))
        for case in self.cases:
            run = parse_run(case, results[case])
            self.runs.append(run)
            if self.exact is not None:
                self.total.append((run, errors_against(run, self.exact)))
            reference, doubt = self.converged.get(model_of(case), (None, {}))
            if reference is not None:
                self.numerical.append((run, errors_against(run, reference.trajectory), doubt))

    def failed(self):
        return [run for run in self.runs if run.status != 'ok']

    def metrics(self, fixed=()):
        """Metrics to show: those of the Pareto list, else those that any error differs in."""
        shown = [metric for metric in METRICS if metric in fixed]
        if shown:
            return shown[:4]
        present = set()
        for entry in self.total or self.numerical:
            present |= {metric for metric, error in entry[1].items() if error > 0}
        wanted = ('wrench', 'position', 'orientation', 'energy')
        return [metric for metric in wanted if metric in present] or ['position']

    def main_metric(self, fixed=()):
        """What the numerical plot shows: the first metric that is not zero for every run."""
        for metric in self.metrics(fixed):
            if any(entry[1].get(metric, 0) > 1e-15 for entry in self.numerical):
                return metric
        return 'position'

    def points(self):
        """(scene, metric) -> [(cpu, total error, is a peer, run)]."""
        out = {}
        for run, errors in self.total:
            for metric, error in errors.items():
                out.setdefault((self.scene.name, metric), []).append((run.cpu, error, is_peer(run.case.method), run))
        return out

    def grown(self):
        """One run of each method at the step nearest 1 ms, with the reference that its error is shown against."""
        runs, references = [], []
        chosen = {}
        for run in self.runs:
            if run.status != 'ok' or run.case.facets:
                continue
            key = (abs(math.log(run.case.step / 1e-3)), abs(run.case.stiffness - self.scene.stiffness))
            if run.case.method not in chosen or key < chosen[run.case.method][0]:
                chosen[run.case.method] = (key, run)
        for _, run in chosen.values():
            reference = self.exact
            if reference is None and self.converged.get(model_of(run.case), (None,))[0] is not None:
                reference = self.converged[model_of(run.case)][0].trajectory
            if reference is not None:
                runs.append(run)
                references.append(reference)
        return runs, references

    def rows(self):
        """Rows of the CSV: one per run, kind of error and metric; a failed run has one row without error."""
        numerical = {id(entry[0]): entry for entry in self.numerical}
        total = {id(entry[0]): entry for entry in self.total}
        for run in self.runs:
            written = False
            for kind, entries, reference in (('total', total, 'exact'), ('numerical', numerical, 'converged')):
                entry = entries.get(id(run))
                if not entry:
                    continue
                for metric, error in entry[1].items():
                    written = True
                    doubt = entry[2].get(metric, math.nan) if kind == 'numerical' else 0.0
                    yield self._row(run, kind, metric, error, reference, doubt)
            if not written:
                yield self._row(run, '', '', math.nan, '', math.nan)

    def _row(self, run, kind, metric, error, reference, doubt):
        case = run.case
        model, _, integrator = case.method.partition('-')
        return {'scene': self.scene.name, 'model': model, 'integrator': integrator or model, 'step_s': case.step,
                'stiffness_n_m3': case.stiffness, 'facets': case.facets, 'status': run.status, 'reason': run.reason,
                'error_kind': kind, 'metric': metric, 'error': error, 'unit': METRICS[metric][0] if metric else '',
                'reference': reference, 'reference_convergence': doubt, 'cpu_s_per_s': run.cpu,
                'cpu_least_s_per_s': run.cpu_low, 'cpu_most_s_per_s': run.cpu_high, 'step_p50_us': 1e6 * run.p50,
                'step_p99_us': 1e6 * run.p99, 'step_max_us': 1e6 * run.slowest, 'steps': run.steps,
                'allocations': run.allocations, 'unconverged_steps': run.unconverged,
                'energy_balance_rel': run.balance}


def model_error(result, metric):
    """(stiffness, error of the converged solution against the exact one) of our volume models."""
    found = []
    for model, (run, _) in result.converged.items():
        if run is not None and result.exact is not None and model[0] == 'volume' and model[2] == 0:
            error = np.sqrt(np.mean(np.square(error_over_time(run.trajectory, result.exact)[metric])))
            found.append((model[1], float(error)))
    return sorted(found)
