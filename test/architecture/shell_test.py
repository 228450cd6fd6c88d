#!/usr/bin/python3
"""Shell functions share their variables. Each name that one program of launch/verbs may assign has one owner, and shellcheck is silent."""
import functools
import glob
import os
import re
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
VERBS = os.path.join(ROOT, "launch", "verbs")
START = os.path.join(VERBS, "parts", "start.sh")
PARTS = sorted(set(glob.glob(os.path.join(VERBS, "parts", "*.sh"))) - {START})
SHELL = re.compile(rb"#! ?/(bin|usr/bin)/(env )?(sh|bash|dash)\b")
# Names that several files assign on purpose: what a verb tells the parts, and what the shell and programs read.
SHARED = {"SETUP_BUILDS", "INTERRUPT", "GENTLE", "HELD", "KEEPER", "CHILDREN", "IFS", "PATH", "ROS_MASTER_URI", "ROS_IP", "ROS_HOME", "LOGS",
          "HAPTIC_VERSION", "NODE_PATH", "CCACHE_BASEDIR", "CCACHE_NOHASHDIR", "CCACHE_DIR", "CMAKE_C_COMPILER_LAUNCHER",
          "CMAKE_CXX_COMPILER_LAUNCHER", "LC_ALL", "DEBIAN_FRONTEND"}
# Names that functions of one verb hand to each other.
HANDED = {"bench.sh": {"failed"}, "demo.sh": {"scene_file", "port", "wire", "at_home"}, "check.sh": {"device_file"}}


def unquoted(text):
    """The text without comments and single-quoted strings: what they hold is not run by this shell. Lines stay lines."""
    out, i, double, word = [], 0, False, False
    while i < len(text):
        c = text[i]
        if c == "\\":
            out.append("  ")
            i += 2
            word = True
            continue
        if c == '"':
            double = not double
        elif c == "'" and not double:
            end = text.index("'", i + 1)
            out.append("'" + "\n" * text.count("\n", i, end) + "'")
            i, word = end + 1, True
            continue
        elif c == "#" and not word and not double:
            i = text.find("\n", i)
            if i < 0:
                break
            continue
        out.append(c)
        word = not c.isspace() and c not in ";|&("
        i += 1
    return "".join(out)


def functions(text):
    """Name and text of each function, and last ('', the rest)."""
    rest, out = [], []
    lines = iter(text.split("\n"))
    for line in lines:
        opened = re.match(r"(\w+)\(\) \{(.*)$", line)
        if not opened:
            rest.append(line)
            continue
        body = [opened.group(2)]
        if not re.search(r"\}\s*$", line):
            for inner in lines:
                if inner.startswith("}"):
                    break
                body.append(inner)
        out.append((opened.group(1), "\n".join(body)))
    return out + [("", "\n".join(rest))]


def assigned(text):
    """Names that stand before = where a command or its assignments begin, or after for, read and eval; and those that are local."""
    local = {name for names in re.findall(r"\blocal ([\w ]+)", text) for name in names.split()}
    text = re.sub(r" -v \w+=", " ", text)  # awk's
    text = re.sub(r"\benv( \w+=\S*)+", "env", text)  # another program's
    text = re.sub(r"\bjudge( \S+| \\\n)+? --", "judge", text)  # kinds of options
    names = set(re.findall(r"(?:^|[\s;&|({`])([A-Za-z_]\w*)=(?!=)", text))
    names |= set(re.findall(r"\bfor ([A-Za-z_]\w*)(?= in\b|; do\b)", text))
    names |= {name for words in re.findall(r"\bread -r ([\w ]+)", text) for name in words.split()}
    return names - local, local


@functools.lru_cache
def owners(path):
    """Name -> places of this file that assign it so that others see it."""
    with open(path, encoding="utf-8") as file:
        text = unquoted(file.read())
    out = {}
    for function, body in functions(text):
        for name in assigned(body)[0]:
            out.setdefault(name, []).append(function)
    return out


def collisions(verb, parts):
    """Names that two files assign, or two functions of one verb."""
    seen = {}
    for path in parts + [verb]:
        for name, places in owners(path).items():
            if name in SHARED:
                continue
            here = os.path.basename(path)
            if path == verb:
                inside = [place for place in places if place]
                if name not in HANDED.get(here, ()) and (len(inside) > 1 or (inside and "" in places)):
                    yield f"{here}: {name} is assigned by {' and '.join(place or 'the program' for place in places)}"
            if name in seen:
                yield f"{name} is assigned by {seen[name]} and by {here}: make it local, or name it for its part"
            seen[name] = here


def scripts():
    listed = subprocess.run(["git", "-c", "safe.directory=*", "-C", ROOT, "ls-files"], capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        path = os.path.join(ROOT, name)
        if os.path.isfile(path):
            with open(path, "rb") as file:
                if SHELL.match(file.read(64)):
                    yield path


class Shell(unittest.TestCase):
    def test_no_name_leaks(self):
        verbs = sorted(glob.glob(os.path.join(VERBS, "*.sh")))
        self.assertGreater(len(verbs), 10)
        for verb in verbs:
            with self.subTest(os.path.basename(verb)):
                self.assertEqual(list(collisions(verb, PARTS + [START])), [])

    def test_shellcheck_is_silent(self):
        found = list(scripts())
        self.assertGreater(len(found), 15)
        checked = subprocess.run(["shellcheck", "--format", "gcc", *found], cwd=ROOT, capture_output=True, text=True, check=False)
        self.assertEqual((checked.returncode, checked.stdout), (0, ""), checked.stdout + checked.stderr)

    def test_each_leak_is_found(self):
        leaks = {
            "x() {\n  kept=1\n}\nkept=2\n": "kept",                               # in a function and in the program
            "x() {\n  kept=1\n}\ny() {\n  read -r kept\n}\n": "kept",             # in two functions
            "part_name=1\n": "part_name",                                         # in a part and in the verb
            "for part_name in a b; do :; done\n": "part_name",
        }
        sound = ["x() {\n  local kept\n  kept=1\n}\nkept=2\n", "x() {\n  sh -c 'part_name=1'\n}\n", "# part_name=1\n", "echo --part_name=1\n"]
        with tempfile.TemporaryDirectory() as folder:
            part, verb = os.path.join(folder, "part.sh"), os.path.join(folder, "verb.sh")
            with open(part, "w", encoding="utf-8") as file:
                file.write("f() {\n  part_name=1\n}\n")
            for text, name in list(leaks.items()) + [(text, None) for text in sound]:
                with open(verb, "w", encoding="utf-8") as file:
                    file.write(text)
                owners.cache_clear()
                found = list(collisions(verb, [part]))
                self.assertEqual(len(found), 1 if name else 0, (text, found))
                self.assertTrue(all(name in line for line in found), found)


if __name__ == "__main__":
    unittest.main()
