"""Event markers for EEG, EMG and eye trackers: a topic, and a byte on a serial line (a TTL trigger box)."""
import os
import termios
import time

from strict_yaml import Refused

CODES = {'trial_begin': 1, 'interval_1': 2, 'interval_2': 3, 'interval_end': 4, 'question': 5, 'answer': 6, 'trial_end': 7, 'stopped': 8,
         'pause': 9, 'note': 10}


class EventMarkers:
    """`send` writes the byte first, then tells the topic."""

    def __init__(self, port='', publish=None):
        self.publish, self.line, self.sent = publish, None, []
        if port:
            try:
                self.line = os.open(port, os.O_WRONLY | os.O_NOCTTY | os.O_NONBLOCK)
                raw(self.line)
            except (OSError, termios.error) as error:
                raise Refused(f'--marker-port {port}: cannot be opened as a serial line: {error}') from error

    def send(self, event, trial=0):
        now = time.time()
        if self.line is not None:
            try:
                os.write(self.line, bytes([CODES[event]]))
            except OSError as error:  # the study goes on; the row's note says that its markers are missing
                os.close(self.line)
                self.line = None
                return f'the marker line broke: {error.strerror}'
        if self.publish:
            self.publish(now, CODES[event], event, trial)
        return ''


def raw(line):
    """115200 baud, 8 bits, no echo, nothing translated."""
    attributes = termios.tcgetattr(line)
    attributes[0] = attributes[1] = attributes[3] = 0
    attributes[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
    attributes[4] = attributes[5] = termios.B115200
    termios.tcsetattr(line, termios.TCSANOW, attributes)
