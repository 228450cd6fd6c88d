#!/usr/bin/python3
"""A page as Doxygen has to read it: `launch/doc/site/page.py FILE` prints it.

What a README.md links to below its own folder, and not below `doc`, stands below it in the tree of pages, in that order. The
first page of the repository leads everywhere, and is no parent.
"""
import os
import re
import sys

LINK = re.compile(r"\[([^\]]*)\]\((?!doc/)([\w/]+)\.md\)")


def as_doxygen_reads(path, text):
    folder = os.path.dirname(os.path.relpath(path))
    if not folder or os.path.basename(path) != "README.md":
        return text

    def subpage(match):
        page = "md_" + os.path.join(folder, match.group(2)).replace(os.sep, "_")
        return f'\\subpage {page} "{match.group(1)}"'
    return LINK.sub(subpage, text)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        sys.stdout.write(as_doxygen_reads(sys.argv[1], file.read()))


if __name__ == "__main__":
    main()
