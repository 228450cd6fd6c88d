#!/usr/bin/python3
"""Every public symbol of C++ has a word, and Doxygen understands every comment and page."""
import os
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "launch", "doc", "site"))

import header
import undocumented

HEADER = """/// What this header is about.
#pragma once
namespace haptic {
/// A pair.
struct Pair {
  int a, b;  ///< two numbers
  enum class Kind { kOne, kTwo } kind = Kind::kOne;
};
}  // namespace haptic
"""


class Documented(unittest.TestCase):
    def test_sources(self):
        found = undocumented.read_sources()
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_silent_symbols_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "pair.h")
            with open(path, "w", encoding="utf-8") as out:
                out.write(HEADER)
            silent = undocumented.read_sources(f"INPUT={folder}\nUSE_MDFILE_AS_MAINPAGE=")
        self.assertEqual([line.partition(": warning: ")[2] for line in silent],
                         ["Member Kind (enumeration) of struct haptic::Pair is not documented.",
                          "Member kind (variable) of struct haptic::Pair is not documented."])
        self.assertTrue(all(line.startswith(f"{path}:7:") for line in silent), silent)

    def test_comments_are_given_to_what_they_are_about(self):
        read = list(header.as_doxygen_reads(HEADER + "  /// Of <inertial> alone.\n  int x;\n"))
        self.assertEqual(read[0], "/// \\file\n/// What this header is about.")
        self.assertIn("  /** two numbers */ int a; /** two numbers */ int b;", read)
        self.assertIn("  /// Of \\<inertial> alone.", read)


if __name__ == "__main__":
    unittest.main()
