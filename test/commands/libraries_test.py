#!/usr/bin/python3
"""The core's two libraries: one interface, each with the instructions of its processors, and the loader's choice between them."""
import os
import re
import subprocess
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FOLDER = os.path.join(ROOT, "build", "devel", "lib")
BASELINE = os.path.join(FOLDER, "libhaptic_core.so")
V3 = os.path.join(FOLDER, "glibc-hwcaps", "x86-64-v3", "libhaptic_core.so")
PROGRAM = os.path.join(FOLDER, "spidar_driver", "device_check")  # tells which library it uses


def said(*command, **environment):
    kept = {key: value for key, value in os.environ.items() if key not in ("LD_LIBRARY_PATH", "GLIBC_TUNABLES")}
    return subprocess.run(command, env={**kept, **environment}, capture_output=True, text=True, check=True).stdout


def symbols(library, kinds):
    lines = said("nm", "-D", "-C", "--defined-only", library).splitlines()
    return {line.split(" ", 2)[2] for line in lines if line.split(" ", 2)[1] in kinds}


def processor_has_v3():
    """By the loader's own word: /proc/cpuinfo of virtual machines leaves flags out that the processor has."""
    done = subprocess.run(["/lib64/ld-linux-x86-64.so.2", "--help"], capture_output=True, text=True, check=True)
    return "x86-64-v3 (supported, searched)" in done.stdout


@unittest.skipUnless(os.path.exists(V3), "only on x86-64")
class Libraries(unittest.TestCase):
    def test_both_have_the_same_interface(self):
        ours = symbols(BASELINE, "TDRB")
        self.assertGreater(len(ours), 500)
        self.assertEqual(ours ^ symbols(V3, "TDRB"), set())

    def test_no_inline_function_of_ours_is_shared(self):
        """A program compiled for another processor has its own copies; neither side may take the other's."""
        for library in (BASELINE, V3):
            shared = {name for name in symbols(library, "W") if re.match(r"haptic::[\w:]+\(", name)}
            self.assertEqual(shared, set(), library)

    def test_each_has_the_instructions_of_its_processors(self):
        for library, wide in ((BASELINE, False), (V3, True)):
            code = said("objdump", "-d", "--no-show-raw-insn", library)
            self.assertEqual("%ymm" in code, wide, library)
            self.assertNotRegex(code, r"\tvfn?m(add|sub)", library)

    def test_the_loader_chooses(self):
        masked = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2"}
        self.assertIn("library baseline", said(PROGRAM, "--version", **masked))
        self.assertIn("library " + ("x86-64-v3" if processor_has_v3() else "baseline"), said(PROGRAM, "--version"))
        self.assertIn("library baseline", said(PROGRAM, "--version", LD_LIBRARY_PATH=FOLDER, **masked))
        if processor_has_v3():
            self.assertIn("library x86-64-v3", said(PROGRAM, "--version", LD_LIBRARY_PATH=os.path.dirname(V3)))


if __name__ == "__main__":
    unittest.main()
