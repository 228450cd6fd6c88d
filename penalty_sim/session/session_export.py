#!/usr/bin/python3
"""Writes a recording of `./run demo --record` as columns, one row per tick, or as MCAP, for other programs. SI units."""
import argparse
import gzip
import io
import os
import sys
import tempfile

import numpy as np
import rosbag

import mcap_bag
import mcap_layout
import session_data

TEXT_DIGITS = 9  # of a number in CSV: far below what is measured; .npz keeps every bit
INTEGERS = ('tick', 'lost_periods', 'same_bits', 'state', 'flags', 'valid', 'contact', 'in_contact', 'clutched', 'buttons', 'contacts',
            'step_flags', 'stopped')


def write_csv(path, session):
    names = session.table.dtype.names
    formats = ','.join('%.0f' if name.split('.')[-1] in INTEGERS else '%.6f' if name == 'unix_time' else f'%.{TEXT_DIGITS}g'
                       for name in names)
    with open(path, 'w', encoding='utf-8') as file:
        file.write(','.join(names) + '\n')
        file.writelines((formats % tuple(row)).replace('nan', '') + '\n' for row in session.table)  # an empty cell: no value


def write_contacts(path, session):
    heads = ('begin', 'end', 'link_a', 'link_b', 'state', 'peak_force', 'peak_depth')
    with open(path, 'w', encoding='utf-8') as file:
        file.write(','.join(heads) + '\n')
        file.writelines(','.join(str(spell[head]) for head in heads) + '\n' for spell in session.spells)


def write_npz(path, session):
    """An array per column under its name; contacts as `contacts.begin` and so on, statistics of ticks as `statistics.time`."""
    arrays = {name: session.table[name] for name in session.table.dtype.names}
    for head in ('begin', 'end', 'link_a', 'link_b', 'state', 'peak_force', 'peak_depth'):
        arrays['contacts.' + head] = np.array([spell[head] for spell in session.spells])
    for name, values in session.statistics.items():
        arrays['statistics.' + name] = values
    archive = io.BytesIO()  # zipfile cannot end an archive on a full disk, and complains once more when it is deleted
    np.savez_compressed(archive, **arrays)
    with open(path, 'wb') as file:
        file.write(archive.getbuffer())


def write_mcap(options, prefix):
    """All messages of the bag, and a layout; the paths."""
    path = prefix + '.mcap'
    try:
        session_data.check_is_file(options.bag)
        if mcap_bag.mcap_file.is_mcap(options.bag):
            raise session_data.Refused(f'{options.bag} is an MCAP file already')
        with tempfile.TemporaryDirectory(prefix='haptic_session_') as folder:
            count = mcap_bag.to_mcap(session_data.whole(options.bag, folder), path)
        layout = mcap_layout.write_beside(path)
    except session_data.Refused as refusal:
        sys.exit(f'export: {refusal}')
    except rosbag.ROSBagException as error:
        sys.exit(f'export: {mcap_bag.unreadable(options.bag, error)}')
    except OSError as error:
        sys.exit(f'export: {error.filename or path}: cannot be written: {error.strerror}; give another place by --output')
    print(f'figure mcap.messages {count} 1')
    return [path, layout]


def write_packed(options, prefix):
    """A file per session for the page on which scenes are touched; the paths."""
    written = []
    try:
        packed = session_data.packed(options.bag, options.program)
        for number, raw in enumerate(packed):
            written.append(f'{prefix}{"" if len(packed) == 1 else f"_{number + 1}"}.session')
            with open(written[-1], 'wb') as file:
                file.write(gzip.compress(raw))
    except session_data.Refused as refusal:
        sys.exit(f'export: {refusal}')
    except OSError as error:
        sys.exit(f'export: {error.filename or prefix}: cannot be written: {error.strerror}; give another place by --output')
    return written


def main():
    parser = argparse.ArgumentParser(prog='./run export', description=__doc__)
    parser.add_argument('bag', metavar='BAG', help='a bag that ./run demo --record has written')
    parser.add_argument('--csv', action='store_true', help='BAG.csv and BAG.contacts.csv (also when nothing else is asked for)')
    parser.add_argument('--npz', action='store_true', help='BAG.npz, for numpy.load')
    parser.add_argument('--mcap', action='store_true', help='BAG.mcap, all messages, and BAG.layout.json')
    parser.add_argument('--session', action='store_true', help='BAG.session, which the page touch.html replays in a browser')
    parser.add_argument('--output', metavar='PREFIX', help='path and name of the files without ending; BAG without .bag unless given')
    parser.add_argument('--program', required=True, help=argparse.SUPPRESS)
    options = parser.parse_args()
    prefix = options.output or os.path.splitext(options.bag)[0]
    written = write_mcap(options, prefix) if options.mcap else []
    written += write_packed(options, prefix) if options.session else []
    if written and not (options.csv or options.npz):
        print('export: ' + ', '.join(os.path.abspath(path) for path in written))
        return
    try:
        sessions = session_data.read(options.bag, options.program)
    except session_data.Refused as refusal:
        sys.exit(f'export: {refusal}')
    try:
        for number, session in enumerate(sessions):
            base = prefix if len(sessions) == 1 else f'{prefix}_{number + 1}'
            if options.csv or not options.npz:
                write_csv(base + '.csv', session)
                write_contacts(base + '.contacts.csv', session)
                written += [base + '.csv', base + '.contacts.csv']
            if options.npz:
                write_npz(base + '.npz', session)
                written.append(base + '.npz')
            if session.info['mismatches']:
                print(f'export: {session.info["mismatches"]} ticks differ from the recording: another build made it, or it was '
                      'altered; see the column same_bits', file=sys.stderr)
    except OSError as error:
        sys.exit(f'export: {error.filename or prefix}: cannot be written: {error.strerror}; give another place by --output')
    print('export: ' + ', '.join(os.path.abspath(path) for path in written))
    print(f'figure session.rows {sum(len(session.table) for session in sessions)} 1')
    print(f'figure session.columns {len(sessions[0].table.dtype.names)} 1')


if __name__ == '__main__':
    main()
