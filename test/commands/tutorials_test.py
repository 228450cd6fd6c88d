#!/usr/bin/python3
"""Each block of each tutorial, run as it stands on a machine on which nothing is installed yet: files are written, shell blocks must
end with exit code 0."""
import os
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


class Tutorials(unittest.TestCase):
    def run_page(self, page):
        blocks = blocks_of(page)
        self.assertTrue(any(b["language"] == "sh" for b in blocks), page)
        marker = f"HAPTIC_TEST_CALL={os.getpid()}-{os.path.basename(page)}"
        environment = dict(os.environ, HAPTIC_TEST_CALL=marker.split("=")[1], ROS_IP="127.0.0.1",
                           ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}")
        environment.pop("DISPLAY", None)
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as holder:
            machine = BareMachine(holder)
            environment.update(machine.environment)
            # The reader stands in the repository; here its folder is left clean.
            with open(os.path.join(folder, "run"), "w", encoding="utf-8") as run:
                run.write(f'#!/bin/sh\nexec "{ROOT}/run" "$@"\n')
            os.chmod(os.path.join(folder, "run"), 0o755)
            os.symlink(os.path.join(ROOT, "build"), os.path.join(folder, "build"))
            for block in blocks:
                if block["file"]:
                    with open(os.path.join(folder, block["file"]), "w", encoding="utf-8") as out:
                        out.write(block["text"])
                elif block["language"] == "sh":
                    done = subprocess.run(["sh", "-e", "-c", block["text"]], cwd=folder, env=environment, timeout=LIMIT,
                                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
                    self.assertEqual(done.returncode, 0, f"{page}:\n{block['text']}\n{done.stdout[-3000:]}")
                    self.check_said(block["text"], done.stdout)
            calls = any("./run " in block["text"] for block in blocks if block["language"] == "sh")  # pages 5 and 6 go on from others
            self.assertEqual(len(machine.installs()), 1 if calls else 0, f"{page}: set-up was not what a first reader meets")
            self.assertFalse(os.path.exists(machine.reached), "the real apt-get was called")
        self.assertEqual(descendants(marker), [], f"{page} leaves processes")

    def check_said(self, block, output):
        if "./run demo" in block:
            self.assertIn("figure demo.contact_force_n_max", output)
        if "./run replay" in block:
            self.assertRegex(output, r"figure replay\.mismatches 0 ")
        if "rostopic echo" in block:
            self.assertIn("force:", output)


def add(page):
    name = "test_" + os.path.basename(page)[:-3]
    setattr(Tutorials, name, lambda self: self.run_page(page))


for each in PAGES:
    add(each)

if __name__ == "__main__":
    unittest.main()
