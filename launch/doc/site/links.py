#!/usr/bin/python3
"""Links that lead nowhere: in the Markdown of the repository, and in a site that was made of it.

    launch/doc/site/links.py [HTML_FOLDER]     prints each, then `figure docs.dead_links N 1`; exit code 1 when there are some
    launch/doc/site/links.py --complete HTML_FOLDER    brings files that the site links to into it

Links to other sites are not followed: a test must not depend on them.
"""
import os
import re
import shutil
import sys
import urllib.parse

from page import page_name

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
SKIPPED = {".git", "build", "log", "install"}
LINK = re.compile(r"\[[^\]\[]*\]\(([^)\s]+)\)")
HREF = re.compile(r"""<(?:a|img|link|script)\b[^>]*?\b(?:href|src)=["']([^"']+)["']""")
IDENTITY = re.compile(r"""\b(?:id|name)=["']([^"']+)["']""")


def outside(target):
    return re.match(r"[a-z]+:|//", target) is not None


def read(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def anchors(markdown):
    """Names of headings as GitHub makes them."""
    plain = re.sub(r"^```.*?^```", "", markdown, flags=re.M | re.S)
    for heading in re.findall(r"^#+ (.*)$", plain, re.M):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        yield re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", words).strip())


def files(root, ending):
    for path, folders, names in os.walk(root):
        folders[:] = [f for f in folders if f not in SKIPPED]
        yield from (os.path.join(path, name) for name in sorted(names) if name.endswith(ending))


def dead_in_markdown(root):
    for path in files(root, ".md"):
        text = re.sub(r"^```.*?^```", "", read(path), flags=re.M | re.S)
        for target in LINK.findall(text):
            if outside(target):
                continue
            file, _, anchor = target.partition("#")
            there = os.path.normpath(os.path.join(os.path.dirname(path), urllib.parse.unquote(file))) if file else path
            if not os.path.exists(there):
                yield f"{os.path.relpath(path, root)}: {target}"
            elif anchor and there.endswith(".md") and anchor not in set(anchors(read(there))):
                yield f"{os.path.relpath(path, root)}: {target}: no such heading"


def dead_in_site(folder):
    known = {}
    for path in files(folder, ".html"):
        for target in HREF.findall(read(path)):
            if outside(target) or target.startswith("javascript"):
                continue
            file, _, anchor = urllib.parse.unquote(target).partition("#")
            there = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
            if not os.path.exists(there):
                yield f"{os.path.relpath(path, folder)}: {target}"
            elif anchor and there.endswith(".html"):
                if there not in known:
                    known[there] = set(IDENTITY.findall(read(there)))
                if anchor not in known[there]:
                    yield f"{os.path.relpath(path, folder)}: {target}: no such place"


def html_page(markdown):
    """Of a Markdown file of the repository in the site."""
    place = os.path.relpath(markdown, ROOT)
    return "index.html" if place == "README.md" else page_name(place) + ".html"


def header_page(source):
    """Of a header in the site, by Doxygen's spelling of names."""
    return os.path.basename(source).replace("_", "__").replace(".", "_8") + ".html"


def complete(folder):
    """Pages keep the links of the repository: what they name there, such as a table or a source, comes into the site."""
    sources = {html_page(path): path for path in files(ROOT, ".md")}
    for page in files(folder, ".html"):
        beside = os.path.dirname(sources.get(os.path.basename(page), os.path.join(ROOT, "README.md")))

        def lead(match):
            target = match.group(1)
            file = urllib.parse.unquote(target.partition("#")[0])
            if outside(target) or not file or os.path.exists(os.path.join(folder, file)):
                return match.group(0)
            source = os.path.normpath(os.path.join(beside, file))
            if not source.startswith(ROOT + os.sep) or not os.path.exists(source):
                return match.group(0)
            here = html_page(source) if source.endswith(".md") else os.path.relpath(source, ROOT)
            if os.path.exists(os.path.join(folder, header_page(source))):
                here = header_page(source)
            there = os.path.join(folder, here)
            if not os.path.exists(there):
                os.makedirs(os.path.dirname(there), exist_ok=True)
                (shutil.copytree if os.path.isdir(source) else shutil.copy)(source, there)
            return match.group(0).replace(target, here)
        text = before = read(page)
        # Doxygen lists nested classes in the head of pages that have none to show.
        if "#nested-classes" in text and "nested-classes" not in IDENTITY.findall(text):
            text = re.sub(r'<a href="#nested-classes">[^<]*</a>( &#124;\n)?', "", text)
        text = HREF.sub(lead, text)
        if text != before:
            with open(page, "w", encoding="utf-8") as out:
                out.write(text)


def main():
    if sys.argv[1:2] == ["--complete"]:
        return complete(os.path.abspath(sys.argv[2]))
    dead = list(dead_in_markdown(ROOT))
    for folder in sys.argv[1:]:
        dead += dead_in_site(folder)
    for line in sorted(set(dead)):
        print("dead link:", line)
    print(f"figure docs.dead_links {len(set(dead))} 1")
    return sys.exit(1 if dead else 0)


if __name__ == "__main__":
    main()
