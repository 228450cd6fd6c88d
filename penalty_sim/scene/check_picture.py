#!/usr/bin/python3
"""The picture of `./run check ... --picture FILE.svg`: where a device presents which force, or how far a scene is from ringing.

    check_picture.py device FILE OUT.svg
    check_picture.py scene NAME OUT.svg          (reads what scene_check printed from its input)

An SVG without anything from outside, dark on white; its title says what it shows to those who do not see it.
"""
import html
import math
import os
import re
import sys

INK, FAINT, OURS, LIMIT = '#18222c', '#c8d0d8', '#0072b2', '#d55e00'  # Okabe and Ito's blue and vermilion, which colour-blind eyes tell apart
LEVELS = (1, 2, 5, 10, 20)        # of the force that every direction gets [N]
BANDS = ('#ffffff', '#d0e3f2', '#9cc7e4', '#5aa2cf', '#1f77b4', '#0b3c6b')  # below the first level, and from each level on: darker is more
LOST = 0.02                       # of a force, beyond which it counts as not presented (spidar/device_check.cpp)
CELLS = 31                        # of a section, along each side
PANEL, GAP, LEFT, TOP = 220, 78, 62, 62  # of the sections [px]
# Of islands whose steps would not be stable by velocity Verlet, by Verdict of analysis/certificate.h.
BEYOND = {'PASS': 'solved implicitly', 'REFUSED': 'no step helps'}
# Faces, edges and corners of a cube.
DIRECTIONS = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z]
# Title, axis to the right and axis up of each section through home, with the words that the axes have (REP-103), and their signs.
SECTIONS = (('from above', 1, 0, 'to the right, −y [mm]', 'away, x [mm]', -1), ('from the right', 0, 2, 'away, x [mm]', 'up, z [mm]', 1),
            ('from the user', 1, 2, 'to the right, −y [mm]', 'up, z [mm]', -1))


class Drawing:
    """Elements of an SVG."""

    def __init__(self, width, height, title):
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" height="{height:g}" role="img" '
                      f'aria-label="{html.escape(title)}" font-family="sans-serif" font-size="12" fill="{INK}"><title>{html.escape(title)}</title>'
                      f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>']

    def rect(self, x, y, width, height, fill, line='none'):
        self.parts.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" fill="{fill}" stroke="{line}"/>')

    def line(self, x0, y0, x1, y1, colour, width=1, dash=''):
        self.parts.append(f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" stroke="{colour}" stroke-width="{width}"'
                          + (f' stroke-dasharray="{dash}"' if dash else '') + '/>')

    def dot(self, x, y, radius, fill):
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{fill}"/>')

    def text(self, x, y, words, anchor='start', turned=False, **style):
        more = ''.join(f' {key.replace("_", "-")}="{value}"' for key, value in style.items())
        turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ''
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{turn}{more}>{html.escape(words)}</text>')

    def write(self, path):
        with open(path, 'w', encoding='utf-8') as file:
            file.write('\n'.join([*self.parts, '</svg>', '']))


def round_step(span, count):
    """A round number of which about `count` go into a span."""
    power = 10 ** math.floor(math.log10(span / count))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power * count >= span)


def band(device, point, directions=DIRECTIONS):
    """How many of LEVELS every one of `directions` gets at a point of the base [m]."""
    import numpy as np
    X_BG = np.eye(4)
    X_BG[:3, 3] = point
    for index, level in enumerate(LEVELS):
        for direction in directions:
            force = level * np.array(direction) / np.linalg.norm(direction)
            if device.tensions(force, X_BG=X_BG).error > LOST * level:
                return index
    return len(LEVELS)


def draw_section(out, device, section, left, scale, half):
    """One section through home, `half` [m] to each side; `scale` in pixels per metre."""
    title, right, up, right_words, up_words, sign = section
    middle = (left + PANEL / 2, TOP + PANEL / 2)
    out.text(left, TOP - 12, title, font_weight='bold')
    width = [2 * half[axis] / CELLS for axis in (right, up)]
    for column in range(CELLS):
        for row in range(CELLS):
            point = [0.0, 0.0, 0.0]
            point[right], point[up] = (column + 0.5) * width[0] - half[right], (row + 0.5) * width[1] - half[up]
            found = band(device, point)
            if found:
                x, y = middle[0] + sign * scale * point[right], middle[1] - scale * point[up]
                out.rect(x - scale * width[0] / 2, y - scale * width[1] / 2, scale * width[0] + 0.3, scale * width[1] + 0.3, BANDS[found])
    box = (middle[0] - scale * half[right], middle[1] - scale * half[up], 2 * scale * half[right], 2 * scale * half[up])
    out.rect(*box, 'none', INK)
    step = round_step(2000 * max(half), 5)
    for axis, words, turned in ((right, right_words, False), (up, up_words, True)):
        for tick in range(-int(1000 * half[axis] / step), int(1000 * half[axis] / step) + 1):
            at = 1e-3 * step * tick * scale
            label = f'{step * tick:g}'.replace('-', '−')
            if turned:
                out.line(box[0] - 4, middle[1] - at, box[0], middle[1] - at, INK)
                out.text(box[0] - 7, middle[1] - at + 4, label, 'end', font_size=10)
            else:
                out.line(middle[0] + at, box[1] + box[3], middle[0] + at, box[1] + box[3] + 4, INK)
                out.text(middle[0] + at, box[1] + box[3] + 16, label, 'middle', font_size=10)
        if turned:
            out.text(box[0] - 38, middle[1], words, 'middle', turned=True)
        else:
            out.text(middle[0], box[1] + box[3] + 32, words, 'middle')
    for exit_point in device.exits:
        out.dot(middle[0] + sign * scale * exit_point[right], middle[1] - scale * exit_point[up], 3.5, LIMIT)
    for colour, width in (('#ffffff', 4), (INK, 1.5)):
        out.line(middle[0] - 7, middle[1], middle[0] + 7, middle[1], colour, width)
        out.line(middle[0], middle[1] - 7, middle[0], middle[1] + 7, colour, width)


def draw_device(path, target):
    import haptic
    import numpy as np
    device = haptic.Device(path)
    half = np.maximum(np.abs(device.exits).max(axis=0), 0.15 * np.abs(device.exits).max())
    scale = PANEL / (2 * half.max())
    title = f'{device.name}: the force that every direction gets, in three sections through home, with the exits of the strings'
    out = Drawing(LEFT + 3 * PANEL + 2 * GAP + 20, TOP + PANEL + 96, title)
    out.text(LEFT, 24, f'{device.name}: force that every direction gets, grip unrotated', font_size=15, font_weight='bold')
    for number, section in enumerate(SECTIONS):
        draw_section(out, device, section, LEFT + number * (PANEL + GAP), scale, half)
    x, y = LEFT, TOP + PANEL + 66
    for index, colour in enumerate(BANDS):
        words = f'below {LEVELS[0]} N' if index == 0 else f'{LEVELS[index - 1]} N' + (' and more' if index == len(LEVELS) else '')
        out.rect(x, y, 26, 14, colour, INK)
        out.text(x + 32, y + 12, words)
        x += 44 + 7.2 * len(words)
    out.dot(x + 10, y + 7, 3.5, LIMIT)
    out.text(x + 20, y + 12, 'exit of a string')
    out.text(x + 122, y + 12, '+ home')
    out.write(target)


def draw_bars(out, top, heading, unit, rows, least, most):
    """Bars of (name, value, limit, words) in `unit` on one logarithmic axis from `least` to `most`; a value beyond its limit is vermilion."""
    left, width = 190, 420
    place = lambda value: left + width * math.log(min(max(value, least), most) / least) / math.log(most / least)  # noqa: E731
    out.text(20, top, heading, font_weight='bold')
    bottom = top + 14 + 30 * len(rows)
    for decade in range(math.ceil(math.log10(least) - 1e-9), math.floor(math.log10(most) + 1e-9) + 1):
        out.line(place(10 ** decade), top + 10, place(10 ** decade), bottom, FAINT)
        out.text(place(10 ** decade), bottom + 14, f'{10 ** decade:g}', 'middle', font_size=10)
    out.text(left + width + 14, bottom + 14, unit, font_size=10)
    for row, (name, value, limit, words) in enumerate(rows):
        y = top + 18 + 30 * row
        out.text(left - 8, y + 12, name, 'end')
        out.rect(left, y, place(value) - left, 16, OURS if value <= limit else LIMIT)
        out.line(place(limit), y - 4, place(limit), y + 20, INK, 3)
        out.text(left + width + 14, y + 12, f'{value:.3g} of {limit:.3g} {unit}: {words}' if math.isfinite(limit) else words)
    return bottom + 44


def draw_scene(name, said, target):
    """`said`: lines of scene_check."""
    steps, hands = [], []
    for line in said:
        island = re.match(r' *island of (\d+) \((.*?)\): (\w+)[^;]*; velocity Verlet to (> )?([\d.e+-]+) ms', line)
        if island:
            steps.append((island[2][:26], math.inf if island[4] else float(island[5]), island[3]))
        hand = re.match(r'hand on (.*?): \w+, ([\d.e+-]+) N/mm when pressed.* held by a relaxed hand ([\d.e+-]+)', line)
        if hand:
            hands.append((hand[1][:26], float(hand[2]), float(hand[3])))
    step = next((float(found[1]) for found in (re.match(r'certificate: \w+ at ([\d.e+-]+) ms', line) for line in said) if found), None)
    if step is None or not steps + hands:
        raise ValueError('nothing touches in this scene: there is no certificate to draw')
    rows = [(island, step, limit, 'velocity Verlet is stable too' if step <= limit else BEYOND[verdict]) for island, limit, verdict in steps]
    title = f'{name}: step of the scene against the largest stable step of velocity Verlet, and stiffness against what a relaxed hand bears'
    out = Drawing(960, 66 + (58 + 30 * len(rows) if rows else 0) + (58 + 30 * len(hands) if hands else 0), title)
    out.text(20, 26, f'{name}: certificate', font_size=15, font_weight='bold')
    top = 58
    if rows:
        numbers = [value for _, value, limit, _ in rows for value in (value, limit) if math.isfinite(value)]
        top = draw_bars(out, top, 'Step of the scene; the mark: largest stable step of velocity Verlet, by island', 'ms', rows,
                        10 ** math.floor(math.log10(min(numbers) / 2)), 10 ** math.ceil(math.log10(2 * max(numbers))))
    if hands:
        rows = [(hand, value, limit, 'a relaxed hand holds it' if value <= limit else 'the loop weakens it') for hand, value, limit in hands]
        numbers = [number for _, value, limit, _ in rows for number in (value, limit) if number > 0]
        draw_bars(out, top, 'Stiffness that the hand meets; the mark: the most that it holds', 'N/mm', rows,
                  10 ** math.floor(math.log10(min(numbers) / 2)), 10 ** math.ceil(math.log10(2 * max(numbers))))
    out.write(target)


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ('device', 'scene'):
        sys.exit(__doc__)
    kind, source, target = sys.argv[1:]
    try:
        if kind == 'device':
            draw_device(source, target)
        else:
            draw_scene(source, sys.stdin.read().splitlines(), target)
    except OSError as error:
        sys.exit(f'check: {error.filename or target}: cannot be written: {error.strerror}; give another place by --picture')
    except ValueError as error:
        sys.exit(f'check: {error}')
    print(f'check: picture {os.path.abspath(target)}')


if __name__ == '__main__':
    main()
