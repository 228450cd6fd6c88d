#!/usr/bin/env python3
"""Where the time of our steps goes: `profile_steps.py BUILD_FOLDER SCENE[:SECONDS]...` counts instructions with valgrind.

Prints a Markdown table: instructions of a step of 1 ms of our default, with the stiffness that counts in the list of cells, and the share of
each stage in them, callees included. Stages lie within one another: trees that flow are placed as well.
"""
import os
import re
import subprocess
import sys
import tempfile

import programs
from report_plan import DEFAULT, chosen_stiffness, describe

STAGES = {
    'flow': 'haptic::stepping::flow',
    'places, boxes': 'haptic::placeShapes(',
    'contact volumes': 'haptic::contactVolume(haptic::ConvexShape',
    'pressures, friction': 'haptic::locatedForce(',
    'sliding over the patch': 'haptic::slidingIntegral(',
    'matrix': 'haptic::FrozenMatrix::assemble(',
    'factor, solve': 'haptic::FrozenProblem::findStep(',
    'ledger': 'haptic::closeLedger(',
}


def profile(program, scene, seconds):
    """(instructions of a step, {stage: share})."""
    with tempfile.TemporaryDirectory() as folder:
        counts = os.path.join(folder, 'counts')
        stiffness = 'rigid' if chosen_stiffness(scene) == float('inf') else '0'
        count = ['valgrind', '--tool=callgrind', '--toggle-collect=haptic::World::step()', '--callgrind-out-file=' + counts]
        case = [scene.source, DEFAULT, '1e-3', stiffness, '--budget', '0', '--seconds', str(seconds), '--samples', '10']
        run = subprocess.run([*count, program, *case], capture_output=True, text=True, check=True)
        steps = int(re.search(r'^steps (\d+)', run.stdout, re.M).group(1))
        annotate = ['callgrind_annotate', '--inclusive=yes', '--threshold=100', counts]
        listed = subprocess.run(annotate, capture_output=True, text=True, check=True).stdout
    inclusive = {}
    for line in listed.splitlines():
        found = re.match(r'\s*([\d,]+) \([ \d.]+%\)\s+\S*?:(.*)', line)
        if found:
            inclusive.setdefault(found.group(2), int(found.group(1).replace(',', '')))
    total = next(count for name, count in inclusive.items() if name.startswith('haptic::World::step()'))
    return total / steps, {stage: next((count for name, count in inclusive.items() if name.startswith(start)), 0) / total
                           for stage, start in STAGES.items()}


def main(words):
    if len(words) < 2:
        sys.exit('profile_steps: give the build folder and scenes')
    program = programs.find(words[0], 'report_run')
    if not program:
        sys.exit(f'profile_steps: no report_run below {words[0]}; ./run report builds it in build/bench')
    print('| scene | instructions a step | ' + ' | '.join(STAGES) + ' |\n|---|' + '---|' * (1 + len(STAGES)))
    for word in words[1:]:
        name, _, seconds = word.partition(':')
        try:
            scene, = describe(program, [name])
            instructions, shares = profile(program, scene, seconds or 0.3)
        except ValueError as error:
            sys.exit(f'profile_steps: {error}')
        except FileNotFoundError as error:
            sys.exit(f'profile_steps: {error.filename} is not here: apt install valgrind')
        print(f'| {name} | {instructions:.0f} | ' + ' | '.join(f'{100 * share:.0f} %' for share in shares.values()) + ' |', flush=True)


if __name__ == '__main__':
    main(sys.argv[1:])
