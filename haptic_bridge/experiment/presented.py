"""What a hand was given: stiffness, friction or mass from its pose and the force of the strings, with an error. The world's own
contact values are not used.

stiffness  Along the mean force n, with x the grip's way against n: F_n = K x + c0 + c1 x' + c2 x x' by least squares over contact. The
           terms in x' take the damping, K is what is left at rest [N/m]. Where the loop adds a delay, x is that of so long ago.
friction   Sum of |F_t| over sum of F_n, over ticks that slide: a tip sticks until its tangential spring is strained, so the first
           millimetres after each turn do not count.
mass       Mean force against gravity over a lifted spell, over g plus the spell's mean acceleration [kg].

While the force fades (a hand was let in, nothing was exchanged for 20 ms) it is no function of the grip's way: such ticks do not count here, and a row
says their share.

Errors are those of a jackknife over ten consecutive pieces, because neighbouring ticks are not independent."""
from dataclasses import dataclass, replace

import numpy as np

SLIDES = 3e-3        # tangential speed above which a contact moves for certain [m/s]
STRAINED = 4e-3      # way after a turn until a tip slides: twice mu F_n over a tangential stiffness of 1000 N/m, for mu F_n up to 2 N [m]
LEAST_FORCE = 0.2    # below it, friction's ratio is of two small numbers [N]
LIFTED = 1.5e-3      # above the first touch a tray hangs on the hand alone [m]
VELOCITY_SPAN = 0.01  # half of the span that velocities are differences over [s]
PIECES = 10
DEFAULT_GRAVITY = 9.8


@dataclass
class Samples:
    """Rows by time of one interval. Axes are those of the device's base."""
    time: np.ndarray       # [s]
    position: np.ndarray   # n x 3, grip [m]
    force: np.ndarray      # n x 3, of the strings on the hand [N]
    contact: np.ndarray    # bool
    flags: np.ndarray      # DeviceFlag bits
    share: np.ndarray      # of the contact's stiffness that the hand is given [1]
    fade: np.ndarray       # gain on the force: soft start, pause, REDUCED, heat; 1 is whole [1]

    def __len__(self):
        return len(self.time)


@dataclass
class Estimate:
    value: float = float('nan')
    error: float = float('nan')   # standard error


def velocity(samples):
    """Central differences [m/s]."""
    period = float(np.median(np.diff(samples.time)))
    n = max(1, int(round(VELOCITY_SPAN / period)))
    index = np.arange(len(samples))
    low, high = np.maximum(index - n, 0), np.minimum(index + n, len(samples) - 1)
    return (samples.position[high] - samples.position[low]) / (samples.time[high] - samples.time[low])[:, None]


def jackknifed(count, estimate):
    """`estimate(rows)` over all rows, and its error from leaving out one of PIECES at a time."""
    whole = estimate(np.arange(count))
    if count < 4 * PIECES or not np.isfinite(whole):
        return Estimate(whole)
    pieces = np.array_split(np.arange(count), PIECES)
    left = np.array([estimate(np.concatenate(pieces[:i] + pieces[i + 1:])) for i in range(PIECES)])
    return Estimate(whole, float(np.sqrt((PIECES - 1) / PIECES * np.sum((left - left.mean()) ** 2))))


def whole(samples):
    return samples.fade >= 1


def faded_share(samples):
    """Of the ticks in touch, those whose force was faded [1]."""
    return float((~whole(samples))[samples.contact].mean()) if samples.contact.any() else 0.0


def delayed(samples, delay):
    """With the positions of `delay` s before: what the world answered to."""
    if not delay:
        return samples
    then = samples.time - delay
    position = np.stack([np.interp(then, samples.time, samples.position[:, axis]) for axis in range(3)], axis=1)
    return replace(samples, position=position)


def stiffness(samples):
    touching = samples.contact & whole(samples) & (np.linalg.norm(samples.force, axis=1) > 0.02)
    if touching.sum() < 20:
        return Estimate()
    force = samples.force[touching]
    normal = force.sum(axis=0) / np.linalg.norm(force.sum(axis=0))
    along = force @ normal
    x = -(samples.position[touching] @ normal)
    v = -(velocity(samples)[touching] @ normal)
    pressed = along > 0.1 * along.max()  # at the edge of touch the tip is not yet flat on the pad
    x, v, along = x[pressed] - x[pressed].mean(), v[pressed], along[pressed]
    terms = np.stack([x, np.ones_like(x), v, x * v], axis=1)
    scale = np.abs(terms).max(axis=0) + 1e-300
    # x without offset: the slope at v = 0 is that of x alone, wherever x counts from.
    return jackknifed(len(x), lambda rows: float(np.linalg.lstsq(terms[rows] / scale, along[rows], rcond=None)[0][0] / scale[0]))


def way_since_turn(samples, v_t):
    """Way along the present direction since motion went against it, or touch began [m]."""
    way, since = np.zeros(len(samples)), 0
    for i in range(1, len(samples)):
        if not samples.contact[i] or v_t[i] @ v_t[i - 1] < 0 or np.linalg.norm(v_t[i]) < SLIDES:
            since = i
        way[i] = np.linalg.norm(samples.position[i] - samples.position[since])
    return way


def friction(samples, normal):
    normal = np.asarray(normal, dtype=float)
    along = samples.force @ normal
    across = np.linalg.norm(samples.force - along[:, None] * normal, axis=1)
    v = velocity(samples)
    v_t = v - (v @ normal)[:, None] * normal
    sliding = (np.linalg.norm(v_t, axis=1) > SLIDES) & (way_since_turn(samples, v_t) > STRAINED)
    rows = np.flatnonzero(samples.contact & whole(samples) & sliding & (along > LEAST_FORCE))
    if len(rows) < 20:
        return Estimate()
    return jackknifed(len(rows), lambda part: float(across[rows[part]].sum() / along[rows[part]].sum()))


def spells(mask):
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    return list(zip(edges[::2], edges[1::2]))


def mass(samples, gravity):
    touched = np.flatnonzero(samples.contact)
    if len(touched) < 20:
        return Estimate()
    height = samples.position[:, 2]
    lifted = samples.contact & whole(samples) & (height > height[touched[0]] + LIFTED)
    # The hand's force on the tray is the opposite of the tray's on the hand.
    load, v = -samples.force[:, 2], velocity(samples)[:, 2]
    values, weights = [], []
    for begin, end in spells(lifted):
        if end - begin < 20:
            continue
        last = end - 1
        acceleration = (v[last] - v[begin]) / (samples.time[last] - samples.time[begin])
        values.append(float(load[begin:end].mean() / (gravity + acceleration)))
        weights.append(end - begin)
    if not values:
        return Estimate()
    value = float(np.average(values, weights=weights))
    spread = np.sqrt(np.average((np.array(values) - value) ** 2, weights=weights) / max(1, len(values) - 1))
    return Estimate(value, float(spread) if len(values) > 1 else float('nan'))


def presented(measure, samples, condition, delay=0.0, normal=(0, 0, 1)):
    """The Estimate of `measure`; NaN where the hand did not do what shows it. `delay`: that the loop adds between pose and force [s]."""
    samples = delayed(samples, delay)
    if measure == 'none' or len(samples) < 20:
        return Estimate()
    if measure == 'stiffness':
        return stiffness(samples)
    if measure == 'friction':
        return friction(samples, normal)
    return mass(samples, condition.get('gravity', DEFAULT_GRAVITY))
