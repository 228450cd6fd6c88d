#!/usr/bin/python3
"""Search over the pages of the site, beside Doxygen's own, which knows identifiers alone: search_pages.py HTML_FOLDER.

Each word of a page counts once per place, ten times in its title and four times in a heading. The index and the box that shows it are one file,
search_pages.js, which every page loads; it asks for nothing from outside. Prints `figure docs.search_found`.
"""
import collections
import html
import json
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
MOST_PAGES = 12   # of a word: more of a common one do not help
WORD = re.compile(r"[a-z0-9][a-z0-9_+-]*[a-z0-9]|[a-z]{2,}")
DROPPED = re.compile(r"<(script|style|svg)\b.*?</\1>|<!--.*?-->", re.S)
# Words that pages are about, and a part of the name of one that must be among the first three found.
ABOUT = {"study": "study", "mcap": "record", "foxglove": "record", "staircase": "experiments", "calibration": "spidar__driver|spidar_driver",
         "waypoint": "scene", "terrain": "scenes", "wrench_command": "wrench", "certificate": "concepts|check|analysis", "passivity": "loop|concepts",
         "security": "index", "tutorial": "tutorials|index", "emulate": "index|device|launch", "deadline": "launch|stepping|loop|index",
         "gazebo": "scenes", "moveit": "launch|penalty", "numpy": "python", "udev": "udev", "replay": "record", "psi": "experiments"}


def is_page(path, text):
    """A page for reading: not the reference of a class, file or namespace."""
    name = os.path.basename(path)
    return name == "index.html" or name.startswith(("md_", "md__")) or ('class="textblock"' in text and not re.match(r"(class|struct|namespace|dir_)", name)
                                                                      and not name.endswith("_8h.html"))


def words_of(part):
    return WORD.findall(html.unescape(re.sub(r"<[^>]+>", " ", part)).lower())


def read_page(path):
    """(title, {word: score}) or None where it is none."""
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read()
    if not is_page(path, text):
        return None
    title = re.search(r"<title>(?:[^<]*?: )?([^<]*)</title>", text)
    body = DROPPED.sub(" ", text[text.find('class="contents"'):] if 'class="contents"' in text else text)
    score = collections.Counter(words_of(body))
    for heading in re.findall(r"<h[1-4][^>]*>(.*?)</h[1-4]>", body, re.S):
        for word in words_of(heading):
            score[word] += 4
    for word in words_of(title.group(1) if title else ""):
        score[word] += 10
    return html.unescape(title.group(1)).strip() if title else os.path.basename(path), score


def index_of(folder):
    """(pages [[file, title]], {word: [[page, score]]}), the best pages of each word first."""
    pages, words = [], collections.defaultdict(list)
    for name in sorted(os.listdir(folder)):
        read = read_page(os.path.join(folder, name)) if name.endswith(".html") else None
        if not read:
            continue
        total = sum(read[1].values())
        for word, score in read[1].items():
            words[word].append([len(pages), round(100 * score / (200 + total) ** 0.5)])
        pages.append([name, read[0]])
    best = lambda found: sorted(found, key=lambda each: (-each[1], each[0]))[:MOST_PAGES]  # noqa: E731
    return pages, {word: best(found) for word, found in sorted(words.items()) if not word.isdigit()}


def found(pages, words, wanted, place):
    """Whether a page of that name is among the first three of a word."""
    hits = [pages[page][0] for each in wanted.split("|") for page, _ in words.get(each, [])[:3]]
    return any(re.search(place, name) for name in hits)


def main():
    folder = os.path.abspath(sys.argv[1])
    pages, words = index_of(folder)
    with open(os.path.join(HERE, "search_pages.js"), encoding="utf-8") as file:
        box = file.read()
    with open(os.path.join(folder, "search_pages.js"), "w", encoding="utf-8") as out:
        out.write(f"const PAGES = {json.dumps(pages, ensure_ascii=False)}, WORDS = {json.dumps(words, ensure_ascii=False, separators=(',', ':'))};\n{box}")
    for name in os.listdir(folder):
        if not name.endswith(".html"):
            continue
        with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
            text = file.read()
        if "search/search.js" in text and "search_pages.js" not in text:
            with open(os.path.join(folder, name), "w", encoding="utf-8") as out:
                out.write(text.replace("</body>", '<script src="search_pages.js"></script></body>'))
    missing = [wanted for wanted, place in ABOUT.items() if not found(pages, words, wanted, place)]
    if missing:
        print("docs: search does not find " + ", ".join(missing))
    print(f"figure docs.search_found {len(ABOUT) - len(missing)} of_{len(ABOUT)}")


if __name__ == "__main__":
    main()
