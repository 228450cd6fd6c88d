#!/usr/bin/python3
"""Looks at a bag or MCAP file that a run says it has recorded: look_at_recording.py FILE BEGIN TICKS; BEGIN is a
file that the run made when it began. Silent and 0 when all of the run's ticks are in it; TICKS empty: any."""
import os
import struct
import sys

import rosbag

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "..", "penalty_sim", "session"))
import mcap_file  # noqa: E402


def ticks_of_bag(path):
    with rosbag.Bag(path) as bag:
        return sum(message.ticks for topic, message, _ in bag.read_messages() if topic.endswith("recorded/ticks"))


def ticks_of_mcap(path):
    with open(path, "rb") as file:
        file.seek(max(0, os.path.getsize(path) - len(mcap_file.MAGIC)))
        if file.read() != mcap_file.MAGIC:
            raise mcap_file.Damaged(f"{path}: has no end")
    count = 0
    for *_, data in mcap_file.messages(path, lambda topic, _: topic.endswith("recorded/ticks")):
        frame = struct.unpack_from("<I", data, 12)[0]          # TickRecord: header, first_tick, ticks
        count += struct.unpack_from("<I", data, 16 + frame + 8)[0]
    return count


def complaint(path, begin, ticks):
    if not os.path.exists(path):
        return "is not there: it was removed, or the disk is full" + (f"; what there is: {path}.active" if os.path.exists(path + ".active") else "")
    if os.stat(path).st_mtime_ns < os.stat(begin).st_mtime_ns:
        return "is of an earlier run: nothing was written in its place"
    is_mcap = path.endswith(".mcap")
    try:
        kept = (ticks_of_mcap if is_mcap else ticks_of_bag)(path)
    except (rosbag.ROSBagException, mcap_file.Damaged, OSError, ValueError, struct.error) as error:
        return f"cannot be read ({error}): is the disk full?"
    rest = "" if is_mcap else " (rosbag leaves the last 1 GB of a disk free)"
    return "" if kept == ticks or (ticks is None and kept > 0) else f"holds {kept} of {ticks} ticks: is the disk full?{rest}"


why = complaint(sys.argv[1], sys.argv[2], int(float(sys.argv[3])) if sys.argv[3] else None)
if why:
    print(f"{sys.argv[1]} {why}", file=sys.stderr)
    sys.exit(1)
