#!/usr/bin/python3
"""Pages that are made of the sources themselves: messages and services, and the Python package.

    launch/doc/site/collect.py FOLDER      writes messages.md and python.md there; prints how many symbols have no word
"""
import glob
import inspect
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))


def messages():
    lines, silent = ["# Messages and services {#messages}", ""], 0
    for kind, ending in (("msg", ".msg"), ("srv", ".srv")):
        for path in sorted(glob.glob(os.path.join(ROOT, "msgs", kind, "*" + ending))):
            with open(path, encoding="utf-8") as file:
                text = file.read().rstrip()
            silent += sum(1 for line in text.splitlines()
                          if line.strip() and line.strip() != "---" and "#" not in line and "=" not in line)
            lines += [f"## haptic_msgs/{os.path.basename(path)[:-4]}", "", "```", text, "```", ""]
    return lines, silent


def members(thing):
    """What a class defines itself, in its order, without Python's own."""
    for name, value in vars(thing).items():
        if name == "__init__" or not name.startswith("_"):
            yield name, value


def python():
    import haptic  # as it was built
    lines, silent = ["# Python package haptic {#python}", "", inspect.getdoc(haptic), ""], 0
    for name in sorted(haptic.__all__):
        thing = getattr(haptic, name)
        if name == "__version__":
            continue
        lines += [f"## {name}", ""]
        if inspect.isclass(thing):
            lines += [paragraph(thing), ""]
            silent += not inspect.getdoc(thing)
            for member, value in members(thing):
                text = inspect.getdoc(value)
                if not text or isinstance(value, (int, str)):
                    silent += not isinstance(value, (int, str))
                elif text.startswith("__init__("):
                    lines += [f"- {flat(text.replace('__init__', name).replace(' -> None', ''))}"]
                elif member != "__init__":  # else nobody makes one from Python
                    lines += ["- " + flat(text) if text.startswith(member + "(") else f"- **{member}**: {flat(text)}"]
            lines.append("")
        else:
            lines += [paragraph(thing), ""]
            silent += not inspect.getdoc(thing)
    return lines, silent


def paragraph(thing):
    return flat(inspect.getdoc(thing) or "")


def flat(text):
    """pybind11 puts the signature before the words: it becomes code, in the words of who calls it."""
    signature = re.match(r"\w+\(.*?\)(?: -> [^\n]+)?(?=\n|$)", text, re.S)
    if signature:
        words = text[signature.end():]
        text = re.sub(r"self: [\w.]+(, )?|haptic\._haptic\.|numpy\.(?=ndarray)", "", signature.group())
        text = re.sub(r"ndarray\[(?:numpy\.)?\w+(\[[^]]*\])?[^]]*\]", r"array\1", text)
        text = re.sub(r"array\(\[\[1\., 0\., 0\., 0\.\].*?\]\]\)", "eye(4)", text, flags=re.S)
        text = f"`{text}` {words}"
    return re.sub(r"\s+", " ", text).replace("<", "&lt;").replace("@", "\\@").strip()


def main():
    folder = sys.argv[1]
    os.makedirs(folder, exist_ok=True)
    total = 0
    for name, page in (("messages", messages), ("python", python)):
        lines, silent = page()
        with open(os.path.join(folder, name + ".md"), "w", encoding="utf-8") as out:
            out.write("\n".join(lines) + "\n")
        print(f"figure docs.undocumented_{name} {silent} 1")
        total += silent
    return total


if __name__ == "__main__":
    main()
