"""Keeps what the bridge publishes below recorded/ and writes each trial as a bag of its own. Every load of a scene begins a recording
with the loop's complete memory (haptic_msgs/SessionInfo), so a trial's bag replays alone."""
import os
import struct
import threading

import rosbag
import rospy
from haptic_msgs.msg import LoopEvent, SessionInfo, TickRecord

from session_folder import sync_folder, why
from strict_yaml import Refused

PATIENCE = 20.0  # [s] for the recording of a load, and for the ticks that are on their way


def after_header(buffer):
    """Offset of the field behind a std_msgs/Header."""
    return 16 + struct.unpack_from('<I', buffer, 12)[0]


class TrialRecorder:
    """Subscribes at once: the loop's first tick waits for it."""

    def __init__(self):
        self.changed = threading.Condition()
        self.starts, self.runs, self.events = [], [], []  # (tick, stamp, raw message)
        self.end = 0  # first tick that has not arrived
        self.subscribers = [rospy.Subscriber('/recorded/session', rospy.AnyMsg, self._on_session, queue_size=100),
                            rospy.Subscriber('/recorded/ticks', rospy.AnyMsg, self._on_ticks, queue_size=2000, buff_size=1 << 22),
                            rospy.Subscriber('/recorded/events', rospy.AnyMsg, self._on_event, queue_size=1000)]

    def close(self):
        for subscriber in self.subscribers:
            subscriber.unregister()

    def _on_session(self, raw):
        info = SessionInfo()
        info.deserialize(raw._buff)
        with self.changed:
            self.starts.append((info.first_tick, rospy.Time.now(), raw))
            self.changed.notify_all()

    def _on_ticks(self, raw):
        first, count = struct.unpack_from('<QI', raw._buff, after_header(raw._buff))
        with self.changed:
            self.runs.append((first, rospy.Time.now(), raw))
            self.end = max(self.end, first + count)
            self.changed.notify_all()

    def _on_event(self, raw):
        tick, = struct.unpack_from('<Q', raw._buff, after_header(raw._buff))
        with self.changed:
            self.events.append((tick, rospy.Time.now(), raw))

    def count(self):
        with self.changed:
            return len(self.starts)

    def forget(self):
        """Before a trial: what has been is not kept."""
        with self.changed:
            self.starts, self.runs, self.events = [], [], []

    def wait_start(self, count):
        """Until `count` recordings have begun, and the last has ticks. False: not in time."""
        with self.changed:
            return self.changed.wait_for(lambda: len(self.starts) >= count and self.end > self.starts[-1][0], PATIENCE)

    def write(self, path):
        """The ticks that have come since the first start, as a bag that is on disk when this returns."""
        with self.changed:
            now = self.end
            self.changed.wait_for(lambda: self.end > now, PATIENCE)  # what happened before the call is in it
            starts, runs, events = list(self.starts), sorted(self.runs, key=lambda r: r[0]), list(self.events)
        if not starts:
            raise Refused(f'{path}: nothing was recorded: the loop has not begun')
        first = starts[0][0]
        part = path + '.part'
        try:
            with rosbag.Bag(part, 'w') as bag:
                for topic, kind, rows in (('/recorded/session', SessionInfo, starts), ('/recorded/ticks', TickRecord, runs),
                                          ('/recorded/events', LoopEvent, events)):
                    for tick, stamp, raw in rows:
                        if tick >= first:
                            bag.write(topic, (kind._type, raw._buff, kind._md5sum, None, kind), stamp, raw=True)
            with open(part, 'rb') as file:
                os.fsync(file.fileno())
            os.replace(part, path)
            sync_folder(os.path.dirname(path))
        except OSError as error:
            try:
                os.unlink(part)
            except OSError:
                pass
            raise Refused(f'{path}: the recording could not be written: {why(error)}') from error
