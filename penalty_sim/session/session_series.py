"""Time series packed for a page: 16-bit steps of each series' own range, as differences, deflated."""
import base64
import zlib

import numpy as np

LEVELS = 65534  # of int16, one value left for NaN
HOLE = -32768   # NaN


class Packed:
    """Series of equally many ticks. Each point is a bin of `bin` ticks: its least and its greatest value."""

    def __init__(self, ticks, per_bin):
        self.ticks, self.bin = ticks, per_bin
        self.points = -(-ticks // per_bin)
        self.ranges = []   # of each series: least value, value of a step
        self._planes = []

    def add(self, values):
        """Index of the series."""
        values = np.asarray(values, dtype=float)
        finite = values[np.isfinite(values)]
        least, greatest = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
        step = (greatest - least) / LEVELS or 1.0
        self.ranges.append((least, step))
        if self.bin == 1:
            self._add_plane(values, least, step)
        else:
            padded = np.full(self.points * self.bin, np.nan)
            padded[:self.ticks] = values
            bins = padded.reshape(self.points, self.bin)
            hole = np.isnan(bins).all(axis=1)
            self._add_plane(np.where(hole, np.nan, np.min(np.where(np.isnan(bins), np.inf, bins), axis=1)), least, step)
            self._add_plane(np.where(hole, np.nan, np.max(np.where(np.isnan(bins), -np.inf, bins), axis=1)), least, step)
        return self.last

    @property
    def last(self):
        """Index of the series that was added last."""
        return len(self.ranges) - 1

    def _add_plane(self, values, least, step):
        hole = ~np.isfinite(values)
        levels = np.where(hole, HOLE, np.rint((np.where(hole, least, values) - least) / step) + HOLE + 1).astype(np.int64)
        changes = np.diff(levels, prepend=0).astype(np.int16)  # modulo 2^16: the sum comes out right
        self._planes.append(changes.astype('<i2').view(np.uint8).reshape(-1, 2).T.tobytes())  # low bytes, then high

    def text(self):
        return base64.b64encode(zlib.compress(b''.join(self._planes), 6)).decode()
