#!/usr/bin/python3
"""A page as Doxygen has to read it: `launch/doc/site/page.py FILE` prints it.

What a README.md links to below its own folder, and not below `doc`, stands below it in the tree of pages, in that order. The
first page of the repository leads everywhere, and is no parent. A comment <!-- site: ... --> is text of the site alone.
"""
import os
import re
import subprocess
import sys

SITE_ALONE = re.compile(r"<!-- site: (.*?) -->")  # what only the site has, such as a link to a page that is made with it
LINKED_PICTURE = re.compile(r"\[!\[([^\]]*)\]\(([^)\s]+)\)\]\(([^)\s]+)\)")  # which Doxygen shows as text where it is a WebP
PICTURE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)\)")  # whose alternative text Doxygen drops
LINK = re.compile(r"\[([^\]]*)\]\((?!doc/)([\w/]+)\.md\)")


def page_name(place):
    """Doxygen's name of the page of a Markdown file: since 1.9.8 (Debian 13) by its rules for file names, before (Debian 12) simpler."""
    version = subprocess.run(["doxygen", "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    name = os.path.splitext(place)[0]
    if [int(number) for number in re.findall(r"\d+", version)[:3]] < [1, 9, 8]:
        return "md_" + name.replace(os.sep, "_")
    return "md_" + name.replace("_", "__").replace(os.sep, "_2")


def image(found):
    """As HTML, in one line: Doxygen shows the text of its own pictures below them, or not at all."""
    told = " ".join(found.group(1).split()).replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return f'<img src="{found.group(2)}" alt="{told}"/>'


def as_doxygen_reads(path, text):
    text = SITE_ALONE.sub(r"\1", text)
    text = LINKED_PICTURE.sub(lambda found: f'<a href="{found.group(3)}">{image(found)}</a>', text)
    text = PICTURE.sub(image, text)
    folder = os.path.dirname(os.path.relpath(path))
    if not folder or os.path.basename(path) != "README.md":
        return text

    def subpage(match):
        page = page_name(os.path.join(folder, match.group(2)))
        return f'\\subpage {page} "{match.group(1)}"'
    return LINK.sub(subpage, text)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        sys.stdout.write(as_doxygen_reads(sys.argv[1], file.read()))


if __name__ == "__main__":
    main()
