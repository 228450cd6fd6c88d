#!/usr/bin/python3
"""robots_table.py LOG [WHERE]: the robots that `bench_robots` tried as a table in markdown. WHERE says where it was measured."""
import os
import sys

import table_of_log

COLUMNS = ("robot", "licence", "joints", "collisions", "load, s", "cached, s", "surface off unsaid, mm", "against KDL", "step, µs", "replaced")
EXPLANATION = """Every file below `shared/example-robot-data`, `shared/cases` and the folder `HAPTIC_ROBOTS`, as `./run bench robots` loads it
(links without inertia at 1000 kg/m³, missing meshes as boxes). Cached: loaded once more, meshes from the cache. Against KDL: link poses,
mass matrix and gravity, scaled. Replaced: parts that could not be as the file has them."""
LICENCES = {"BSD": "BSD", "Apache": "Apache-2.0", "MIT License": "MIT", "Permission is hereby granted": "MIT", "GNU LESSER": "LGPL",
            "GNU GENERAL": "GPL", "Redistribution and use in source": "BSD", "Creative Commons": "CC"}


def licence_of(path):
    """Name of the licence in the nearest file LICENSE above, - where there is none."""
    folder = os.path.dirname(path)
    while folder and folder != os.path.dirname(folder):
        for name in ("LICENSE", "LICENSE.txt", "LICENCE", "COPYING"):
            try:
                with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
                    text = file.read(4000)
            except OSError:
                continue
            return next((short for mark, short in LICENCES.items() if mark in text), name)
        folder = os.path.dirname(folder)
    return "-"


def rows(log):
    """[(cells, replaced lines)] of the log. Raises ValueError when it has none."""
    found = []
    for line in log:
        line = line.rstrip("\n")
        if line.startswith("robot ") and "|" in line:
            path, state, *values = line[len("robot "):].split("|")
            if state == "loaded" and len(values) == 7:
                found.append(([path, licence_of(path)] + values, []))
            else:
                found.append(([path, licence_of(path), "refused: " + "/".join(values)] + [""] * 6, []))
        elif line.startswith("replaced ") and found:
            found[-1][1].append(line[len("replaced "):])
    if not found:
        raise ValueError("holds no robot: give the log of `./run bench robots`")
    return found


def markdown(found, where=""):
    common = os.path.commonpath([os.path.dirname(cells[0]) for cells, _ in found])
    lines = [EXPLANATION] + ([f"Measured on {where}."] if where else []) + ["", "| " + " | ".join(COLUMNS) + " |", "|---" * len(COLUMNS) + "|"]
    for cells, replaced in found:
        lines.append("| " + " | ".join([os.path.relpath(cells[0], common)] + cells[1:] + [str(len(replaced))]) + " |")
    parts = [line for _, replaced in found for line in replaced]
    return "\n".join(lines + ([""] + ["- " + os.path.relpath(part, common) if part.startswith("/") else "- " + part for part in parts])) + "\n"


if __name__ == "__main__":
    sys.exit(table_of_log.run("robots_table", __doc__, rows, markdown, sys.argv[1:]))
