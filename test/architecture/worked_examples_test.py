"""The worked examples of CONTRIBUTING: each applies to the sources as they are, compiles, and touches few files.

Prints how many, as figures: structure.files_for_a_joint_type and its like. Tests do not count, nor do files of the example's own.
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
    'An integrator': ('structure.files_for_an_integrator', 2, """
#include "haptic_core/world/step.cpp"
using namespace haptic;
static_assert(kIntegratorKinds[static_cast<int>(Integrator::kTwoEulers)].integrator == Integrator::kTwoEulers);
"""),
}


def examples():
    """Heading -> list of (file, [(old lines, new lines)], whether it is a new file)."""
    with open(os.path.join(ROOT, 'CONTRIBUTING.md'), encoding='utf-8') as file:
        text = file.read()
    found = {}
    for paragraph in re.finditer(r'\*\*([^*]+)\*\*: (?:(?!\n\*\*).)*?```diff\n(.*?)```', text, re.S):
        files = []
        for line in paragraph.group(2).splitlines():
            if line.startswith('--- '):
                comes = line == '--- /dev/null'
                continue
            if line.startswith('+++ b/'):
                files.append((line[6:], [], comes))
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
    return sum(not path.startswith('test/') and not comes for path, _, comes in files)


class WorkedExamples(unittest.TestCase):
    def test_each_applies_compiles_and_touches_few_files(self):
        found = examples()
        for heading, (figure, most, probe) in EXAMPLES.items():
            with self.subTest(heading), tempfile.TemporaryDirectory() as copy:
                self.assertIn(heading, found, 'CONTRIBUTING has no such example')
                shutil.copytree(os.path.join(ROOT, 'src'), os.path.join(copy, 'src'))
                for path, hunks, comes in found[heading]:
                    text = ''
                    if comes:
                        text = '\n'.join(hunks.pop()[1]) + '\n'
                    else:
                        with open(os.path.join(copy, path), encoding='utf-8') as file:
                            text = file.read()
                    for old, new in hunks:
                        self.assertEqual(text.count('\n'.join(old) + '\n'), 1, f'{path}: the example no longer fits:\n{old}')
                        text = text.replace('\n'.join(old) + '\n', '\n'.join(new) + '\n')
                    with open(os.path.join(copy, path), 'w', encoding='utf-8') as file:
                        file.write(text)
                count = filesTouched(found[heading])
                print(f'figure {figure} {count} 1')
                self.assertLessEqual(count, most)
                result = subprocess.run(
                    ['g++', '-std=c++17', '-fsyntax-only', '-Wall', '-Werror=switch', f'-I{copy}/src', '-isystem',
                     '/usr/include/eigen3', '-x', 'c++', '-'], input=probe, text=True, capture_output=True)
                self.assertEqual(result.returncode, 0, result.stderr)


if __name__ == '__main__':
    sys.stdout.reconfigure(line_buffering=True)
    unittest.main()
