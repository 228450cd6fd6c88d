#!/usr/bin/python3
"""scenes_table.py LOG [WHERE]: the table that `bench_scenes` printed, in markdown. WHERE says where it was measured."""
import sys

import table_of_log

# Column of the log, heading here.
COLUMNS = (("scene", "scene"), ("force_%", "force error, %"), ("inside_%", "of what can be presented, %"),
           ("energy", "energy gained"), ("worst_us", "worst tick, µs"), ("p999_us", "99.9 %, µs"), ("missed", "missed"),
           ("ringing", "above 50 Hz"), ("given", "stiffness given"))
EXPLANATION = """Ten seconds of each shipped scene at 1 kHz, its scripted hands on simulated devices. Force error: rms of what the
device's strings did to the grip less what the loop asked for, over what it asked; then over the ticks that the strings can present.
Energy gained: of the largest energy exchanged. Ticks: compute time; one beyond 1 ms is missed. Above 50 Hz: share of the force,
largest of any second; above 0.33 the hand rings. Stiffness given: least share of a contact's that the hand bore."""


def rows(log):
    """The lines of the table as dictionaries. Raises ValueError when there is none."""
    names, found = None, []
    for line in log:
        words = line.split()
        if words[:1] == ["scene"] and "missed" in words:
            names = words
        elif names and len(words) == len(names) and words[0] != "figure":
            found.append(dict(zip(names, words)))
        elif names and found:
            break
    if not found:
        raise ValueError("holds no table of scenes: give the log of `./run bench scenes`")
    missing = [name for name, _ in COLUMNS if name not in names]
    if missing:
        raise ValueError("its table has no column " + ", ".join(missing) + ": run `./run bench scenes` again")
    return found


def markdown(found, where=""):
    head = "| " + " | ".join(title for _, title in COLUMNS) + " |"
    rule = "|---|" + "---:|" * (len(COLUMNS) - 1)
    lines = ["| " + " | ".join(row[name] for name, _ in COLUMNS) + " |" for row in found]
    return "\n".join([EXPLANATION] + ([f"Measured on {where}."] if where else []) + ["", head, rule] + lines) + "\n"


if __name__ == "__main__":
    sys.exit(table_of_log.run("scenes_table", __doc__, rows, markdown, sys.argv[1:]))
