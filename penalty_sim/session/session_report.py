#!/usr/bin/python3
"""Turns a recording of `./run demo --record` into one HTML file: every tick, with zoom; asks for nothing from outside."""
import argparse
import os
import sys
import time

import session_data
import session_page
import view_data
import view_program

LIMIT = 2_900_000        # of a page [bytes]: what opens at once and goes by mail
TICKS_TOGETHER = 100000  # beyond that many ticks even the first try has bins


def write(path, content):
    try:
        with open(path, 'w', encoding='utf-8') as file:
            file.write(content)
    except OSError as error:
        raise session_data.Refused(f'{path}: cannot be written: {error.strerror}; give another place by --output') from error


def page(sessions, bag, program='', no_view=''):
    """The page within LIMIT, with bins of as few ticks as that takes, and with a 3-D view if there is a `program` for it: its text, ticks per
    bin, what view_data.pack made of each session."""
    views = [view_data.pack(session) for session in sessions] if program else []
    per_bin = max(1, sum(len(session.table) for session in sessions) // TICKS_TOGETHER)
    while True:
        content = session_page.document(sessions, bag, per_bin, views, program, no_view)
        size = len(content.encode())
        if size <= LIMIT or per_bin > max(len(session.table) for session in sessions):
            return content, per_bin, views
        per_bin = max(per_bin + 1, int(per_bin * size / LIMIT) + 1)


def main():
    started = time.monotonic()
    parser = argparse.ArgumentParser(prog='./run report', description=__doc__)
    parser.add_argument('bag', metavar='BAG', help='a bag that ./run demo --record has written')
    parser.add_argument('--output', metavar='FILE', help='the page; BAG with the ending .html unless given')
    parser.add_argument('--program', required=True, help=argparse.SUPPRESS)
    options = parser.parse_args()
    output = options.output or os.path.splitext(options.bag)[0] + '.html'
    try:
        sessions = session_data.read(options.bag, options.program, with_view=True)
        program, no_view = view_program.packed()
        content, per_bin, views = page(sessions, options.bag, program, no_view)
        write(output, content)
    except session_data.Refused as refusal:
        sys.exit(f'report: {refusal}')
    for session in sessions:
        if session.info['mismatches']:
            print(f'report: {session.info["mismatches"]} ticks differ from the recording: another build made it, or it was altered; '
                  'the page says from where on', file=sys.stderr)
    if no_view:
        print(f'report: {no_view}', file=sys.stderr)
    print(f'report: {os.path.abspath(output)}' + (f', a point for every {per_bin} ticks' if per_bin > 1 else ''))
    print(f'figure session.page_kb {len(content.encode()) / 1000:.0f} kB')
    if views:
        print(f'figure session.pose_error_um {1e6 * max(data["poseError"] for data, _ in views):.2f} um')
        print(f'figure session.mesh_error_um {1e6 * max(data["meshError"] for data, _ in views):.2f} um')
    print(f'figure session.seconds {time.monotonic() - started:.2f} s')
    print(f'figure session.ticks {sum(len(session.table) for session in sessions)} 1')


if __name__ == '__main__':
    main()
