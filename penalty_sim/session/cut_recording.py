#!/usr/bin/python3
"""Recordings that end early: cut_recording.py FILE FOLDER prints the path of a file that can be read.

A bag without an index (its writer was killed, it is still .active, a copy stopped half-way) is indexed anew in FOLDER; an MCAP file is read
as far as its chunks are complete. What there is and what is lost is one line on stderr.
"""
import os
import shutil
import struct
import sys

import rosbag

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import mcap_bag  # noqa: E402
import mcap_file  # noqa: E402

RECORD = 'haptic_msgs/TickRecord'
INFO = 'haptic_msgs/SessionInfo'


def text_end(data, at):
    return at + 4 + struct.unpack_from('<I', data, at)[0]


def rate_of(data):
    """Ticks per second of a serialized SessionInfo: after header, version, five texts, fingerprint and density."""
    at = text_end(data, 12) + 4           # seq, stamp, frame_id; version
    for _ in range(5):                    # program, build, scene, scene_file, scene_text
        at = text_end(data, at)
    return struct.unpack_from('<d', data, at + 16)[0]


def ticks_of(data):
    """Ticks of a serialized TickRecord."""
    return struct.unpack_from('<I', data, text_end(data, 12) + 8)[0]


def amount(messages):
    """(ticks, seconds, sessions) of (type, serialized message)s."""
    ticks, seconds, rate, sessions = 0, 0.0, 0.0, 0
    for kind, data in messages:
        if kind == INFO:
            rate, sessions = rate_of(data), sessions + 1
        elif rate > 0:
            ticks, seconds = ticks + ticks_of(data), seconds + ticks_of(data) / rate
    return ticks, seconds, sessions


def of_bag(bag):
    return ((kind, data) for _, (kind, data, *_), _ in bag.read_messages(raw=True) if kind in (RECORD, INFO))


def of_mcap(path):
    for _, kind, _, _, _, data in mcap_file.messages(path, lambda _, kind: kind in (RECORD, INFO)):
        yield kind, data


def note(path, left, lost, only_index=False):
    """One line: what is read, what is lost."""
    ticks, seconds, sessions = left
    if sessions == 0 or ticks == 0:
        raise rosbag.ROSBagException(f'{path}: is cut before its first tick: nothing of it can be used')
    several = f' of {sessions} sessions' if sessions > 1 else ''
    after = 'its index alone is lost' if only_index else f'its last {lost} bytes are no complete chunk and are lost' if lost else 'what came after its last chunk was never written'
    return f'{path}: was cut off: {ticks} ticks ({seconds:.3f} s{several}) are used; {after}'


def end_of_chunks(path):
    """Where the index begins that the bag's head tells of; 0: it was never ended."""
    with open(path, 'rb') as file:
        head = file.read(4096)
    at = head.find(b'index_pos=')
    return struct.unpack_from('<Q', head, at + 10)[0] if 0 <= at <= len(head) - 18 else 0


def indexed_anew(path, folder):
    """(copy with an index, note)."""
    copy = os.path.join(folder, os.path.basename(path).replace('.active', '') + '.whole.bag')
    shutil.copyfile(path, copy)
    size, end = os.path.getsize(copy), end_of_chunks(path)
    if 0 < end < size:  # the cut went through the index: nothing else is lost, and rosbag stumbles over what is left of it
        os.truncate(copy, end)
    with rosbag.Bag(copy, 'a', allow_unindexed=True) as bag:
        for _ in bag.reindex():  # leaves out what is no complete chunk
            pass
        whole = os.path.getsize(copy)
    with rosbag.Bag(copy) as bag:
        left = amount(of_bag(bag))
    return copy, note(path, left, size - whole, whole == end)


def usable(path, folder):
    """(path of a file that can be read, note or ''). Raises rosbag.ROSBagException, mcap_file.Damaged, OSError."""
    if mcap_file.is_mcap(path):
        whole, size = mcap_file.complete_bytes(path), os.path.getsize(path)
        return path, '' if whole is None else note(path, amount(of_mcap(path)), size - whole)
    try:
        mcap_bag.opened(path).close()
        return path, ''
    except rosbag.ROSBagUnindexedException:
        return indexed_anew(path, folder)


def main():
    path, folder = sys.argv[1:]
    try:
        whole, said = usable(path, folder)
    except (mcap_file.Damaged, rosbag.ROSBagException) as error:
        sys.exit(mcap_bag.unreadable(path, error))
    except OSError as error:
        sys.exit(f'{error.filename or path}: {error.strerror}')
    if said:
        print(said, file=sys.stderr)
    print(whole)


if __name__ == '__main__':
    main()
