"""A study as its file states it: what is felt, how it is asked, how often, in which order. urdf/experiments/README.md has the keys."""
import hashlib
import math
import os
from dataclasses import dataclass, field

import strict_yaml
from strict_yaml import Refused

# What a condition may change, with unit and bounds. `rate` begins another loop, and so another block.
PROPERTIES = {
    'scene': ('', None, None),
    'stiffness': ('N/m^3', 1e3, 1e13), 'young_modulus': ('Pa', 1e2, 1e13), 'friction': ('1', 0, 3), 'damping': ('N s/m^3', 0, 1e9),
    'dissipation': ('s/m', 0, 1e3), 'mass': ('kg', 1e-4, 100), 'gravity': ('m/s^2', 0, 100), 'coupling': ('', None, None),
    'coupling_stiffness': ('N/m', 1, 1e5), 'pose_delay': ('s', 0, 0.2), 'force_delay': ('s', 0, 0.2), 'rate': ('Hz', 100, 10000), 'shown': ('', None, None), 'seen_offset': ('m', -0.1, 0.1)}
WORDS = {'coupling': ('direct', 'virtual'), 'shown': ('true', 'false')}
TASKS = ('two_interval', 'two_alternative', 'yes_no', 'magnitude', 'exploration')
DELAYS = ('pose_delay', 'force_delay')  # of the grip's pose to the pointer, of the force back; in whole ticks of the loop
METHODS = ('psi', 'quest_plus')
MEASURES = ('stiffness', 'friction', 'mass', 'none')
NAME = r'[A-Za-z0-9_]+'


@dataclass
class Phases:
    """Lengths of a trial's phases [s], and where home is [m]."""
    home_radius: float = 0.004
    home_seconds: float = 0.3
    explore_seconds: float = 3.0
    until_lift_off: bool = False
    respond_seconds: float = 30.0
    feedback_seconds: float = 0.0
    pause_seconds: float = 0.3


@dataclass
class Staircase:
    """`down` right answers in a row make it harder, `up` wrong ones easier. Levels are ratios to the standard."""
    parameter: str
    start: float
    steps: list
    least: float
    down: int = 2
    up: int = 1
    reversals: int = 8
    discard: int = 4
    max_trials: int = 80
    tracks: list = field(default_factory=lambda: [1])


@dataclass
class Adaptive:
    """Each level is the one whose answer tells most (psychometric.py). Levels are evenly spaced logarithms of ratios to the standard."""
    parameter: str
    method: str              # psi or quest_plus
    greatest: float          # ratio; the least is its inverse
    levels: int = 24         # even: the standard itself has no right answer
    max_trials: int = 80
    least_trials: int = 20
    width: float = 0.0       # of the JND's 95 % interval over the JND at which the session ends; 0: it has max_trials


@dataclass
class Study:
    """All of a study's file."""
    path: str
    text: str
    name: str
    title: str
    instructions: str
    scene: str
    device: str
    rate: float
    target: list
    task: str
    question: str
    answers: list
    standard: dict
    parameter: str
    conditions: list
    repetitions: int
    blocks: int
    practice: int
    order: str
    seed: int
    phases: Phases
    staircase: Staircase = None
    adaptive: Adaptive = None
    catch_every: int = 0
    break_every: int = 0
    break_seconds: float = 0
    questionnaire: list = field(default_factory=list)
    measure: str = 'none'
    tolerance: float = 0
    repeat_outside: bool = False
    hand: dict = field(default_factory=dict)
    lapse: float = 0.03
    force_check: float = 0.8

    @property
    def digest(self):
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def chooses_levels(self):
        """By the answers, trial by trial."""
        return self.staircase or self.adaptive

    def intervals(self):
        return 2 if self.task == 'two_interval' else 1

    def added_delay(self, condition):
        """That the loop adds to its wire's [s]: whole ticks."""
        rate = condition.get('rate', self.rate)
        return sum(math.floor(condition.get(name, 0.0) * rate + 0.5) for name in DELAYS) / rate  # halves up, as std::lround

    def rates(self):
        return sorted({c.get('rate', self.rate) for c in self.conditions + [self.standard]})


def value_of(mapping, key):
    unit, low, high = PROPERTIES[key]
    if key in WORDS:
        return mapping.text(key, choices=WORDS[key])
    if key == 'scene':
        return scene_path(mapping, mapping.text(key))
    del unit
    return mapping.number(key, low=low, high=high)


def condition_of(mapping, extra=()):
    """A dict of properties, `name` if it has one."""
    values = {}
    for key in [k.value for k, _ in mapping.node.value]:
        if key in PROPERTIES:
            values[key] = value_of(mapping, key)
        elif key in ('name',) + tuple(extra):
            values[key] = mapping.text(key, pattern=NAME if key == 'name' else None)
    mapping.known += list(PROPERTIES)
    mapping.finish()
    return values


def scene_path(mapping, word):
    """Beside the study, below it, or a name of urdf/scenes."""
    here = os.path.dirname(os.path.abspath(mapping.path))
    tree = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), 'urdf')
    folders = (here, os.path.join(here, 'scenes'), os.path.join(tree, 'experiments', 'scenes'), os.path.join(tree, 'scenes'))
    for folder in folders:
        for ending in ('', '.urdf'):
            path = os.path.join(folder, word + ending)
            if os.path.isfile(path):
                return os.path.abspath(path)
    return mapping.fail('scene', f"is '{word}'; there is no such URDF beside the study, in urdf/experiments/scenes or urdf/scenes")


def factor_conditions(mapping):
    """The product of the factors' levels, the first factor slowest."""
    keys = [k.value for k, _ in mapping.node.value]
    conditions = [{}]
    for key in keys:
        if key not in PROPERTIES:
            mapping.known = list(PROPERTIES)
            mapping.finish()
        _, low, high = PROPERTIES[key]
        if key in WORDS:
            levels = mapping.texts(key)
            for level in levels:
                if level not in WORDS[key]:
                    mapping.fail(key, f"has '{level}'; there are {', '.join(WORDS[key])}")
        elif key == 'scene':
            levels = [scene_path(mapping, word) for word in mapping.texts(key)]
        else:
            levels = mapping.numbers(key, low=low, high=high)
        if len(set(levels)) != len(levels):
            mapping.fail(key, 'has a level twice; leave one out and raise repetitions')
        conditions = [{**c, key: level} for c in conditions for level in levels]
    mapping.finish()
    if not keys:
        raise Refused(f'{mapping.path}:{mapping.node.start_mark.line + 1}: {mapping.name} has no factor; write stiffness: [1e7, 2e7]')
    return conditions, keys


def read_phases(mapping):
    phases = Phases()
    if mapping is None:
        return phases
    phases.home_radius = 1e-3 * mapping.number('home_radius_mm', 4.0, 0.1, 50)
    for key, low, high in (('home_seconds', 0, 60), ('explore_seconds', 0.1, 3600), ('respond_seconds', 0.1, 3600),
                           ('feedback_seconds', 0, 60), ('pause_seconds', 0, 600)):
        setattr(phases, key, mapping.number(key, getattr(phases, key), low, high))
    phases.until_lift_off = mapping.text('explore_until', 'time', choices=('time', 'lift_off')) == 'lift_off'
    mapping.finish()
    return phases


def needs_answers(mapping, task, what):
    if task not in ('two_interval', 'two_alternative', 'yes_no'):
        raise Refused(f'{mapping.path}:{mapping.node.start_mark.line + 1}: {what} needs right and wrong answers; '
                      'task: two_interval, two_alternative or yes_no')


def number_names():
    return [name for name, bounds in PROPERTIES.items() if bounds[1] is not None]


def read_adaptive(mapping, task):
    needs_answers(mapping, task, 'an adaptive method')
    a = Adaptive(parameter=mapping.text('parameter', choices=number_names()), method=mapping.text('method', 'quest_plus', METHODS),
                 greatest=mapping.number('greatest', low=1.001, high=100))
    a.levels = mapping.number('levels', 24, 4, 100, whole=True)
    a.max_trials = mapping.number('max_trials', 80, 2, 2000, whole=True)
    a.least_trials = mapping.number('least_trials', min(20, a.max_trials), 1, a.max_trials, whole=True)
    a.width = mapping.number('width', 0.0, 0, 4)
    if a.levels % 2:
        mapping.fail('levels', 'is odd, and the one in the middle would be the standard; give an even number')
    mapping.finish()
    return a


def read_staircase(mapping, task):
    needs_answers(mapping, task, 'a staircase')
    s = Staircase(parameter=mapping.text('parameter', choices=number_names()),
                  start=mapping.number('start', low=1.0001, high=100), steps=mapping.numbers('steps', low=1.0001, high=10),
                  least=mapping.number('least', 1.0001, 1.000001, 100))
    s.down = mapping.number('down', 2, 1, 8, whole=True)
    s.up = mapping.number('up', 1, 1, 8, whole=True)
    s.reversals = mapping.number('reversals', 8, 2, 1000, whole=True)
    s.discard = mapping.number('discard', 4, 0, 999, whole=True)
    s.max_trials = mapping.number('max_trials', 80, 2, 2000, whole=True)
    count = mapping.number('tracks', 1, 1, 8, whole=True)
    s.tracks = list(range(1, count + 1))
    if s.discard >= s.reversals:
        mapping.fail('discard', f'leaves none of {s.reversals} reversals; give less')
    if s.start <= s.least:
        mapping.fail('start', f'is not above least, {s.least:g}')
    mapping.finish()
    return s


def read_conditions(root, task):
    """(standard, conditions, the parameter on the axis of results)."""
    standard = root.mapping('standard', None)
    standard = condition_of(standard) if standard else {}
    if root.has('factors') and root.has('conditions'):
        root.fail('conditions', 'stands beside factors; keep one of the two')
    if root.has('factors'):
        conditions, keys = factor_conditions(root.mapping('factors'))
    elif root.has('conditions'):
        conditions = [condition_of(m) for m in root.mappings('conditions')]
        keys = [k for k in conditions[0] if k != 'name']
    else:
        conditions, keys = [], []
    axis = [k for k in keys if PROPERTIES[k][1] is not None]
    parameter = root.text('parameter', axis[0] if axis else '', choices=list(PROPERTIES))
    if task == 'two_interval' and parameter and parameter not in standard:
        root.fail('task', f'compares with a standard, which has no {parameter}; write standard: {{{parameter}: ...}}')
    return standard, conditions, parameter


def read(path):
    """The study of a file. Raises Refused, one line with file and line."""
    root, text = strict_yaml.read(path, 'the study')
    if root.number('study', low=1, high=1, whole=True) != 1:
        raise AssertionError('bounds')
    title, instructions = root.text('title'), root.text('instructions')
    scene = scene_path(root, root.text('scene'))
    task = root.text('task', choices=TASKS)
    staircase = read_staircase(root.mapping('staircase'), task) if root.has('staircase') else None
    adaptive = read_adaptive(root.mapping('adaptive'), task) if root.has('adaptive') else None
    if staircase and adaptive:
        root.fail('adaptive', 'stands beside a staircase; keep one of the two')
    standard, conditions, parameter = read_conditions(root, task)
    chooses, key = staircase or adaptive, 'staircase' if staircase else 'adaptive'
    if chooses:
        if conditions:
            raise Refused(f'{path}: {key}: chooses its own levels; leave factors and conditions out')
        if not standard.get(chooses.parameter):
            root.fail(key, f'changes {chooses.parameter}, which the standard has not; '
                      f'write standard: {{{chooses.parameter}: ...}}')
        parameter = chooses.parameter
    elif not conditions:
        raise Refused(f'{path}: the study has neither factors, conditions, a staircase nor an adaptive method; add one of them')
    catch = root.mapping('catch', None)
    catch_every = catch.number('every', low=2, high=1000, whole=True) if catch else 0
    if catch:
        catch.finish()
        if task != 'two_interval':
            root.fail('catch', 'wants two intervals: a catch trial has the standard in both')
    study = Study(
        path=os.path.abspath(path), text=text, name=os.path.splitext(os.path.basename(path))[0], title=title, instructions=instructions,
        scene=scene, device=root.text('device', 'spidar_g6x3r'), rate=root.number('rate', 1000.0, 100, 10000),
        target=root.texts('target', []), task=task, question=root.text('question', ''), answers=root.texts('answers', None),
        standard=standard, parameter=parameter, conditions=conditions or [dict(standard)],
        repetitions=root.number('repetitions', 1, 1, 1000, whole=True), blocks=root.number('blocks', 1, 1, 100, whole=True),
        practice=root.number('practice', 0, 0, 100, whole=True), order=root.text('order', 'random', ('random', 'latin', 'fixed')),
        seed=root.number('seed', 1, 0, 2**31, whole=True), phases=read_phases(root.mapping('phases', None)), staircase=staircase,
        adaptive=adaptive, catch_every=catch_every)
    read_rest(root, study)
    root.finish()
    check(root, study)
    return study


def read_rest(root, study):
    breaks = root.mapping('breaks', None)
    if breaks:
        study.break_every = breaks.number('every', low=1, high=10000, whole=True)
        study.break_seconds = breaks.number('seconds', low=0, high=3600)
        breaks.finish()
    for question in root.mappings('questionnaire', []):
        study.questionnaire.append({'name': question.text('name', pattern=NAME), 'text': question.text('text'),
                                    'choices': question.texts('choices', [])})
        question.finish()
    present = root.mapping('presented', None)
    if present:
        study.measure = present.text('measure', choices=MEASURES)
        study.tolerance = present.number('tolerance_pct', 0, 0, 100)
        study.repeat_outside = present.flag('repeat', False)
        present.finish()
    hand = root.mapping('simulated_hand', None)
    if hand:
        study.hand = {'gap': 1e-3 * hand.number('gap_mm', 8.0, 0, 100), 'press': 1e-3 * hand.number('press_mm', 6.0, 0.1, 100),
                      'stroke': 1e-3 * hand.number('stroke_mm', 12.0, 0, 100), 'period': hand.number('period_s', 1.0, 0.2, 60),
                      'weber': hand.number('weber', 0.1, 0, 10), 'lapse': hand.number('lapse', 0.0, 0, 0.5)}
        hand.finish()
    study.lapse = root.number('lapse', 0.03, 0, 0.2)
    study.force_check = root.number('force_check_n', 0.8, 0, 2)


def check(root, study):
    """What no single key shows."""
    if study.answers is None:
        study.answers = {'two_interval': ['first', 'second'], 'yes_no': ['no', 'yes']}.get(study.task, [])
    if study.task in ('two_interval', 'two_alternative', 'yes_no') and len(study.answers) != 2:
        root.fail('answers', f'are {len(study.answers)}; a {study.task} task has two')
    if study.task != 'exploration' and not study.question:
        root.fail('task', f'is {study.task}, which asks; write question: ...')
    if study.order == 'latin' and study.chooses_levels:
        root.fail('order', 'is a Latin square, and the levels are chosen by the answers; leave order out')
    changed = set(study.standard) | {k for c in study.conditions for k in c}
    if changed & {'stiffness', 'young_modulus', 'friction', 'damping', 'dissipation', 'mass', 'shown', 'seen_offset'} and not study.target:
        root.fail('scene', f'is changed in {", ".join(sorted(changed - {"rate", "gravity", "name", *DELAYS}))}, but of which links? '
                  'Write target: [LINK]')
    if study.task == 'two_interval' and len(study.rates()) > 1:
        root.fail('task', 'compares two intervals of one loop: rate cannot differ between them')
