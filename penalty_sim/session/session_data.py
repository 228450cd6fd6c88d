"""A recorded session as arrays: one row per tick from the encoder counts, and what only topics have.

`read(bag)` runs the program `session_table`, which replays the bag, and adds statistics of ticks and messages of devices.
"""
import contextlib
import csv
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
import yaml

import mcap_file

# haptic_core/spidar/spidar.h, DeviceState, and device_diagnosis.h, DeviceFlag, in the order of their values and bits.
STATES = ('UNCALIBRATED', 'READY', 'ENABLED', 'REDUCED', 'FAULT', 'DISCONNECTED')
FLAGS = ('CommandNotFinite', 'ForceClamped', 'TorqueClamped', 'SlewLimited', 'NotPresentable', 'TensionAtMax', 'Faded',
         'CommandStale', 'TorqueIgnored', 'PoseNotConverged', 'SampleStale', 'LinkLost', 'EncoderJump', 'ResidualHigh',
         'OverRate', 'MotorHot', 'AnswersLost', 'DelayTooLong', 'CountersStill', 'CounterRestarted', 'StringCorrected',
         'CountRefused', 'LoopLate', 'CountersFrozen', 'SomeCountersStill', 'CalibrationRefused', 'Unguarded', 'Stopped', 'Released',
         'ForceWaits')
FLAG_WORDS = {
    'CommandNotFinite': 'a wrench was not finite', 'ForceClamped': 'force over its limit', 'TorqueClamped': 'torque over its limit',
    'SlewLimited': 'the wrench rose too fast', 'NotPresentable': 'the strings cannot present the wrench',
    'TensionAtMax': 'a string at its greatest tension', 'Faded': 'the wrench is faded', 'CommandStale': 'no fresh wrench',
    'TorqueIgnored': 'a point grip has no torque', 'PoseNotConverged': 'the pose was not found',
    'SampleStale': 'no new counts', 'LinkLost': 'the device does not answer', 'EncoderJump': 'an encoder jumped',
    'ResidualHigh': 'string lengths contradict each other', 'OverRate': 'ticks faster than the wire',
    'MotorHot': 'a motor is hot', 'AnswersLost': 'answers of the boards are lost', 'DelayTooLong': 'the wire is too slow',
    'CountersStill': 'no counter moves', 'CounterRestarted': 'a board started anew',
    'StringCorrected': 'a slipped encoder was corrected', 'CountRefused': 'a count was refused',
    'LoopLate': 'this machine was late', 'CountersFrozen': 'the counters of a moving grip stopped',
    'SomeCountersStill': 'some counters stand still', 'CalibrationRefused': 'a calibration was refused',
    'Unguarded': 'no guard of the motors', 'Stopped': 'STOP', 'Released': 'the dead-man switch was not held',
    'ForceWaits': 'the force waited to be asked for after a silence'}
# The others are limits: they act in a session in which nothing is wrong.
FAULTS = {'CommandNotFinite', 'CommandStale', 'PoseNotConverged', 'LinkLost', 'EncoderJump', 'ResidualHigh', 'MotorHot', 'AnswersLost',
          'DelayTooLong', 'CountersStill', 'CounterRestarted', 'StringCorrected', 'CountRefused', 'LoopLate', 'CountersFrozen',
          'Unguarded', 'Stopped', 'ForceWaits'}
STATISTICS = ('tick_us_p50', 'tick_us_p99', 'tick_us_max', 'lateness_us_p50', 'lateness_us_p99', 'lateness_us_max')


class Refused(Exception):
    """One line for the user."""


MOST_NAMES = 2**24  # [bytes] of the columns' names, which session_table writes: those of 1000 bodies are 0.4 MB, NumPy's own bound 10 kB
PATCH = np.dtype([('tick', '<f4'), ('a', '<f4'), ('b', '<f4'), ('at', '<f4', 3), ('normal', '<f4', 3), ('force', '<f4', 3), ('area', '<f4'),
                  ('normal_force', '<f4'), ('sticking', '<f4')])  # session_view.h, kPatchNumbers


class View:
    """What session_view.h writes: `about` (visuals, links, devices, bases), `meshes` (vertices [m], triangles), `patches`."""

    def __init__(self, base):
        with open(base + '.view.yaml', encoding='utf-8') as file:
            self.about = yaml.load(file, getattr(yaml, 'CSafeLoader', yaml.SafeLoader))
        with open(base + '.meshes.bin', 'rb') as file:
            raw = file.read()
        self.meshes, at = [], 0
        for vertices, triangles in self.about['meshes']:
            points = np.frombuffer(raw, '<f4', 3 * vertices, at).reshape(-1, 3)
            at += points.nbytes
            corners = np.frombuffer(raw, '<u4', 3 * triangles, at).reshape(-1, 3)
            at += corners.nbytes
            self.meshes.append((points, corners))
        self.patches = np.fromfile(base + '.patches.bin', PATCH)


class Session:
    """`table`: structured array, a row per tick. `spells`: dicts of contacts. `info`: of the recording.
    `statistics`: dict of arrays by time. `messages`: (time, device, state, text) of every change. `view`: what a picture
    needs, if it was asked for."""

    def __init__(self, base):
        self.table = np.load(base + '.npy', mmap_mode='r', max_header_size=MOST_NAMES)  # outlives the file
        with open(base + '.yaml', encoding='utf-8') as file:
            self.info = yaml.safe_load(file)
        with open(base + '.contacts.csv', encoding='utf-8') as file:
            self.spells = [{key: float(value) if key in ('begin', 'end', 'peak_force', 'peak_depth') else value
                            for key, value in row.items()} for row in csv.DictReader(file)]
        self.statistics = {'time': np.empty(0), **{name: np.empty(0) for name in STATISTICS}}
        self.messages = []
        self.view = View(base) if os.path.exists(base + '.view.yaml') else None

    @property
    def start(self):
        """ROS time of the first tick [s]."""
        return float(self.table['unix_time'][0])

    def hands(self):
        return [hand['name'] for hand in self.info['hands']]

    def bodies(self):
        return [name[5:-len('.position_x')] for name in self.table.dtype.names
                if name.startswith('body.') and name.endswith('.position_x')]


def spells_of(mask, times, period):
    """(begin, end) of each run of True in `mask`."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    return [(float(times[a]), float(times[b - 1] + period)) for a, b in zip(edges[::2], edges[1::2])]


def flag_spells(session, hand):
    """{name of flag: [(begin, end)]} of one hand, flags that acted alone."""
    values = np.nan_to_num(session.table[hand + '.flags']).astype(np.uint32)
    times, period = session.table['time'], 1 / session.info['rate']
    return {name: spells_of((values >> bit) & 1 != 0, times, period)
            for bit, name in enumerate(FLAGS) if ((values >> bit) & 1).any()}


def check_is_file(recording):
    """Raises Refused with one line where there is no file of this name."""
    if not os.path.exists(recording):
        raise Refused(f'{recording}: no such file; give a bag that ./run demo --record has written')
    if os.path.isdir(recording):
        raise Refused(f'{recording}: is a folder; give a bag that ./run demo --record has written')


def whole(recording, folder):
    """The recording, or what is left of one that was cut off, which is said. Raises Refused with one line."""
    import rosbag
    import cut_recording
    import mcap_bag
    try:
        path, said = cut_recording.usable(recording, folder)
    except (mcap_file.Damaged, OSError) as error:
        raise Refused(str(error)) from error
    except rosbag.ROSBagException as error:
        raise Refused(mcap_bag.unreadable(recording, error)) from error
    if said:
        print(said, file=sys.stderr)
    return path


@contextlib.contextmanager
def replayed(recording, program, *options):
    """(a folder with what session_table writes of a bag or MCAP file, the bag). Raises Refused with one line."""
    bag = recording
    check_is_file(bag)
    with tempfile.TemporaryDirectory(prefix='haptic_session_') as folder:
        bag = whole(bag, folder)
        if mcap_file.is_mcap(bag):
            bag = bag_of(bag, folder)
        done = subprocess.run([program, bag, folder, *options], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Refused(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f'{bag}: session_table crashed')
        yield folder, bag


def in_order(folder, ending):
    """Paths of the sessions' files session_N with this ending."""
    names = (name for name in os.listdir(folder) if name.endswith(ending))
    return [os.path.join(folder, name) for name in sorted(names, key=lambda name: int(re.match(r'session_(\d+)', name).group(1)))]


def read(recording, program, with_view=False):
    """The sessions of a bag or MCAP file, in order, `with_view` for pictures. Raises Refused with one line."""
    with replayed(recording, program, *['--view'] * with_view) as (folder, bag):
        sessions = [Session(path[:-len('.npy')]) for path in in_order(folder, '.npy')]
        add_topics(bag, sessions)
    return sessions


def packed(recording, program):
    """The sessions as bytes that a browser replays. Raises Refused with one line."""
    with replayed(recording, program, '--packed') as (folder, _):
        files = []
        for path in in_order(folder, '.session'):
            with open(path, 'rb') as file:
                files.append(file.read())
    return files


def bag_of(recording, folder):
    """A bag in `folder` of what is read of an MCAP file."""
    import mcap_bag
    bag = os.path.join(folder, os.path.basename(recording) + '.bag')
    try:
        mcap_bag.to_bag(recording, bag)
    except (mcap_file.Damaged, OSError) as error:
        raise Refused(str(error)) from error
    return bag


def session_time(session, at):
    """Time of the session [s] at ROS time `at` [s]: it waits where ticks were lost."""
    unix = session.table['unix_time']
    return float(np.interp(at, unix, session.table['time'])) if at >= unix[0] else at - session.start


def add_topics(bag, sessions):
    """What the counts do not say: how long ticks took, and what devices said of themselves."""
    import rosbag
    with rosbag.Bag(bag) as opened:
        kinds = opened.get_type_and_topic_info().topics
        wanted = [name for name, kind in kinds.items() if kind.msg_type in ('haptic_msgs/TickStatistics', 'haptic_msgs/DeviceState')]
        rows = {id(session): [] for session in sessions}
        last = {}
        for topic, message, stamp in opened.read_messages(wanted) if wanted else ():
            at = message.header.stamp.to_sec() or stamp.to_sec()
            session = next((s for s in reversed(sessions) if at >= s.start), sessions[0])
            time = session_time(session, at)
            if hasattr(message, 'tick_us_p50'):
                rows[id(session)].append([time] + [getattr(message, name) for name in STATISTICS])
            elif (message.state, message.message) != last.get(topic):
                last[topic] = (message.state, message.message)
                device = message.header.frame_id.rsplit('_base', 1)[0]
                session.messages.append((time, device, STATES[message.state], message.message))
    for session in sessions:
        columns = np.array(rows[id(session)]).reshape(-1, 1 + len(STATISTICS))
        session.statistics = dict(zip(('time',) + STATISTICS, columns.T))
