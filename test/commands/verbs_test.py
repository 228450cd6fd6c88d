#!/usr/bin/python3
"""What all verbs of ./run share: --help, --version, sections of packages.apt, completion."""
import glob
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xml.etree.ElementTree
from random import Random

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
                    "spidar_driver": ["spidar_driver_node", "device_check", "spidar_latency", "spidar_board_emulator", "spidar_stop",
                                      "motor_guard"]}
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

    def progress(self, script, *words):
        return ask("sh", "-uc", f"ROOT={ROOT} BUILD= CALLER=; . $ROOT/launch/verbs/parts/progress.sh; {script}", "sh", *words)

    def test_an_interrupt_at_any_instant_ends_a_verb(self):
        """While a verb starts its relay and its keeper, on a core that others use: of 200 interrupts three made the shell and its keeper wait
        for one another for ever. The end of the output tells that neither is left."""
        random, core = Random(1), min(os.sched_getaffinity(0))
        parts = "$ROOT/launch/verbs/parts"
        script = f"ROOT={ROOT} BUILD= CALLER=; . {parts}/output.sh; . {parts}/progress.sh; start_keeper; sleep 0.02; exit"
        others = [subprocess.Popen(["taskset", "-c", str(core), "sh", "-c", "while :; do :; done"]) for _ in range(4)]
        try:
            for _ in range(200):
                with subprocess.Popen(["taskset", "-c", str(core), "sh", "-uc", script], start_new_session=True,
                                      stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as verb:
                    time.sleep(random.uniform(0.001, 0.08))
                    verb.send_signal(signal.SIGINT)
                    try:
                        verb.communicate(timeout=60)
                        self.assertIn(verb.returncode, (130, 0, -signal.SIGINT))
                    finally:
                        if verb.poll() is None:
                            os.killpg(verb.pid, signal.SIGKILL)
        finally:
            for other in others:
                other.kill()
                other.wait()

    def test_time_left_is_right_within_a_third(self):
        """Builds of known length, on machines slower and faster than that of the table, whose objects take more or less: nineteen of
        twenty estimates. One is wrong where the longest object happens to come last."""
        with open(os.path.join(VERBS, "parts", "build_seconds.txt"), encoding="utf-8") as file:
            table = [line.split()[:2] for line in file if not line.startswith("#")]
        random, cores, errors = Random(1), os.cpu_count(), []
        for factor in (0.5, 1, 3) * 7:
            objects = [(name, factor * random.uniform(0.6, 1.4) * float(s)) for s, name in table]
            random.shuffle(objects)
            with tempfile.TemporaryDirectory() as folder:
                plan, log = (os.path.join(folder, name) for name in ("build.plan", "build.log"))
                lines = [f"[{i + 1}/{len(objects)}] Building CXX object a/CMakeFiles/{'.dir/'.join(name.split('/', 1))}\n"
                         for i, (name, _) in enumerate(objects)]
                with open(plan, "w", encoding="utf-8") as file:
                    file.writelines(line.split()[-1] + "\n" for line in lines)
                free, begins, ends = [0.0] * cores, [], []  # each core takes the next object when it is free
                for _, seconds in objects:
                    begins.append(free[0])
                    free[0] += seconds
                    ends.append(free[0])
                    free.sort()
                for share in (0.25, 0.5, 0.75):
                    now = share * max(ends)
                    with open(log, "w", encoding="utf-8") as file:
                        file.writelines(line for line, end in zip(lines, ends) if end <= now)
                    running = sum(now - begin for begin, end in zip(begins, ends) if begin < now < end)  # as /proc has it
                    left = float(self.progress('seconds_left "$@"', plan, log, str(now), str(int(running))).stdout)
                    errors.append(abs(left / (max(ends) - now) - 1))
        errors.sort()
        self.assertLess(errors[len(errors) * 19 // 20 - 1], 1 / 3, errors)

    def test_no_time_is_promised_before_a_tenth_is_done(self):
        with tempfile.TemporaryDirectory() as folder:
            plan, log = (os.path.join(folder, name) for name in ("build.plan", "build.log"))
            with open(plan, "w", encoding="utf-8") as file:
                file.writelines(f"a/CMakeFiles/x.dir/{i}.cpp.o\n" for i in range(100))
            for done, says in ((5, False), (40, True)):
                with open(log, "w", encoding="utf-8") as file:
                    file.writelines(f"[{i + 1}/100] Building CXX object a/CMakeFiles/x.dir/{i}.cpp.o\n" for i in range(done))
                self.assertEqual(self.progress('seconds_left "$@"', plan, log, "100").stdout != "", says)

    def test_a_compiler_that_runs_counts(self):
        """Two cores, one object of two done after 100 s of both: the time left falls as the other is compiled, and does not climb."""
        with tempfile.TemporaryDirectory() as folder:
            plan, log = (os.path.join(folder, name) for name in ("build.plan", "build.log"))
            with open(plan, "w", encoding="utf-8") as file:
                file.writelines(f"a/CMakeFiles/x.dir/{i}.cpp.o\n" for i in range(2))
            with open(log, "w", encoding="utf-8") as file:
                file.write("[1/2] Building CXX object a/CMakeFiles/x.dir/0.cpp.o\n")
            left = [int(self.progress('seconds_left "$@"', plan, log, str(now), str((now - 50) * os.cpu_count())).stdout or 0)
                    for now in (60, 70, 80, 90)]
            self.assertEqual(left, sorted(left, reverse=True))
            self.assertGreater(left[0], left[-1])

    def test_progress_names_the_source_that_is_waited_for(self):
        with tempfile.TemporaryDirectory() as folder:
            compiler = shutil.copy("/bin/sh", os.path.join(folder, "cc1plus"))
            unity = "src/CMakeFiles/haptic_core.dir/Unity/unity_world_cxx.cxx"
            with subprocess.Popen([compiler, "-c", "read wait; exit", unity], stdin=subprocess.PIPE, start_new_session=True) as first, \
                    subprocess.Popen([compiler, "-c", "read wait; exit", "x/late.cpp"], stdin=subprocess.PIPE) as other:
                self.assertEqual(self.progress('compiling "$1"', str(first.pid)).stdout, "0 haptic_core/unity_world\n")
                first.stdin.close()
                other.stdin.close()

    def test_progress_repeats_no_stray_line_of_a_log(self):
        lines = {"[librospack]: error while parsing /opt/ros/package.xml": "", "k_eff 3 N/m³": "",
                 "[12/345] Building CXX object a.o": ": [12/345] Building CXX object a.o",
                 " 7/41 Test #12: core_world ....   Passed": ":  7/41 Test #12: core_world ....   Passed",
                 "Unpacking python3-rosbag (1.16) ...": ": Unpacking python3-rosbag (1.16) ...",
                 "[1/2] Building " + "é" * 200: ": [1/2] Building " + "é" * 75}
        for line, shown in lines.items():
            with tempfile.NamedTemporaryFile("w", suffix=".log", encoding="utf-8") as log:
                log.write("before\n" + line + "\n")
                log.flush()
                said = self.progress('export LC_ALL=C.UTF-8; progress_line demo "$1" 0 7', log.name).stdout
                self.assertEqual(said, "demo: 7 s" + shown)

    def test_a_closed_pipe_ends_no_verb(self):
        parts = os.path.join(VERBS, "parts", "output.sh")
        for merged in ("", "2>&1"):
            with tempfile.TemporaryDirectory() as folder:
                end = os.path.join(folder, "end")
                work = (f". {parts}; for i in $(seq 20); do echo line $i; python3 -c 'print(1)'; echo told >&2; done; "
                        f"python3 -c 'print(2)' && echo ended >{end}")
                said = ask("sh", "-c", f"sh -uc \"$1\" {merged} | head -n 1", "sh", work)
                self.assertEqual(said.stdout, "line 1\n")
                self.assertNotIn("roken pipe", said.stderr)
                for _ in range(100):  # head and with it the shell end first
                    if os.path.exists(end):
                        break
                    time.sleep(0.1)
                self.assertTrue(os.path.exists(end), "the work went on to its end")
        kept = subprocess.run(["sh", "-uc", f". {parts}; for i in $(seq 500); do echo $i; echo $i >&2; done"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=60)
        self.assertEqual(kept.stdout.split(), [str(i) for i in range(1, 501) for _ in "12"], "every line, in its order")

    @unittest.skipUnless(os.getuid() == 0, "needs root for a name space")
    def test_all_is_told_when_a_verb_ends(self):
        """With the first process of a container the kernel ends all others: what a verb has said must have left it by then."""
        for words in (("docs", "nosuch"), ("stop", "nosuch"), ("--version",), ("demo", "--help")):
            for _ in range(8):
                told = ask("unshare", "--pid", "--fork", RUN, *words)
                self.assertNotEqual(told.stdout + told.stderr, "", words)

    def test_a_demo_builds_what_the_launch_files_of_the_documents_start(self):
        with open(os.path.join(VERBS, "demo.sh"), encoding="utf-8") as file:
            targets = re.search(r"^TARGETS='([^']*)'", file.read(), re.MULTILINE).group(1).split()
        documents = [os.path.join(ROOT, "README.md"), os.path.join(ROOT, "launch", "README.md")]
        documents += glob.glob(os.path.join(ROOT, "launch", "doc", "tutorials", "*.md"))
        started = set()
        for path in documents:
            with open(path, encoding="utf-8") as file:
                for name in re.findall(r"roslaunch haptic_bringup (\w+\.launch)", file.read()):
                    launch = xml.etree.ElementTree.parse(os.path.join(ROOT, "launch", "launch", name))
                    started |= {node.get("type") for node in launch.iter("node") if node.get("pkg") in ("penalty_sim", "spidar_driver")}
        started -= {"mcap_record"}  # a script
        self.assertIn("spidar_driver_node", started)
        self.assertEqual(started - set(targets), set())


if __name__ == "__main__":
    unittest.main()
