#!/usr/bin/python3
"""What all verbs of ./run share: --help, --version, sections of packages.apt, completion."""
import os
import re
import subprocess
import unittest

from run_verb import ROOT, RUN

VERBS = os.path.join(ROOT, "launch", "verbs")
NAMES = sorted(name[:-3] for name in os.listdir(VERBS) if name.endswith(".sh") and name != "version.sh")


def ask(*words, **options):
    return subprocess.run(list(words), capture_output=True, text=True, timeout=60, check=False, **options)


class Verbs(unittest.TestCase):
    def test_each_explains_itself_from_anywhere(self):
        overview = ask(RUN, "help", cwd="/")
        self.assertEqual(overview.returncode, 0, overview.stderr)
        for name in NAMES:
            for call in ([RUN, name, "--help"], [os.path.join(VERBS, name + ".sh"), "-h"]):
                said = ask(*call, cwd="/")
                self.assertEqual((said.returncode, said.stderr), (0, ""), call)
                self.assertRegex(said.stdout, rf"^usage: ./run\n  {name}\b")
                for line in said.stdout.splitlines()[1:]:
                    self.assertIn(line, overview.stdout)

    def test_version_is_that_of_the_core(self):
        with open(os.path.join(ROOT, "src", "CMakeLists.txt"), encoding="utf-8") as file:
            version = re.search(r"project\(haptic_core VERSION ([\d.]+)", file.read()).group(1)
        for call in ([RUN, "--version"], [RUN, "demo", "--version"]):
            self.assertTrue(ask(*call).stdout.startswith(f"haptics {version} ("), call)
        with open(os.path.join(ROOT, "CITATION.cff"), encoding="utf-8") as file:
            self.assertIn(f"version: {version}\n", file.read())
        programs = {"penalty_sim": ["scene_check", "haptic_replay", "session_table", "penalty_sim_node"],
                    "spidar_driver": ["spidar_driver_node", "device_check", "spidar_latency", "spidar_board_emulator", "motor_guard"]}
        for package, program in ((package, program) for package, names in programs.items() for program in names):
            said = ask(os.path.join(ROOT, "build", "devel", "lib", package, program), "--version")
            self.assertTrue(said.stdout.startswith(f"{program}, haptic_core {version}, "), said.stdout + said.stderr)

    def test_run_only_bootstraps(self):
        with open(RUN, encoding="utf-8") as file:
            self.assertLessEqual(len(file.readlines()), 150)

    def test_sections_of_packages(self):
        with open(os.path.join(ROOT, "packages.apt"), encoding="utf-8") as file:
            lines = file.read().splitlines()
        sections = [re.fullmatch(r"## ([a-z]+): (.+)", line).group(1) for line in lines if line.startswith("##")]
        used = set()
        for name in NAMES:
            with open(os.path.join(VERBS, name + ".sh"), encoding="utf-8") as file:
                for call in re.findall(r"^ *setup ([a-z ]+)", file.read(), re.M):
                    used |= set(call.split())
        self.assertEqual(used - set(sections), set(), "verbs name sections that exist")
        refused = ask(RUN, "setup", "no_such_section")
        self.assertNotEqual(refused.returncode, 0)
        self.assertEqual(len(refused.stderr.splitlines()), 1, refused.stderr)
        self.assertIn("no_such_section", refused.stderr)

    def test_completion(self):
        script = '. launch/completion/run.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _haptic_run; printf "%s\\n" "${COMPREPLY[@]}"'

        def complete(*words):
            return ask("bash", "-c", script, "bash", "./run", *words, cwd=ROOT).stdout.split()
        self.assertEqual(set(NAMES) - set(complete("")), set())
        self.assertEqual(complete("demo", "--scene", "touch_c"), ["touch_cube"])
        self.assertIn("--record", complete("demo", "--r"))
        self.assertIn("spidar_g6x3r", complete("check", "spidar_g"))
        self.assertEqual(complete("setup", "vi"), ["view"])


if __name__ == "__main__":
    unittest.main()
