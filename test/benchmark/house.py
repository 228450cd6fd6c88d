#!/usr/bin/python3
"""The part of `./run bench house` that reads and counts: arrows between the core's folders, calls of the step's stages, files that a
force touches, modes, comments without a noun, lines; and instructions of the demo, of a heap and of Allegro's hand.

`--before BUILD`: the same instructions of another build folder of the benchmarks, and their ratio. A build whose sources have no
house_bench.cpp is given these. `--sources`: what is read alone."""
import argparse
import os
import re
import shutil
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path[:0] = [os.path.join(ROOT, 'test', 'architecture'), HERE]
import architecture_test  # noqa: E402
import dispatch  # noqa: E402
import structure  # noqa: E402

CORE = structure.CORE
HEADLESS = re.compile(r'\b([Ww]hat (is|was|has|a|an|the|no|of|it|they|can|does)|[Nn]obody|that which)\b')
# Stage of the step -> functions that are this stage.
STAGES = {'aim hands': ('aimHands', 'findActing'), 'place': ('place', 'placeAll', 'placeTrees'), 'find pairs': ('findPairs', 'lookForPairs'),
          'advance': ('advance',), 'collect': ('collectHeld',), 'book': ('book', 'closeLedger')}
OBSERVERS = {'energy_ledger'}  # settings that change no bit of the motion and nothing of the method
CASES = ('demo', 'heap10', 'allegro')
GIVEN = ('house_bench.cpp', 'house.cmake', os.path.join('..', 'scenes', 'circling_hands.h'))


def figure(name, value, unit):
    print(f'figure {name} {value:.10g} {unit}', flush=True)


def calls(text, name):
    """Calls of a free function in plain code; none where the file has a lambda by that name."""
    if re.search(rf'\bauto {name} = \[', text):
        return 0
    return sum(before in ('', 'return', 'else') for before in re.findall(rf'([\w&*>.]*)[ \n]*(?<![\w.>:])(?:stepping::)?{name}\(', text))


def pipeline(code):
    """Of functions that a header of world or stepping declares."""
    step = {path: text for path, text in code.items() if path.split('/')[2] in ('world', 'stepping')}
    most = 0
    for stage, names in STAGES.items():
        declared = [name for name in names if any(re.search(rf'^\w[\w&*<>: ]* {name}\(', text, re.M)
                                                  for path, text in step.items() if path.endswith('.h'))]
        places = {path: sum(calls(text, name) for name in declared) for path, text in step.items() if path.endswith('.cpp')}
        count = sum(places.values())
        print(f'stage {stage} ({", ".join(declared) or "no function"}):', f'{count} calls',
              *(f'{os.path.basename(path)} ({n})' for path, n in places.items() if n))
        most = max(most, count)
    figure('house.pipeline_calls_max', most, 'places')


def stages_of_step(code):
    """Functions that the pipeline of step.cpp calls and a header of world or stepping declares: how many are called from elsewhere too."""
    path = next(path for path in code if path.endswith('/world/step.cpp'))
    body = re.search(r'^void run\(.*?^\}', code[path], re.S | re.M).group(0)
    rooms = {p: text for p, text in code.items() if p.split('/')[2] in ('world', 'stepping')}
    declared = [name for name in sorted(set(re.findall(r'\b(?:stepping::)?(\w+)\(', body)))
                if any(re.search(rf'^\w[\w&*<>: ]* {name}\(', text, re.M) for p, text in rooms.items() if p.endswith('.h'))]
    places = {name: {p: calls(text, name) for p, text in rooms.items() if p.endswith('.cpp') and calls(text, name)} for name in declared}
    twice = {name: at for name, at in places.items() if sum(at.values()) > 1}
    for name, at in twice.items():
        print(f'called more than once: {name} in', *map(os.path.basename, at))
    print('stages of step.cpp:', *declared)
    figure('house.stage_calls_twice', len(twice), 'stages')


def reads(code):
    """Fields of a StepReport that code of world and stepping takes the value of. Written: assigned, added to, flagged, handed to the
    clock of stages; functions of the report write it."""
    found = []
    for path, text in code.items():
        if path.split('/')[2] not in ('world', 'stepping') or 'StepReport& report' not in text or path.endswith('/runaway.h'):
            continue
        for n, line in enumerate(text.split('\n'), 1):
            for match in re.finditer(r'(?<![\w.>])report\.(\w+)(?!\w|\(|\.| ?(?:[+|]?=)(?!=))', line):
                if match.group(1) != 'stages' and '++report.' + match.group(1) not in line and '#include' not in line:
                    found.append(f'{path}:{n}: {line.strip()}')
    for place in found:
        print('read:', place)
    figure('report.read_in_step', len(found), 'reads')


def arrows():
    """Includes from a folder to one that architecture_test lists later."""
    rank = {room: place for place, room in enumerate(architecture_test.CORE)}
    upward = {}
    for path in architecture_test.sources(os.path.join(ROOT, CORE)):
        room = os.path.relpath(path, os.path.join(ROOT, CORE)).split(os.sep)[0]
        for _, header in architecture_test.includes(path):
            target = header.split('/')[1] if header.startswith('haptic_core/') else room
            if rank[target] > rank[room]:
                upward.setdefault((room, target), []).append(os.path.basename(path))
    for (room, target), files in upward.items():
        print(f'upward: {room} -> {target}, {len(files)} includes in', *sorted(set(files)))
    figure('house.arrows_up', len(upward), 'arrows')
    figure('house.upward_imports', sum(map(len, upward.values())), 'includes')


def forces(code):
    """Files beyond that of its function and that of the table which name a row of kForceKinds."""
    table = next(((path, text) for path, text in code.items() if 'kForceKinds[]' in text), None)
    if not table:
        print('there is no table of kinds of force (kForceKinds): house.files_for_a_force is not counted')
        return
    rows = re.findall(r'\{(\w+::k\w+),.*?(\w+)\s*\}\s*,?\s*(?=\{\w+::k|\};)', table[1][table[1].index('kForceKinds[]'):], re.S)
    most = 0
    for enumerator, function in rows:
        own = [path for path, text in code.items() if path.endswith('.cpp') and re.search(r'\b' + function + r'\([^;{]*\{', text)]
        others = [path for path, text in code.items() if path not in own + [table[0]] and
                  re.search(rf'\b({re.escape(enumerator)}|{function})\b', text)]
        print(f'{enumerator}: in', *own, 'and a row of', table[0], *(['beside'] if others else []), *others)
        most = max(most, len(others))
    figure('house.files_for_a_force', most, 'files')


def modes(code):
    """Product of the values of settings that scene files, parameters or bindings can reach and that change the method."""
    reached = ' '.join(structure.plain(text) for _, text in structure.sources('penalty_sim'))
    settings = next(re.search(r'struct WorldSettings \{.*?\n\};', text, re.S).group(0) for text in code.values()
                    if 'struct WorldSettings {' in text)
    enums = {name: len([x for x in body.split(',') if x.strip()]) for text in code.values()
             for name, body in re.findall(r'enum class (\w+)[^{;]*\{([^}]*)\}', text)}
    product = 1
    for kind, name in re.findall(r'\n\s+(\w+) (\w+) = [^;(]+;', settings):
        values = 2 if kind == 'bool' else enums.get(kind, 1)
        if values > 1 and name not in OBSERVERS and re.search(r'settings(\(\))?\.' + name + r'\b|WorldSettings::' + name + r'\b', reached):
            print(f'mode: {name}, {values} values')
            product *= values
    figure('house.modes', product, 'combinations')


def headless():
    count, rooms = 0, {}
    for path, folders, files in os.walk(os.path.join(ROOT, CORE)):
        folders.sort()
        for name in sorted(files):
            with open(os.path.join(path, name), encoding='utf-8') as text:
                found = sum(bool(HEADLESS.search(line)) for line in text)
            room = os.path.relpath(path, os.path.join(ROOT, CORE)).split(os.sep)[0]
            rooms[room] = rooms.get(room, 0) + found
            count += found
    print('lines without a noun:', ', '.join(f'{room} {found}' for room, found in sorted(rooms.items()) if found))
    figure('house.headless_comments', count, 'lines')


def build_before(folder):
    """bench_house of another build; made there when it has none."""
    with open(os.path.join(folder, 'CMakeCache.txt'), encoding='utf-8') as cache:
        home = re.search(r'^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$', cache.read(), re.M).group(1)
    benches = os.path.join(home, *(['..'] if os.path.basename(home) == 'src' else []), 'test', 'benchmark')
    if os.path.realpath(benches) != os.path.realpath(HERE):
        for name in GIVEN:
            shutil.copyfile(os.path.join(HERE, name), os.path.join(benches, name))
        dispatch.run(['cmake', folder])
        dispatch.run(['cmake', '--build', folder, '--target', 'bench_house'])
    return dispatch.find(folder, 'bench_house')


def instructions(build, before):
    if not shutil.which('valgrind'):
        print('no valgrind here: instruction counts are left out (apt-get install valgrind)')
        return
    program, other = dispatch.find(build, 'bench_house'), build_before(before) if before else None
    for case in CASES:
        ours = dispatch.instructions(program, case)
        figure(f'house.{case}_instructions', ours, 'instructions')
        if other:
            figure(f'house.{case}_over_before', ours / dispatch.instructions(other, case), '1')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--build', help='build folder of the core and its benchmarks')
    parser.add_argument('--before', metavar='BUILD', help='another one to compare instructions with')
    parser.add_argument('--sources', action='store_true', help='count nothing that runs')
    options = parser.parse_args()
    if bool(options.build) == options.sources:
        parser.error('give --build BUILD or --sources')
    if options.before and not os.path.isfile(os.path.join(options.before, 'CMakeCache.txt')):
        parser.error(f'--before {options.before}: no build folder of CMake')
    lines, code = {}, {}
    for path, text in structure.sources(CORE):
        room = path.split('/')[2]
        lines[room] = lines.get(room, 0) + structure.code_lines(text)
        code[path] = structure.plain(text)
    pipeline(code)
    stages_of_step(code)
    reads(code)
    arrows()
    forces(code)
    modes(code)
    headless()
    figure('structure.core_lines', sum(lines.values()), 'lines')
    figure('house.stepping_world_lines', lines['stepping'] + lines['world'], 'lines')
    if options.build:
        instructions(options.build, options.before)


if __name__ == '__main__':
    sys.stdout.reconfigure(line_buffering=True)
    main()
