#!/usr/bin/python3
"""The site's search finds pages by their words, and its pictures keep what is said of them."""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SITE = os.path.join(ROOT, "launch", "doc", "site")
sys.path.insert(0, SITE)

import page
import search_pages

PAGE = ('<html><head><title>SPIDAR haptics: {title}</title><script src="search/search.js"></script></head><body><div class="contents">'
        '<div class="textblock"><h1>{title}</h1><p>{text}</p></div></div></body></html>')


class SiteSearch(unittest.TestCase):
    def test_pages_are_found_by_their_words_the_best_first(self):
        pages = {"index.html": ("First", "A device, once a study."), "md_a.html": ("A study", "Trials and a staircase, study by study."),
                 "classA.html": ("A class", "study study study")}
        with tempfile.TemporaryDirectory() as folder:
            for name, (title, text) in pages.items():
                with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                    file.write(PAGE.format(title=title, text=text).replace("textblock", "textblock" if name != "classA.html" else "memitem"))
            said = subprocess.run([sys.executable, "-B", os.path.join(SITE, "search_pages.py"), folder], capture_output=True, text=True, check=True)
            self.assertRegex(said.stdout, r"figure docs\.search_found \d+ of_20")
            with open(os.path.join(folder, "search_pages.js"), encoding="utf-8") as file:
                script = file.read()
            words = json.loads(re.search(r"WORDS = (\{.*?\});\n", script).group(1))
            listed = json.loads(re.search(r"PAGES = (\[.*?\]), WORDS", script).group(1))
            self.assertEqual([listed[number][0] for number, _ in words["study"]], ["md_a.html", "index.html"])
            self.assertEqual([listed[number][1] for number, _ in words["staircase"]], ["A study"])
            for name in pages:
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    self.assertIn('<script src="search_pages.js">', file.read())

    def test_pictures_keep_their_words(self):
        read = page.as_doxygen_reads(os.path.join(ROOT, "README.md"), 'Text ![A "grip" on\nstrings](a/b.png) and [![moving](c.webp)](d.md)')
        self.assertIn('<img src="a/b.png" alt="A &quot;grip&quot; on strings"/>', read)
        self.assertIn('<a href="d.md"><img src="c.webp" alt="moving"/></a>', read)


if __name__ == "__main__":
    unittest.main()
