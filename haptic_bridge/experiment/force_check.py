"""A short first-motion and force check, before a block: the device pushes the grip softly along its three axes, both ways, one after the
other, and the grip must give way to each push.

Strings only pull: those that turn the wrong way, hang on the wrong motor or have no power leave one of the six ways without force. The
force is the weight of a body of 0.1 kg on the grip (urdf/experiments/scenes/force_check.urdf), faded in and out by the loop. A hand that
holds on is stiff and not wrong: a small way is a warning, a way against or across the push or none at all is refused. Takes 2 s a way."""
import os
import time
from dataclasses import dataclass

import numpy as np

import condition_scene
from stack_rig import SOFT_START

SCENE = os.path.join(os.path.dirname(os.path.dirname(condition_scene.HERE)), 'urdf', 'experiments', 'scenes', 'force_check.urdf')
MASS = 0.1             # of that scene's body [kg]
PUSHES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
LOOK = 0.15            # for so long a place and a force are averaged [s]
SETTLE = 0.3           # a relaxed hand of 500 N/m and 8 N s/m swings no more then [s]
AGAINST = 5e-4         # a hand that trembles moves less by itself [m]
LEAST_WAY = 1e-4       # of a hand of 5000 N/m per 0.5 N: none is stiffer; so the force is not there [m]
FIRM = 3000.0          # [N/m]: who holds on like this feels no study
FORCE_ERROR = 0.15     # of the force that the tensions give: lambda's share is 3 %


@dataclass
class Push:
    """What one of the directions came to."""
    direction: list   # unit, in the device's base
    asked: float      # [N]
    given: float      # along it, by the tensions and the pose [N]
    along: float      # way of the grip along it [m]
    across: float     # [m]


def judged(pushes):
    """(why the device is refused or '', what is warned of or '')."""
    against = [p for p in pushes if p.along < -AGAINST or (p.across > p.along and p.across > AGAINST)]
    still = [p for p in pushes if abs(p.along) < LEAST_WAY]
    weak = [p for p in pushes if abs(p.given / p.asked - 1) > FORCE_ERROR]
    firm = [p for p in pushes if p.along < p.asked / FIRM]
    name = lambda p: '(' + ', '.join(f'{v:g}' for v in p.direction) + ')'  # noqa: E731
    if against:
        p = against[0]
        return (f'pushed with {p.asked:.1f} N along {name(p)} the grip moved {1e3 * p.along:+.1f} mm along it and {1e3 * p.across:.1f} mm '
                'across: look at the strings and at the signs of the motors', '')
    if still:
        p = still[0]
        return (f'pushed with {p.asked:.1f} N along {name(p)} the grip did not move: are the motors powered, and is the grip held loosely?',
                '')
    if weak:
        p = weak[0]
        return '', f'of {p.asked:.2f} N along {name(p)} the strings give {p.given:.2f} N'
    if firm:
        p = firm[0]
        return '', (f'pushed with {p.asked:.1f} N the grip moved {1e3 * p.along:.2f} mm: a hand of more than {FIRM:.0f} N/m; '
                    'let it hold more loosely')
    return '', ''


def scenes(newtons, rate, folder):
    """Of each push, written below `folder`."""
    with open(SCENE, encoding='utf-8') as file:
        text = file.read()
    out = []
    for i, push in enumerate(PUSHES):
        down = ' '.join(repr(float(v)) for v in newtons / MASS * push)
        path = os.path.join(folder, f'force_check-{rate:g}-{i + 1}.urdf')
        changed = condition_scene.changed_text(SCENE, text, [], {'rate': rate}).replace('gravity="0 0 -8"', f'gravity="{down}"')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(changed)
        out.append(path)
    return out


def look(rig, wait):
    """Mean place and force over LOOK [m], [N]."""
    places, forces, end = [], [], time.monotonic() + LOOK
    while time.monotonic() < end:
        wait(0.01)
        places.append(rig.pose)
        forces.append(rig.wrench)
    return np.mean(places, axis=0), np.mean(forces, axis=0)


def check(rig, newtons, rate, folder, wait, ready):
    """The pushes. `wait(seconds)` lets time pass, `ready()` returns when the grip is at home."""
    out = []
    for push, scene in zip(PUSHES, scenes(newtons, rate, folder)):
        rig.load(scene, rate)
        rig.fade_out()
        ready()
        before, rest = look(rig, wait)
        rig.fade_in()
        wait(SOFT_START + SETTLE)
        after, force = look(rig, wait)
        way = after - before
        along = float(way @ push)
        out.append(Push([float(v) for v in push], newtons, float((force - rest) @ push), along,
                        float(np.linalg.norm(way - along * push))))
    rig.fade_out()
    return out
