"""The tutorials, in the order of their numbers, and their blocks: those with `file` are written, those of `sh` are called."""
import glob
import os
import re

PAGES = sorted(glob.glob(os.path.join(os.path.dirname(__file__), "..", "..", "launch", "doc", "tutorials", "[0-9]_*.md")))
_BLOCK = re.compile(r"^```(?P<language>\w+)(?: file=(?P<file>\S+))?\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks_of(page):
    with open(page, encoding="utf-8") as text:
        return list(_BLOCK.finditer(text.read()))
