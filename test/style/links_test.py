#!/usr/bin/python3
"""No link of the documentation leads nowhere, neither to a file nor to a heading."""
import os
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "launch", "doc", "site"))

import links


class Links(unittest.TestCase):
    def test_documentation(self):
        self.assertEqual(list(links.dead_in_markdown(ROOT)), [])

    def test_dead_ones_are_found(self):
        with tempfile.TemporaryDirectory() as root:
            with open(os.path.join(root, "a.md"), "w", encoding="utf-8") as out:
                out.write("# Here and there\n[a](b.md) [c](#here-and-there) [d](#nowhere) [e](https://example.org)\n```\n[f](g)\n```\n")
            with open(os.path.join(root, "a.html"), "w", encoding="utf-8") as out:
                out.write('<a href="b.html">b</a> <h1 id="x"></h1> <a href="a.html#x">c</a> <a href="a.html#y">d</a>')
            self.assertEqual(list(links.dead_in_markdown(root)), ["a.md: b.md", "a.md: #nowhere: no such heading"])
            self.assertEqual(list(links.dead_in_site(root)), ["a.html: b.html", "a.html: a.html#y: no such place"])


if __name__ == "__main__":
    unittest.main()
