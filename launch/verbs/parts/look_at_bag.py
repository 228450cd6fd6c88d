#!/usr/bin/python3
"""Looks at a bag that a run says it has recorded: look_at_bag.py BAG BEGIN TICKS; BEGIN is a
file that the run made when it began. Silent and 0 when all of the run's ticks are in it."""
import os
import sys

import rosbag


def complaint(path, begin, ticks):
    if not os.path.exists(path):
        return "is not there: it was removed, or the disk is full" + (f"; what there is: {path}.active" if os.path.exists(path + ".active") else "")
    if os.stat(path).st_mtime_ns < os.stat(begin).st_mtime_ns:
        return "is of an earlier run: nothing was written in its place"
    try:
        with rosbag.Bag(path) as bag:
            kept = sum(message.ticks for topic, message, _ in bag.read_messages() if topic.endswith("recorded/ticks"))
    except (rosbag.ROSBagException, OSError, ValueError) as error:
        return f"cannot be read ({error}): is the disk full?"
    return "" if kept == ticks else f"holds {kept} of {ticks} ticks: is the disk full? (rosbag leaves the last 1 GB of a disk free)"


why = complaint(sys.argv[1], sys.argv[2], int(float(sys.argv[3])))
if why:
    print(f"{sys.argv[1]} {why}", file=sys.stderr)
    sys.exit(1)
