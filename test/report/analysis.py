"""One scene of the report: its runs, their errors against each reference, and what is plotted and listed."""
import math

import numpy as np

import pareto
from report_plan import DEFAULT, Case, cases_of, chosen_stiffness, is_peer, is_wasm, model_of, references_of, rows_of, task_of
from run_errors import METRICS, error_over_time, errors_against, judged, parse_run


class SceneResult:
    """Runs and errors of one scene. `total` and `numerical`: lists of (run, {metric: error}); numerical ones also carry the
    convergence of their reference per metric."""

    def __init__(self, scene, quick, peers):
        self.scene, self.quick = scene, quick
        self.cases = cases_of(scene, quick, peers)
        self.references = references_of(scene, self.cases, quick)
        self.runs, self.total, self.numerical, self.not_converging = [], [], [], []
        self.orders, self.pictures = {}, []
        self.exact, self.converged, self.reference_notes = None, {}, []

    def tasks(self, program, stamp, done=()):
        """(row of cases, task) of everything that must run and is not in `done`."""
        cases = list(self.cases) + [case for pair in self.references.values() for case in pair]
        if self.scene.exact:
            cases.append(Case(self.scene.source, 'exact', 0, 0, 0))
        rows = rows_of(case for case in dict.fromkeys(cases) if case not in done)
        return [(row, task_of(row, program, stamp, self.quick, self.scene)) for row in rows]

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
            self._enter(parse_run(case, results[case]))

    def add(self, runs):
        """Runs of engines from outside: judged as all others where there is an exact solution; elsewhere listed without an error."""
        for run in runs:
            self._enter(run)

    def _enter(self, run):
        run, total, numerical = self.entry(run)
        self.runs.append(run)
        if total is not None:
            self.total.append((run, total))
        if numerical is not None:
            self.numerical.append((run, *numerical))

    def entry(self, run):
        """A run with its errors: run, total errors or None, (numerical errors, doubt) or None."""
        converged, doubt = self.converged.get(model_of(run.case), (None, {}))
        run = judged(run, self.bound_reference(converged, doubt), self.scene.size)
        total = None
        if self.exact is not None or self.scene.measures:
            total = {**errors_against(run, self.exact), **(run.measures if run.status == 'ok' else {})}
        return run, total, (errors_against(run, converged.trajectory), doubt) if converged is not None else None

    def bound_reference(self, converged, doubt):
        """What a run must stay near: the exact solution, else its model's own where that one has converged; or None."""
        if self.exact is not None:
            return self.exact
        if converged is None or not doubt.get('position', math.inf) < 0.1 * self.scene.size:
            return None
        return converged.trajectory

    def beyond_bound(self):
        """Runs that count as ok with a body beyond the bound: none, counted again from the trajectories."""
        count = 0
        for run in self.runs:
            reference = self.bound_reference(*self.converged.get(model_of(run.case), (None, {})))
            if run.status == 'ok' and reference is not None:
                away = np.linalg.norm(run.trajectory.pose[..., :3] - reference.pose[:len(run.trajectory.time), :, :3], axis=-1)
                count += bool(np.max(away) > self.scene.size)
        return count

    def find_not_converging(self, peers):
        """Settings of peers whose error does not fall with their step: the sanity test of each row. Less than a tenth of an
        order, above rounding, over the steps that did not fail; one step alone shows nothing."""
        entries = self.total if self.exact is not None else [(run, errors) for run, errors, _ in self.numerical]
        for peer in peers:
            rows = sorted((run.case.step, errors['position']) for run, errors in entries
                          if run.case.method == peer and errors.get('position', 0) > 1e-9)
            if len(rows) > 1 and np.polyfit(*np.log(np.array(rows)).T, 1)[0] < 0.1:
                self.not_converging.append(peer)

    def own_stiffness(self, case):
        return not case.stiffness or case.stiffness == self.scene.stiffness

    def is_default(self, run):
        """A run of our default with the stiffness that counts in the list, at any accuracy."""
        return run.case.method == DEFAULT and not run.case.facets and run.case.stiffness == chosen_stiffness(self.scene)

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
        wanted = (*self.scene.measures, 'wrench', 'position', 'orientation', 'energy')
        return [metric for metric in wanted if metric in present] or ['position']

    def main_metric(self, fixed=()):
        """What the numerical plot shows: the first metric that is not zero for every run."""
        for metric in self.metrics(fixed):
            if any(entry[1].get(metric, 0) > 1e-15 for entry in self.numerical):
                return metric
        return 'position'

    def points(self, wasm=False):
        """(scene, metric) -> [Point]: of all whose times are comparable, or of the others alone."""
        out = {}
        for run, errors in self.total:
            if is_wasm(run.case.method) != wasm:
                continue
            for metric, error in errors.items():
                out.setdefault((self.scene.name, metric), []).append(
                    pareto.Point(run.cpu, error, is_peer(run.case.method), self.own_stiffness(run.case), run))
        return out

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
                'stiffness_n_m3': case.stiffness, 'facets': case.facets, 'accuracy': case.accuracy, 'status': run.status, 'reason': run.reason,
                'error_kind': kind, 'metric': metric, 'error': error, 'unit': METRICS[metric][0] if metric else '',
                'reference': reference, 'reference_convergence': doubt, 'cpu_s_per_s': run.cpu,
                'cpu_least_s_per_s': run.cpu_low, 'cpu_most_s_per_s': run.cpu_high, 'step_p50_us': 1e6 * run.p50,
                'step_p99_us': 1e6 * run.p99, 'step_p999_us': 1e6 * run.p999, 'step_max_us': 1e6 * run.slowest,
                'steps': run.steps, 'newton_mean': run.iterations / max(1, run.steps), 'newton_worst': run.iterations_worst,
                'evaluations_worst': run.evaluations_worst, 'allocations': run.allocations,
                'unconverged_steps': run.unconverged, 'energy_gain_rel': run.gain}


def model_error(result, metric):
    """(stiffness, error of the converged solution against the exact one) of our volume models."""
    found = []
    for model, (run, _) in result.converged.items():
        if run is not None and result.exact is not None and model[0] == 'volume' and model[2] == 0:
            error = np.sqrt(np.mean(np.square(error_over_time(run.trajectory, result.exact)[metric])))
            found.append((model[1], float(error)))
    return sorted(found)
