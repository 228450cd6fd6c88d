#!/usr/bin/python3
"""What a reader may rely on in every source file, as far as a program can see it."""
import os
import re
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CODE = (".h", ".hpp", ".cpp", ".cc")
TEXT = CODE + (".py", ".sh", ".md", ".txt", ".cmake", ".launch", ".urdf", ".xml", ".yaml", ".msg", ".srv", ".test")
SKIPPED = {".git", "build", "log", "install", "__pycache__"}
# A file this long is split by noun or algorithm; the habit is 400 lines, the rest is room for one that would only
# hide something when split.
MAX_LINES = 600
MAX_COLUMNS = 140
LEFT_OVER = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X|HA" r"CK)\b")
VAGUE_NAME = re.compile(r"(^|_)(utils?|common|manager|helpers?|misc)(_|\.|$)")
# A line comment that ends like a statement is code that was switched off.
DEAD_CODE = re.compile(r"^\s*//(?!/)\s*(\w[\w.\->\[\]]*\s*=\s*[^.]*|\w[\w.:\->]*\([^.]*\)|return\b.*|#\s*include.*);\s*$")


def files(root, suffixes):
    for path, folders, names in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in SKIPPED)
        for name in sorted(names):
            if name.endswith(suffixes):
                yield os.path.join(path, name)


def lines(path):
    with open(path, encoding="utf-8") as text:
        return text.read().split("\n")


def violations(root):
    for path in files(root, TEXT):
        place = os.path.relpath(path, root)
        if VAGUE_NAME.search(os.path.basename(path)):
            yield f"{place}: name the file for the one noun or algorithm in it"
        content = lines(path)
        for number, line in enumerate(content, 1):
            if LEFT_OVER.search(line):
                yield f"{place}:{number}: finish it or take it out: {line.strip()}"
            if "\t" in line and not path.endswith((".md", ".txt")):
                yield f"{place}:{number}: tab"
    for path in files(root, CODE):
        place = os.path.relpath(path, root)
        content = lines(path)
        if len(content) > MAX_LINES:
            yield f"{place}: {len(content)} lines; split it by noun or algorithm (limit {MAX_LINES})"
        if path.endswith((".h", ".hpp")) and not any("#pragma once" in line for line in content):
            yield f"{place}: no #pragma once"
        for number, line in enumerate(content, 1):
            if len(line) > MAX_COLUMNS:
                yield f"{place}:{number}: {len(line)} columns (limit {MAX_COLUMNS})"
            if DEAD_CODE.match(line):
                yield f"{place}:{number}: code in a comment: {line.strip()}"
            if line.rstrip() != line:
                yield f"{place}:{number}: space at the end of the line"


class Style(unittest.TestCase):
    def test_sources(self):
        self.assertTrue(list(files(ROOT, CODE)), "no sources found")
        found = list(violations(ROOT))
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_shell_scripts_parse(self):
        scripts = [os.path.join(ROOT, "run"), os.path.join(ROOT, ".ci", "run")]
        for script in scripts + list(files(ROOT, (".sh",))):
            self.assertEqual(subprocess.run(["sh", "-n", script], check=False).returncode, 0, script)

    def test_each_rule_can_fail(self):
        bad = {
            "a.h": "int a;\n",                                   # no pragma
            "string_utils.h": "#pragma once\n",                  # vague name
            "b.cpp": "// TO" "DO later\n",
            "c.cpp": "// x = compute(y);\n",
            "d.cpp": "int a;" + " " * 3 + "\n",
            "e.cpp": "int a;\n" * (MAX_LINES + 1),
            "f.cpp": "/" * (MAX_COLUMNS + 1) + "\n",
            "g.cpp": "\tint a;\n",
        }
        for name, text in bad.items():
            with tempfile.TemporaryDirectory() as root:
                with open(os.path.join(root, name), "w", encoding="utf-8") as out:
                    out.write(text)
                self.assertEqual(len(list(violations(root))), 1, name)


if __name__ == "__main__":
    unittest.main()
