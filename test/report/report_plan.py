"""Which runs a report consists of: every method, step, stiffness and tessellation of a scene, every peer, and references.
"""
import collections
import json
import math
import os
import signal
import subprocess

import pareto
import programs
from task_pool import Task, file_stamp, key_of

STEPS = (1e-4, 1e-3 / 3, 1e-3, 1e-2 / 3, 1e-2)  # [s]
QUICK_STEPS = (1e-3, 1e-2 / 3, 1e-2)
# Of the peers' settings, those that a quick report runs: as it comes and for accuracy.
QUICK_PEERS = ('ode_exact', 'ode_quick20', 'ode_quick100_firm', 'bullet10', 'bullet50', 'bullet200_firm', 'mujoco_euler',
               'mujoco_firm', 'mujoco_fast')
WASM_MOST_BODIES, WASM_LEAST_STEP = 20, 3e-4  # larger scenes and shorter steps [s] take minutes a run, for errors alone
ACCURACIES, QUICK_ACCURACIES = (0.3, 0.1, 0.01, 0.003), (0.3, 0.003)  # of the default at 1 ms, beside its own
QUICK_MOST_BODIES = 20  # a quick report leaves larger scenes out unless they are named
# Our methods, and the factors on the scene's stiffness that each runs with, in a full and in a quick report: a stiffer
# foundation is nearer to the rigid reference, a softer one takes longer steps.
OURS = {
    'volume-verlet': ((0.01, 0.1, 1, 10, 100), (0.01, 1, 10, 100)),
    'volume-implicit': ((1, 1e3, 1e6, 1e8), (1, 1e8)),
    'volume-sdirk2': ((1, 1e3, 1e6, 1e8), (1, 1e6)),
    'volume-automatic': ((1, 1e6), (1, 1e6)),
    'point-verlet': ((1,), (1,)),
}
DEFAULT = 'volume-automatic'
RIGID = (DEFAULT,)  # methods that also run with all surfaces rigid (stiffness inf), where the scene's own says how
MOST_STIFFNESS = 1e14  # [N/m^3]: 0.1 kg on 1 cm^2 sinks 0.1 nm; beyond, rounding of the poses is larger than the depth
# [s] of the two runs whose difference says how well the reference has converged.
REFERENCE_STEPS = (1 / 32000, 1 / 64000)
QUICK_REFERENCE_STEPS = (1 / 4000, 1 / 8000)
CPU_LIMIT, QUICK_CPU_LIMIT = 45, 8  # [s] per run; references may take longer
REFERENCE_CPU_LIMIT = 240

Case = collections.namedtuple('Case', 'scene method step stiffness facets accuracy', defaults=(0,))
Case.__doc__ = '''One run. `scene`: name or file; `method`: see report_run.cpp; `step` [s]; `stiffness` [N/m^3], 0: the scene's own, inf:
rigid; `facets`, `accuracy`: 0: the scene's own.'''


class Scene:
    """What report_run says of a scene."""

    def __init__(self, description, source=None):
        self.__dict__.update(description)
        self.source = source or self.name  # name in the program, or the file
        self.exact = bool(self.reference)


def describe(program, names):
    """All scenes of the catalogue, or those of `names` (of the catalogue or of urdf/scenes, or files). Raises ValueError with one line."""
    done = subprocess.run([program, '--list'], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ValueError(done.stderr.strip() or f'{program} --list failed')
    catalogue = [Scene(json.loads(line)) for line in done.stdout.splitlines()]
    if not names:
        return catalogue
    scenes = []
    for name in names:
        found = [scene for scene in catalogue if scene.name == name]
        if found:
            scenes += found
            continue
        shipped = [path for path in (os.path.join(programs.ROOT, 'urdf', 'scenes', name + end) for end in ('.urdf', '.yaml'))
                   if os.path.isfile(path)]
        name = shipped[0] if shipped and not os.path.isfile(name) else name
        if not os.path.isfile(name):
            known = ' '.join(scene.name for scene in catalogue)
            raise ValueError(f"unknown scene '{name}'; give a file, a name of urdf/scenes, or some of: {known}")
        done = subprocess.run([program, '--describe', name], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ValueError(done.stderr.strip().splitlines()[-1].removeprefix('report_run: '))
        scenes.append(Scene(json.loads(done.stdout), source=name))
    return scenes


def describe_peers(program):
    """[{name, purpose, meaning}] of all settings that peers run with."""
    done = subprocess.run([program, '--peers'], capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def default_method(program):
    """The method of a world whose user chose none."""
    return subprocess.run([program, '--default'], capture_output=True, text=True, check=True).stdout.strip()


def is_peer(method):
    """Ours are named MODEL-INTEGRATOR."""
    return '-' not in method and method != 'exact'


def is_wasm(method):
    """A peer that runs in WebAssembly: its errors are comparable, its times are not."""
    return method.startswith(('mujoco3_', 'jolt', 'rapier'))


def cases_of(scene, quick, peers):
    """Cases whose cost and errors are shown. `peers`: names of their settings."""
    steps = [step for step in (QUICK_STEPS if quick else STEPS) if step > 0.99 * scene.smallest_step]
    own = [(method, factor) for method, factors in OURS.items()
           for factor in (factors[quick] if scene.exact and scene.stiffer_is_truer else (1,))
           if factor == 1 or factor * scene.stiffness <= MOST_STIFFNESS]
    cases = [Case(scene.source, method, step, factor * scene.stiffness, 0) for method, factor in own for step in steps]
    if scene.source == scene.name and scene.stiffness and (scene.exact or scene.chaotic):
        cases += [Case(scene.source, method, step, math.inf, 0) for method in RIGID for step in steps]
    if scene.round:
        levels = (1, 2, 3) if quick else (1, 2, 3, 4, 5)
        cases += [Case(scene.source, method, 1e-3, 0, level) for method in ('volume-verlet', 'volume-sdirk2')
                  for level in levels]
    if scene.smallest_step < 1.01e-3:
        cases += [Case(scene.source, DEFAULT, 1e-3, chosen_stiffness(scene), 0, accuracy)
                  for accuracy in (QUICK_ACCURACIES if quick else ACCURACIES)]
    if not scene.not_for_peers:
        cases += [Case(scene.source, peer, step, 0, 0) for peer in peers for step in steps
                  if not is_wasm(peer) or (scene.bodies <= WASM_MOST_BODIES and step > WASM_LEAST_STEP)]
    return cases


def chosen_stiffness(scene):
    """Of the runs of the default that count: rigid, or as the scene says, by the rule of the list of cells."""
    rigid = scene.source == scene.name and pareto.read_defaults().get(scene.name) == 'rigid' and scene.stiffness
    return math.inf if rigid else scene.stiffness


def references_of(scene, cases, quick):
    """For each model (contact model and stiffness, or peer) the runs at tiny steps: {model: [case, finer case]}."""
    steps = QUICK_REFERENCE_STEPS if quick else REFERENCE_STEPS
    models = {}
    if scene.chaotic or (scene.benchmark and scene.exact):
        return models  # judged by measures of its own, or against the exact solution alone
    for case in cases:
        model = model_of(case)
        if model in models or (is_peer(case.method) and scene.exact):
            continue  # peers are held against the exact solution where there is one
        if case.stiffness == math.inf:
            continue  # likewise
        if quick and not is_peer(case.method) and (case.stiffness != scene.stiffness or case.facets):
            continue  # numerical errors of the scene's own model only
        if is_peer(case.method):
            least = next(step for step in STEPS if step > WASM_LEAST_STEP) if is_wasm(case.method) else STEPS[0]
            own = steps if scene.benchmark else (least / 2, least / 4)
            models[model] = [Case(case.scene, case.method, step, 0, 0) for step in own]
            continue
        # Explicit at these steps holds 100 times the stiffness that the scene itself needs.
        soft = case.stiffness <= 100 * scene.stiffness
        method = 'point-verlet' if case.method.startswith('point') else 'volume-verlet' if soft else 'volume-sdirk2'
        models[model] = [Case(case.scene, method, step, case.stiffness, case.facets) for step in steps]
    return models


def model_of(case):
    """What two runs must share to converge to the same motion."""
    if is_peer(case.method):
        return case.method
    return (case.method.split('-')[0], case.stiffness, case.facets)


def rows_of(cases):
    """The cases by process: one runs all steps of a setting, the largest first, so that programs and engines start once a row."""
    rows = {}
    for case in sorted(cases, key=lambda case: -case.step):
        rows.setdefault((*case._replace(step=0), is_reference(case)), []).append(case)
    return [tuple(row) for row in rows.values()]


def is_reference(case):
    return 0 < case.step < STEPS[0] / 1.5


def limit_of(case, quick):
    """[s] of CPU time that a run may take."""
    return QUICK_CPU_LIMIT if quick else REFERENCE_CPU_LIMIT if is_reference(case) else CPU_LIMIT


def task_of(row, program, stamp, quick, scene):
    """The process of a row. Its key changes with the program and with the scene's file."""
    case = row[0]
    # References and engines in WebAssembly run once: their times count for nothing.
    budget = '0' if (is_reference(case) and not quick) or is_wasm(case.method) else '0.01'
    limit = limit_of(case, quick)
    command = [program, case.scene] + (['exact'] if case.method == 'exact' else
                                       [case.method, ','.join(repr(each.step) for each in row), repr(float(case.stiffness)),
                                        str(case.facets), '--budget', budget, '--limit', f'{limit:g}'] +
                                       (['--accuracy', repr(case.accuracy)] if case.accuracy else []))
    content = file_stamp(case.scene) if os.path.isfile(case.scene) else ''
    steps = sum(scene.seconds / each.step for each in row if each.step)
    weight = steps * (0.2 + scene.bodies) * (20 if case.method == 'ode_exact' and scene.bodies > 8 else 1)
    # 5 s a run: each is ended by its own limit first.
    return Task(key_of(stamp, content, *command[1:]), tuple(command), len(row) * (limit + 5), weight)


def parts_of(row, result, quick):
    """{case: result of its own} of a row's process. One that died took the run along that it died in; those after it are not told of."""
    if row[0].method == 'exact':
        return {row[0]: result}
    told = ('\n' + result['output']).split('\nrun ')[1:]
    whole = [part for part in told if part.rstrip().endswith('\nend')]
    parts = {case: {'failure': '', 'output': part} for case, part in zip(row, whole)}
    if len(whole) < len(row):
        case = row[len(whole)]
        by_time = result.get('code') == -signal.SIGXCPU
        reason = f'took more than {limit_of(case, quick):g} s of CPU time' if by_time else result['failure'] or 'printed nothing'
        parts[case] = {'failure': reason, 'output': ''}
    return parts
