#!/usr/bin/python3
"""The first call of each verb on a machine on which nothing is installed: by whom, with what was there, and from where."""
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from bare_machine import ROOT, BareMachine, checkout_of_scripts, on_a_terminal
from run_verb import PROGRESS, descendants

USER = 65534  # nobody
LIMIT = 240  # [s] for a call on a busy machine; they take 3 to 10


def environment(machine, **more):
    kept = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "ROS_MASTER_URI", "ROS_LOG_DIR")}
    return {**kept, **machine.environment, **more}


class Bare(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = holder.name
        os.chmod(self.folder, 0o777)

    def machine(self, **options):
        place = tempfile.mkdtemp(dir=self.folder)
        return BareMachine(place, **options)

    def untouched(self, machine):
        self.assertFalse(os.path.exists(machine.reached), "the real apt-get was called")


class InABuiltCheckout(Bare):
    """What a verb does after its set-up: the values of its options must be those of the call."""

    def call(self, *words, machine=None, says=(), run=None, codes=(0,), **more):
        machine = machine or self.machine()
        done = subprocess.run([run or os.path.join(ROOT, "run"), *words], env=environment(machine, **more), cwd=self.folder,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT, check=False)
        self.assertIn(done.returncode, codes, f"{words}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
        self.untouched(machine)
        for word in says:
            self.assertIn(word, done.stdout + done.stderr)
        return machine

    def installs_once(self, *words, **more):
        machine = self.call(*words, **more)
        self.assertEqual(len(machine.installs()), 1, machine.text("calls"))
        return machine

    def test_demo_keeps_its_options(self):
        self.installs_once("demo", "--seconds", "1", "--missing-meshes", "box", says=["figure demo.ticks 1000 ", "setup: installs 65 Debian"])

    def test_recording_and_all_that_reads_it(self):
        bag = os.path.join(self.folder, "first.bag")
        self.installs_once("demo", "--seconds", "1", "--rate", "500", "--missing-meshes", "skip", "--record", bag,
                           says=["figure demo.ticks 500 ", f"demo: recorded {bag}"])
        self.installs_once("replay", bag, says=["figure replay.mismatches 0 "])
        self.installs_once("export", bag, "--npz")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "first.npz")))

    def test_checks(self):
        self.installs_once("check", "touch_cube", "--rate", "2000", says=["figure check.collisions_lost 0 "])
        self.installs_once("check", "spidar_g6x3r", says=["figure check.strings 8 "])

    def test_what_is_asked_of_the_machine(self):
        self.installs_once("latency", "--device", "spidar_g6x3r", "--transport", "twin", "--seconds", "0.1",
                           says=["figure latency.max_rate_hz"], codes=(0, 1))  # 1: a busy machine keeps no rate
        self.call("--version", says=["haptics "])

    def test_through_a_symlink_from_a_folder_of_any_name(self):
        place = os.path.join(self.folder, "ein Ordner ä")
        os.makedirs(place)
        link = os.path.join(place, "haptik")
        os.symlink(os.path.join(ROOT, "run"), link)
        self.installs_once("check", "touch_cube", run=link)

    def test_packages_that_were_removed_come_back(self):
        machine = self.machine(installed=True, removed="libqhull-dev")
        self.call("check", "touch_cube", machine=machine)
        self.assertEqual(len(machine.installs()), 1)
        self.assertTrue(machine.installs()[0].endswith(" libqhull-dev"), machine.installs())

    def test_a_home_that_cannot_be_written(self):
        self.installs_once("check", "touch_cube", HOME="/proc/nowhere")

    def test_what_is_there_is_not_installed_again(self):
        machine = self.machine(installed=True)
        self.call("check", "touch_cube", machine=machine)
        self.assertEqual(machine.text("calls"), "")


class WhereNothingIsBuilt(Bare):
    """Set-up alone, in a checkout without a build: each call is ended when it begins to compile."""

    def first(self, *words, machine=None, place=None, user=None, run=None, **more):
        """Runs until a log of the build is there; returns the machine and all that was said."""
        machine = machine or self.machine()
        place = place or checkout_of_scripts(tempfile.mkdtemp(dir=self.folder))
        mark = f"HAPTIC_TEST_CALL=first-{os.getpid()}-{time.monotonic_ns()}"
        given = environment(machine, HAPTIC_TEST_CALL=mark.split("=")[1], **more)
        other = [] if user is None else ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups"]
        with subprocess.Popen([*other, run or os.path.join(place, "run"), *words], env=given, cwd=self.folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
            deadline = time.monotonic() + LIMIT
            logs = os.path.join(place, "build", "log")
            while process.poll() is None and time.monotonic() < deadline:
                begun = set(os.listdir(logs)) - {"setup.log", "packages.log", "configure.log"} if os.path.isdir(logs) else set()
                if begun:
                    process.send_signal(signal.SIGINT)
                    break
                time.sleep(0.05)
            said, _ = process.communicate(timeout=LIMIT)
        self.untouched(machine)
        self.assertEqual(descendants(mark), [], f"{words} leaves processes")
        return machine, process.returncode, said

    def test_each_verb_installs_what_it_needs_and_goes_on(self):
        """Verbs that compile for long or need what compiles: up to there."""
        place = checkout_of_scripts(self.folder)
        for words, package in ((["build"], "pybind11-dev"), (["test"], "libgtest-dev"), (["bench", "contact"], "libbenchmark-dev"),
                               (["bench", "fuzz"], "clang"), (["report", "--quick"], "python3-distributed"),
                               (["package"], "fakeroot"), (["experiment", "friction", "--power"], "python3-scipy")):
            with self.subTest(words[0]):
                subprocess.run(["rm", "-rf", os.path.join(place, "build")], check=True)
                machine, code, said = self.first(*words, place=place)
                self.assertEqual(code, 130, said)
                self.assertEqual(len(machine.installs()), 1, said)
                self.assertIn(f" {package}", machine.installs()[0])

    def test_files_that_are_something_else_are_refused_before_set_up(self):
        place = checkout_of_scripts(self.folder)
        robot = b"<robot name='a'><link name='world'/></robot>\n"
        files = {"empty.urdf": b"", "text.urdf": b"hello\n", "binary.urdf": b"\xff\xfe<\0r\0o\0b\0", "cut.urdf": robot[:20], "list.yaml": b"a: [1\n",
                 "mesh.stl.urdf": b"solid a\n", "device.yaml": b"name: a\n"}
        for name, text in files.items():
            with open(os.path.join(self.folder, name), "wb") as out:
                out.write(text)
        calls = [["demo", "--scene", name] for name in files] + [["check", name] for name in files]
        calls += [["demo", "--device", "device.yaml"], ["experiment", "device.yaml", "--subject", "a"], ["latency", "--device", "list.yaml"]]
        calls += [["demo", "--xacro", "arm.left"], ["report", "cut.urdf"]]
        machine = self.machine()
        for words in calls:
            with self.subTest(" ".join(words)):
                done = subprocess.run([os.path.join(place, "run"), *words], env=environment(machine), cwd=self.folder, stdin=subprocess.DEVNULL,
                                      capture_output=True, text=True, timeout=LIMIT, check=False)
                self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1), done.stderr)
                self.assertIn(next(word for word in words[1:] if "." in word), done.stderr)
                self.assertEqual(machine.text("calls"), "")
        with open(os.path.join(self.folder, "whole.urdf"), "wb") as out:
            out.write(b"\xef\xbb\xbf" + robot + b"<!-- end -->\n\n")
        _, code, said = self.first("check", "whole.urdf", place=place)
        self.assertEqual(code, 130, said)

    def test_words_that_say_nothing_are_refused_before_set_up(self):
        place, machine = checkout_of_scripts(self.folder), self.machine()
        for words in (["demo", "--device", ""], ["demo", "--record", ""], ["check", "friction", "--subject", ""], ["version", "now"],
                      ["demo", "--emulate", "--hardware", "--device", "uart"], ["demo", "--master-port", "80"]):
            with self.subTest(" ".join(words)):
                done = subprocess.run([os.path.join(place, "run"), *words], env=environment(machine), cwd=self.folder, stdin=subprocess.DEVNULL,
                                      capture_output=True, text=True, timeout=LIMIT, check=False)
                self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1), done.stderr)
                self.assertEqual(machine.text("calls"), "")

    def test_a_port_is_judged_where_no_python_is_installed_yet(self):
        script = 'fail() { echo "$*"; exit 1; }; . "$1"; PATH=/nowhere; ensure_master_port "$2"'
        for port, code in (("11311", 0), ("80", 1), ("99999", 1), ("9" * 30, 1)):
            done = subprocess.run(["sh", "-uc", script, "sh", os.path.join(ROOT, "launch/verbs/parts/names.sh"), port],
                                  capture_output=True, text=True, check=False, timeout=60)
            self.assertEqual((done.returncode, done.stderr), (code, ""), done.stdout)

    def test_a_disk_that_is_too_small(self):
        machine, code, said = self.first("build", HAPTIC_TEST_MB="99999999")
        self.assertEqual(code, 1, said)
        self.assertIn("too small", said)
        self.assertEqual(machine.installs(), [])

    @unittest.skipUnless(os.getuid() == 0, "needs root to be somebody else")
    def test_a_user_without_sudo_is_told_the_command(self):
        place = checkout_of_scripts(self.folder, USER)
        for sudo in (None, "asks"):
            machine = self.machine(sudo=sudo)
            done = subprocess.run(["setpriv", f"--reuid={USER}", f"--regid={USER}", "--clear-groups", os.path.join(place, "run"), "build"],
                                  env=environment(machine), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT, check=False)
            lines = [line for line in done.stderr.splitlines() if not PROGRESS.match(line)]
            self.assertEqual((done.returncode, len(lines)), (1, 1), done.stderr)
            self.assertIn("apt-get install -y --no-install-recommends", lines[0])
            self.untouched(machine)

    @unittest.skipUnless(os.getuid() == 0, "needs root to be somebody else")
    def test_sudo_asks_for_its_password_on_a_terminal(self):
        place = checkout_of_scripts(self.folder, USER)
        for answer, code in (("wrong", 1), ("secret", 0)):
            machine = self.machine(sudo="asks")
            subprocess.run(["chown", "-R", str(USER), machine.folder], check=True)
            ended, said = on_a_terminal([os.path.join(place, "run"), "setup", "tools"], [("password: ", answer)], limit=LIMIT, user=USER,
                                        env=environment(machine))
            if code == 0 and "unshare" in said:
                self.skipTest("this machine gives users no name spaces")
            self.assertEqual(ended, code, said)
            self.assertEqual(len(machine.installs()), 1 - code, said)
            self.untouched(machine)

    @unittest.skipUnless(os.getuid() == 0, "needs root to be somebody else")
    def test_a_build_folder_of_roots_is_said(self):
        place = checkout_of_scripts(self.folder, USER)
        os.makedirs(os.path.join(place, "build", "log"))
        done = subprocess.run(["setpriv", f"--reuid={USER}", f"--regid={USER}", "--clear-groups", os.path.join(place, "run"), "build"],
                              env=environment(self.machine()), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT, check=False)
        self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1), done.stderr)
        self.assertIn("sudo chown -R", done.stderr)

    def test_root_gives_the_build_folder_to_the_caller_of_sudo(self):
        place = checkout_of_scripts(self.folder)
        subprocess.run([os.path.join(place, "run"), "setup", "tools"], env=environment(self.machine(), SUDO_UID=str(USER), SUDO_GID=str(USER)),
                       stdin=subprocess.DEVNULL, capture_output=True, timeout=LIMIT, check=True)
        self.assertEqual(os.stat(os.path.join(place, "build", "log")).st_uid, USER)


# Options that bring a section with them, and verbs that need no more than their name. Those of rviz need a display, by name.
CALLS = (["demo"], ["demo", "--missing-meshes", "box"], ["demo", "--missing-meshes", "skip"], ["demo", "--record", "a.bag"], ["demo", "--rviz"],
         ["demo", "--dark"], ["demo", "--emulate", "--device", "uart"], ["demo", "--hardware"], ["demo", "--rate", "2000", "--xacro", "a:=1"],
         ["check", "touch_cube", "--strict", "--all"], ["check", "spidar_g6x3r", "--picture", "a.svg"], ["check", "friction"],
         ["latency", "--device", "spidar_g6x3r"], ["build"], ["test"], ["test", "core_base"], ["test", "--sanitize", "address"],
         ["bench", "contact"], ["bench", "python"], ["bench", "fuzz"], ["bench", "experiment"], ["report"], ["report", "rest", "--quick"],
         ["package"], ["docs"], ["experiment", "friction", "--power"], ["experiment", "weight", "--subject", "a", "--windows"], ["setup"],
         ["setup", "view", "tools"])


@unittest.skipUnless(os.environ.get("HAPTIC_FIRST_PRODUCT"), "twenty minutes: ./run bench first")
class Product(WhereNothingIsBuilt):
    """Every call by every caller, with every machine, from every place."""

    def test_all(self):
        wrong, count = [], 0
        for words in CALLS:
            for user, sudo in ((None, None), (USER, "free"), (USER, None)):
                for there in ({}, {"installed": True, "removed": "libyaml-cpp-dev\npython3-rosbag\nlibgtest-dev\ndoxygen\npython3-numpy"}):
                    for through, home in (("run", None), ("a link", "/proc/nowhere")):
                        count += 1
                        problem = self.problem_of(words, user, sudo, there, through, home)
                        if problem:
                            wrong.append(f"{words} by {user} sudo {sudo} {there} {through}: {problem}")
                            print(wrong[-1], flush=True)
        print(f"figure first.product {count} 1\nfigure first.product_failed {len(wrong)} 1")
        self.assertEqual(wrong, [])

    def problem_of(self, words, user, sudo, there, through, home):
        """Nothing where the call came as far as it must: to the compiler, or to one line where nobody may install."""
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            place = checkout_of_scripts(os.path.join(folder, "here"), user)
            machine = BareMachine(os.path.join(folder, "here", "machine"), sudo=sudo, **there)
            if user is not None:
                subprocess.run(["chown", "-R", str(user), machine.folder], check=True)
            run = os.path.join(place, "run")
            if through != "run":
                run = os.path.join(folder, through)
                os.symlink(os.path.join(place, "run"), run)
            more = {"DISPLAY": ":99"} if {"--rviz", "--dark", "--windows"} & set(words) else {}
            if home:
                more["HOME"] = home
            machine, code, said = self.first(*words, machine=machine, place=place, user=user, run=run, **more)
        refused = user is not None and sudo is None
        if there and refused and code == 130:
            return ""  # what was removed is no part of this call
        if refused:
            return "" if code == 1 and "apt-get install -y" in said else f"{code} {said[-300:]}"
        wanted = (0, 130) if words[0] == "setup" or there else (130,)
        return "" if code in wanted and "not set" not in said and "not found" not in said else f"{code} {said[-300:]}"


class Interrupted(Bare):
    def test_apt_is_told_alone_and_waited_for(self):
        """A second process of apt's group stands for dpkg: it must end by itself."""
        place = checkout_of_scripts(self.folder)
        machine = self.machine()
        ended = os.path.join(self.folder, "ended")
        with open(os.path.join(machine.folder, "apt-get"), "a", encoding="utf-8") as out:
            out.write(f"""case " $* " in *' --print-uris '*) ;; *' install '*)
  trap 'echo interrupted >>"$here/calls"' INT
  sh -c 'trap "exit 1" INT TERM; i=0; while [ $i -lt 30 ]; do sleep 0.1; i=$((i + 1)); done; echo dpkg >"{ended}"'
esac
""")
        for word in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            for path in (ended, os.path.join(machine.folder, "installed"), os.path.join(machine.folder, "calls")):
                if os.path.exists(path):
                    os.remove(path)
            with subprocess.Popen([os.path.join(place, "run"), "setup", "tools"], env=environment(machine), stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
                deadline = time.monotonic() + LIMIT
                while not machine.installs() and time.monotonic() < deadline:
                    time.sleep(0.05)
                time.sleep(0.5)
                process.send_signal(word)
                said, _ = process.communicate(timeout=LIMIT)
            self.assertGreater(process.returncode, 128, said)
            self.assertIn("lets dpkg finish its step", said)
            self.assertTrue(os.path.exists(ended), "dpkg was stopped in the middle of its step")
            self.assertIn("interrupted", machine.text("calls"))


class Configuration(unittest.TestCase):
    def test_packages_that_came_by_another_way_are_found(self):
        """The folder is configured again when a package of packages.apt has come, gone or changed, and not otherwise."""
        script = """ROOT=$1 BUILD=$2/build CALLER=$1 LOGS=$2/log CALLER_PATH=$2/bin:$PATH; PATH=$CALLER_PATH; cd "$ROOT"
            for part in progress packages first_cost build; do . "$ROOT/launch/verbs/parts/$part.sh"; done
            configure_and_build build "$ROOT" "$BUILD" all"""
        with tempfile.TemporaryDirectory() as folder:
            os.makedirs(os.path.join(folder, "bin"))
            listed = os.path.join(folder, "listed")
            for name, text in (("dpkg-query", f"cat '{listed}'"), ("ninja", "exit 0"),
                               ("cmake", f"echo x >>'{folder}/configured'; mkdir -p '{folder}/build'; touch '{folder}/build/build.ninja'")):
                path = os.path.join(folder, "bin", name)
                with open(path, "w", encoding="utf-8") as out:
                    out.write("#!/bin/sh\n" + text + "\n")
                os.chmod(path, 0o755)
            times = []
            for packages in ("g++ 1", "g++ 1", "g++ 1\nqtbase5-dev 5\nqt6-base-dev 6", "g++ 1\nqtbase5-dev 5\nqt6-base-dev 6", "g++ 2",
                             "g++ 2\nunrelated 1"):
                with open(listed, "w", encoding="utf-8") as out:
                    out.write("".join(f"installed {each} \n" for each in packages.splitlines()))
                subprocess.run(["sh", "-uc", script, "sh", ROOT, folder], capture_output=True, text=True, check=True, timeout=60)
                with open(os.path.join(folder, "configured"), encoding="utf-8") as file:
                    times.append(len(file.readlines()))
            self.assertEqual(times, [1, 1, 2, 2, 3, 3])

    @unittest.skipUnless(shutil.which("ccache") and shutil.which("g++"), "needs ccache and g++")
    def test_a_first_build_preprocesses_nothing_twice(self):
        """ccache runs the preprocessor to look for what it may have: not in an empty cache, and what went in there is found from another folder."""
        with tempfile.TemporaryDirectory() as folder:
            compiler = os.path.join(folder, "g++")
            with open(compiler, "w", encoding="utf-8") as out:
                out.write(f"#!/bin/sh\necho \"$*\" >>'{folder}/compiled'\nexec {shutil.which('g++')} \"$@\"\n")
            os.chmod(compiler, 0o755)
            script = """ROOT=$1 BUILD=$2/build CALLER=$1 LOGS=$2/log; . "$ROOT/launch/verbs/parts/build.sh"
                CCACHE_BASEDIR=$3
                forget_other_workspaces
                cd "$3" && ccache "$4" -O1 -MD -MF a.d -o a.o -c "$3/a.cpp" """
            counts = []
            for name, source in (("one", "int f() { return 1; }"), ("two", "int f() { return 1; }"), ("three", "int f() { return 3; }")):
                place = os.path.join(folder, name)
                os.makedirs(place)
                with open(os.path.join(place, "a.cpp"), "w", encoding="utf-8") as out:
                    out.write(source + "\n")
                kept = {key: value for key, value in os.environ.items() if not key.startswith("CCACHE_")}
                subprocess.run(["sh", "-uc", script, "sh", ROOT, folder, place, compiler], check=True, timeout=60,
                               env={**kept, "CCACHE_DIR": os.path.join(folder, "cache")})
                self.assertTrue(os.path.exists(os.path.join(place, "a.o")))
                with open(os.path.join(folder, "compiled"), encoding="utf-8") as file:
                    words = [line.split() for line in file]
                counts.append((len(words), sum("-E" in each for each in words)))
            self.assertEqual(counts, [(1, 0), (1, 0), (3, 1)])


if __name__ == "__main__":
    unittest.main()
