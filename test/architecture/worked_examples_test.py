"""The worked examples of CONTRIBUTING: each applies to the sources as they are, compiles, and touches few files.

Prints how many, as figures: structure.files_for_a_joint_type and its like. Tests do not count.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
# Heading in CONTRIBUTING -> figure, most files that it may touch, what must compile afterwards.
EXAMPLES = {
    'A shape': ('structure.files_for_a_shape', 3, """
#include "haptic_core/geometry/shapes/shape_parts.cpp"
#include "../penalty_sim/scene/collision_shapes.cpp"
static_assert(!std::is_abstract_v<haptic::Cushion>);
"""),
    'A figure': ('structure.files_for_a_figure', 0, """
#include "../test/benchmark/fall_bench.cpp"
"""),
    'A joint type': ('structure.files_for_a_joint_type', 1, """
#include "haptic_core/dynamics/articulation_def.h"
using namespace haptic;
static_assert(kindOf(JointType::kCylindrical).type == JointType::kCylindrical);
static_assert(degreesOf(kindOf(JointType::kCylindrical)) == 2 && hasAxis(kindOf(JointType::kCylindrical)));
"""),
    'A pressure law': ('structure.files_for_a_pressure_law', 1, """
#include "haptic_core/contact/pressure_law.h"
using namespace haptic;
static_assert(kindOf(PressureLaw::kElastic).law == PressureLaw::kElastic && !jumpsAtTouch(PressureLaw::kElastic));
"""),
    'A force': ('structure.files_for_a_force', 1, """
#include "haptic_core/dynamics/rope_force.cpp"
using namespace haptic;
static_assert(kindOf(ForceType::kRope).type == ForceType::kRope && kindOf(ForceType::kRope).act == actAsRope);
"""),
}


def examples():
    """Heading -> list of (file, [(old lines, new lines)])."""
    with open(os.path.join(ROOT, 'CONTRIBUTING.md'), encoding='utf-8') as file:
        text = file.read()
    found = {}
    for paragraph in re.finditer(r'\*\*([^*]+)\*\*: (?:(?!\n\*\*).)*?```diff\n(.*?)```', text, re.S):
        files = []
        for line in paragraph.group(2).splitlines():
            if line.startswith('--- '):
                continue
            if line.startswith('+++ b/'):
                files.append((line[6:], []))  # a new one has lines of its own alone
            elif line.startswith('@@'):
                files[-1][1].append(([], []))
            else:
                old, new = files[-1][1][-1]
                if line[:1] in ' -':
                    old.append(line[1:])
                if line[:1] in ' +':
                    new.append(line[1:])
        found[paragraph.group(1)] = files
    return found


def filesTouched(files):
    """Besides files of its own."""
    return sum(not path.startswith('test/') and bool(hunks[0][0]) for path, hunks in files)


class WorkedExamples(unittest.TestCase):
    def test_each_applies_compiles_and_touches_few_files(self):
        found = examples()
        for heading, (figure, most, probe) in EXAMPLES.items():
            with self.subTest(heading), tempfile.TemporaryDirectory() as copy:
                self.assertIn(heading, found, 'CONTRIBUTING has no such example')
                for folder in ('src', 'penalty_sim/scene', 'test/benchmark', 'test/scenes'):
                    shutil.copytree(os.path.join(ROOT, folder), os.path.join(copy, folder))
                for path, hunks in found[heading]:
                    text = ''
                    if hunks[0][0]:
                        with open(os.path.join(copy, path), encoding='utf-8') as file:
                            text = file.read()
                    for old, new in hunks:
                        before, after = ('\n'.join(lines) + '\n' for lines in (old, new))
                        if not old:
                            self.assertFalse(os.path.exists(os.path.join(copy, path)), f'{path}: the example makes what there is')
                            text = after
                            continue
                        self.assertEqual(text.count(before), 1, f'{path}: the example no longer fits:\n{old}')
                        text = text.replace(before, after)
                    with open(os.path.join(copy, path), 'w', encoding='utf-8') as file:
                        file.write(text)
                count = filesTouched(found[heading])
                print(f'figure {figure} {count} 1')
                self.assertLessEqual(count, most)
                result = subprocess.run(
                    ['g++', '-std=c++17', '-fsyntax-only', '-Wall', '-Werror=switch', f'-I{copy}/src', f'-I{copy}/penalty_sim', '-isystem',
                     '/usr/include/eigen3', '-x', 'c++', '-'], input=probe, text=True, capture_output=True)
                self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == '__main__':
    sys.stdout.reconfigure(line_buffering=True)
    unittest.main()
