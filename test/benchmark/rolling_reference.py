#!/usr/bin/env python3
"""Rigid ellipsoids that roll on a plane without slipping: writes rolling_reference.h, which `./run bench right` compares with.

Angular velocity w and the plane's normal q in the body's frame; r from the centre of mass, which is the ellipsoid's centre, to the
contact, D the radii squared:  r = -D q / sqrt(q.D q),  q' = -w x q,  and with the contact at rest, v = r x w,
    I w' - m r x (r x w') = -w x I w + m r x (r' x w + w x (r x w)) + m g r x q.
Classic Runge-Kutta, step halved until the figures keep six digits. Run from this folder: python3 rolling_reference.py > rolling_reference.h
"""
import math

GRAVITY = 9.8


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def solve(M, b):
    """Cramer's rule."""
    c = list(zip(*M))
    volume = dot(c[0], cross(c[1], c[2]))
    return (dot(b, cross(c[1], c[2])) / volume, dot(c[0], cross(b, c[2])) / volume, dot(c[0], cross(c[1], b)) / volume)


def rates(radii, mass, inertia):
    squares = [r * r for r in radii]

    def f(y):
        w, q = y[:3], y[3:]
        n = math.sqrt(sum(squares[i] * q[i] * q[i] for i in range(3)))
        r = tuple(-squares[i] * q[i] / n for i in range(3))
        dq = tuple(-x for x in cross(w, q))
        dn = sum(squares[i] * q[i] * dq[i] for i in range(3)) / n
        dr = tuple(-squares[i] * (dq[i] - q[i] * dn / n) / n for i in range(3))
        M = [[inertia[i][j] + mass * (dot(r, r) * (i == j) - r[i] * r[j]) for j in range(3)] for i in range(3)]
        bend = tuple(x + z for x, z in zip(cross(dr, w), cross(w, cross(r, w))))
        gyro, carried, weight = cross(w, tuple(dot(row, w) for row in inertia)), cross(r, bend), cross(r, q)
        return solve(M, tuple(-gyro[i] + mass * carried[i] + mass * GRAVITY * weight[i] for i in range(3))) + dq

    return f


def roll(radii, mass, turned, w, q, seconds, step):
    """Yields time, w and q; the inertia's axes are turned by `turned` [rad] about z."""
    p = [mass / 5 * (radii[(i + 1) % 3] ** 2 + radii[(i + 2) % 3] ** 2) for i in range(3)]
    c, s = math.cos(turned), math.sin(turned)
    mixed = c * s * (p[0] - p[1])
    inertia = [[c * c * p[0] + s * s * p[1], mixed, 0], [mixed, s * s * p[0] + c * c * p[1], 0], [0, 0, p[2]]]
    f, y = rates(radii, mass, inertia), tuple(w) + tuple(q)
    yield 0, y[:3], y[3:]
    for k in range(round(seconds / step)):
        k1 = f(y)
        k2 = f(tuple(a + step / 2 * b for a, b in zip(y, k1)))
        k3 = f(tuple(a + step / 2 * b for a, b in zip(y, k2)))
        k4 = f(tuple(a + step * b for a, b in zip(y, k3)))
        y = tuple(a + step / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(y, k1, k2, k3, k4))
        yield (k + 1) * step, y[:3], y[3:]


def first_reversal(step):
    """Of a rattleback's yaw: radii, turn of the inertia, spin and tilt as in right_rolling.cpp."""
    q = (math.sin(0.03), 0, math.cos(0.03))
    before = None
    for t, w, q in roll((0.1, 0.025, 0.015), 0.2, math.radians(5), [-5 * x for x in q], q, 1, step):
        yaw = dot(w, q)
        if before and before[1] < 0 <= yaw:
            return before[0] + step * before[1] / (before[1] - yaw)
        before = t, yaw
    raise SystemExit("the rattleback does not turn back")


def egg(step):
    """Largest tilt of the fifteenth swing over the first's, and the period [s]."""
    crossings, largest, before = [], [], None
    for t, w, q in roll((0.06, 0.03, 0.03), 0.3, 0, (0, 0, 0), (math.sin(0.05), 0, math.cos(0.05)), 4.4, step):
        tilt = math.atan2(q[0], q[2])
        if before and before[1] < 0 <= tilt:
            crossings.append(before[0] + step * before[1] / (before[1] - tilt))
            largest.append(0)
        if largest:
            largest[-1] = max(largest[-1], tilt)
        before = t, tilt
    return largest[13] / 0.05, (crossings[13] - crossings[0]) / 13


def main():
    step, last = 2e-3, None
    while True:
        figures = (first_reversal(step), *egg(step))
        if last and max(abs(a / b - 1) for a, b in zip(figures, last)) < 1e-6:
            break
        step, last = step / 2, figures
    print("/// Rigid ellipsoids that roll: written by rolling_reference.py.")
    print("#pragma once\n\nnamespace haptic::bench {\n")
    for name, value, meaning in zip(("kRattlebackReversal", "kEggAmplitude", "kEggPeriod"), figures,
                                    ("first reversal of its yaw [s]", "of its fifteenth swing over the first's [1]", "[s]")):
        print(f"constexpr double {name} = {value:.7g};  ///< {meaning}")
    print("\n}  // namespace haptic::bench")


main()
