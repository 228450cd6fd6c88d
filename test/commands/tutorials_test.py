#!/usr/bin/python3
"""Each block of each tutorial, in their order, run as it stands on a machine on which nothing is installed yet: files are written, shell
blocks must end with exit code 0, and what Python imports comes with packages that a call before it has asked for."""
import ast
import importlib.util
import os
import re
import socket
import subprocess
import tempfile
import unittest

from bare_machine import BareMachine
from run_verb import ROOT, descendants
from tutorial_pages import PAGES, blocks_of

LIMIT = 240  # [s] for a block


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def packages_with_names():
    """Every name in packages.apt."""
    with open(os.path.join(ROOT, "packages.apt"), encoding="utf-8") as file:
        return {name for line in file if not line.startswith("#") for name in line.split() if not name.endswith(":")}


def brought_by(packages):
    """Packages and all that they depend on."""
    listed = subprocess.run(["apt-cache", "--recurse", "--important", "--installed", "depends", *sorted(packages)], stdout=subprocess.PIPE,
                            stderr=subprocess.DEVNULL, text=True, check=False).stdout
    return set(re.findall(r"([a-z0-9][a-z0-9.+-]+)(?::\w+)?$", listed, re.MULTILINE))


def package_of(module):
    """The Debian package of a Python module; that of the build's own needs pybind11. None: Python itself has it."""
    if module == "haptic":
        return "pybind11-dev"
    found = importlib.util.find_spec(module)
    if not found or not found.origin or "-packages" not in found.origin:
        return None
    listed = subprocess.run(["dpkg", "-S", found.origin], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False).stdout
    return listed.split(":")[0] or None


def imports_of(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (name.name.split(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module.split(".")[0]


class Tutorials(unittest.TestCase):
    def test_in_the_order_of_their_numbers(self):
        asked = set()
        for page in PAGES:
            with self.subTest(page=os.path.basename(page)):
                self.run_page(page, asked)

    def run_page(self, page, asked):
        blocks = blocks_of(page)
        self.assertTrue(any(b["language"] == "sh" for b in blocks), page)
        marker = f"HAPTIC_TEST_CALL={os.getpid()}-{os.path.basename(page)}"
        environment = dict(os.environ, HAPTIC_TEST_CALL=marker.split("=")[1], ROS_IP="127.0.0.1",
                           ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}")
        environment.pop("DISPLAY", None)
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as holder:
            machine = BareMachine(holder, installed=bool(asked))
            environment.update(machine.environment)
            # The reader stands in the repository; here its folder is left clean.
            with open(os.path.join(folder, "run"), "w", encoding="utf-8") as run:
                run.write(f'#!/bin/sh\nexec "{ROOT}/run" "$@"\n')
            os.chmod(os.path.join(folder, "run"), 0o755)
            os.symlink(os.path.join(ROOT, "build"), os.path.join(folder, "build"))
            installed = 0
            for block in blocks:
                if block["file"]:
                    with open(os.path.join(folder, block["file"]), "w", encoding="utf-8") as out:
                        out.write(block["text"])
                elif block["language"] == "sh":
                    machine.remove(packages_with_names() - asked)
                    done = subprocess.run(["sh", "-e", "-c", block["text"]], cwd=folder, env=environment, timeout=LIMIT,
                                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
                    self.assertEqual(done.returncode, 0, f"{page}:\n{block['text']}\n{done.stdout[-3000:]}")
                    self.check_said(block["text"], done.stdout)
                    for line in machine.installs()[installed:]:
                        names = set(line.split()) & packages_with_names()
                        self.assertTrue(names - asked, f"{page}: installs once more what a call before has asked for: {line}")
                        asked |= names
                    installed = len(machine.installs())
                    self.check_imports(page, block["text"], folder, asked)
            self.assertTrue(asked, f"{page}: set-up was not what a first reader meets")
            self.assertFalse(os.path.exists(machine.reached), "the real apt-get was called")
        self.assertEqual(descendants(marker), [], f"{page} leaves processes")

    def check_imports(self, page, block, folder, asked):
        """The modules that a block's Python programs import came with a call of this page or of one before."""
        texts = re.findall(r"python3 -c '([^']*)'", block)
        for name in re.findall(r"python3 (\w+\.py)", block):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                texts.append(file.read())
        needed = {(module, package_of(module)) for text in texts for module in imports_of(text)}
        here = brought_by(asked) | asked if needed else set()
        missing = [f"{module} ({package})" for module, package in needed if package and package not in here]
        self.assertEqual(missing, [], f"{page}: imported, and no call of ./run before has installed them:\n{block}")

    def check_said(self, block, output):
        if "./run demo" in block:
            self.assertIn("figure demo.contact_force_n_max", output)
        if "./run replay" in block:
            self.assertRegex(output, r"figure replay\.mismatches 0 ")
        if "rostopic echo" in block:
            self.assertIn("force:", output)


if __name__ == "__main__":
    unittest.main()
