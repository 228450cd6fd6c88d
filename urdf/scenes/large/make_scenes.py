#!/usr/bin/env python3
"""Writes the large scenes beside this file: city.yaml and pile300.yaml, and the models that they list.

    python3 urdf/scenes/large/make_scenes.py [FOLDER]

A test compares the files with what this writes. Lengths in metres, masses in kilograms, angles in radians.
"""
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
TURNS = os.path.join(HERE, '..', '..', '..', 'test', 'scenes', 'heap_poses.h')  # orientations of a heap's cubes
STIFFNESS, GRAVITY = 1e7, 9.8  # of all contacts [N/m³]; [m/s²]
COLOURS = ('0.8 0.3 0.25 1', '0.35 0.65 0.35 1', '0.25 0.45 0.8 1', '0.85 0.65 0.2 1', '0.55 0.4 0.7 1')

HEAD = '''<?xml version="1.0"?>
<!-- {comment} Written by make_scenes.py. -->
<robot name="{name}" xmlns:haptic="https://haptic/urdf">
  <link name="world"/>
'''


def number(value):
    return f'{value:.9g}'


def body(name, size, place, kind='floating', turn=(0, 0, 0), mass=0, colour='0.72 0.6 0.45 1'):
    """A box of `size`, as a link and its joint to the world."""
    sides = ' '.join(number(side) for side in size)
    inertia = [mass / 12 * (size[1] ** 2 + size[2] ** 2), mass / 12 * (size[0] ** 2 + size[2] ** 2),
               mass / 12 * (size[0] ** 2 + size[1] ** 2)]
    inertial = (f'    <inertial><mass value="{number(mass)}"/><inertia ixx="{number(inertia[0])}" iyy="{number(inertia[1])}" '
                f'izz="{number(inertia[2])}" ixy="0" ixz="0" iyz="0"/></inertial>\n') if mass > 0 else ''
    rpy = ' rpy="' + ' '.join(number(angle) for angle in turn) + '"' if any(turn) else ''
    return (f'  <link name="{name}">\n{inertial}'
            f'    <visual><geometry><box size="{sides}"/></geometry><material name="{name}"><color rgba="{colour}"/></material></visual>\n'
            f'    <collision><geometry><box size="{sides}"/></geometry></collision>\n  </link>\n'
            f'  <joint name="{name}_joint" type="{kind}">\n    <origin xyz="{" ".join(number(x) for x in place)}"{rpy}/>\n'
            f'    <parent link="world"/><child link="{name}"/>\n  </joint>\n')


def stack(height=5, side=0.1, mass=0.1):
    """Cubes on one another, each as deep in the one below as what lies above presses it."""
    depth, top, text = mass * GRAVITY / (STIFFNESS * side * side), 0.0, ''
    for i in range(height):
        top -= (height - i) * depth
        text += body(f'block{i}', (side,) * 3, (0, 0, top + side / 2), mass=mass, colour=COLOURS[i % len(COLOURS)])
        top += side
    comment = f'{height} cubes on one another: a model of city.yaml, whose floor they stand on.'
    return HEAD.format(name=f'stack{height}', comment=comment) + text + '</robot>\n'


def heap(count, per_side, side=0.05, mass=0.1, pitch=0.075, layer=0.09):
    """Cubes over a bin, in layers, each in an orientation of its own: they fall and make a heap."""
    turns = [tuple(float(x) for x in row) for row in re.findall(r'\{(-?[\d.e-]+), (-?[\d.e-]+), (-?[\d.e-]+)\}', open(TURNS).read())]
    inner, wall = per_side * pitch + 0.02, 0.2
    height, out = 2.0, 0.5 * (inner + wall)
    text = ''
    for name, size, x, y in (('wall_px', (wall, inner + 2 * wall, height), out, 0), ('wall_nx', (wall, inner + 2 * wall, height), -out, 0),
                             ('wall_py', (inner, wall, height), 0, out), ('wall_ny', (inner, wall, height), 0, -out)):
        text += body(name, size, (x, y, height / 2), 'fixed', colour='0.6 0.6 0.65 0.15')
    for i in range(count):
        up, row, column = i // per_side ** 2, i // per_side % per_side, i % per_side
        middle = 0.5 * (per_side - 1)
        text += body(f'c{i}', (side,) * 3, ((column - middle) * pitch, (row - middle) * pitch, 0.05 + up * layer), turn=turns[i], mass=mass,
                     colour=COLOURS[i % len(COLOURS)])
    return HEAD.format(name=f'heap{count}', comment=f'{count} cubes that fall into a bin without a floor.') + text + '</robot>\n'


POINTER = '''  <link name="pointer">
    <inertial><mass value="0.05"/><inertia ixx="2e-06" iyy="2e-06" izz="2e-06" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><sphere radius="0.01"/></geometry><material name="pointer"><color rgba="0.9 0.4 0.1 1"/></material></visual>
    <collision><geometry><sphere radius="0.01"/></geometry></collision>
  </link>
  <joint name="pointer_joint" type="floating">
    <origin xyz="{place}"/>
    <parent link="world"/><child link="pointer"/>
  </joint>
'''

DOOR = '''  <link name="door">
    <inertial><origin xyz="0 0.1 0"/><mass value="0.5"/><inertia ixx="0.0033" iyy="0.0017" izz="0.0017" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0.1 0"/><geometry><box size="0.01 0.2 0.2"/></geometry>\
<material name="wood"><color rgba="0.72 0.6 0.45 1"/></material></visual>
    <collision><origin xyz="0 0.1 0"/><geometry><box size="0.01 0.2 0.2"/></geometry></collision>
  </link>
  <joint name="door_joint" type="revolute">
    <origin xyz="-0.6 0.5 0.12"/>
    <parent link="world"/><child link="door"/>
    <axis xyz="0 0 -1"/>
    <limit lower="0" upper="1.5" effort="0" velocity="10"/>
    <dynamics damping="0.01" friction="0.02"/>
  </joint>
  <link name="drawer">
    <inertial><mass value="0.5"/><inertia ixx="0.002" iyy="0.002" izz="0.003" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.2 0.2 0.06"/></geometry><material name="drawer"><color rgba="0.6 0.6 0.65 1"/></material></visual>
    <collision><geometry><box size="0.2 0.2 0.06"/></geometry></collision>
  </link>
  <joint name="drawer_joint" type="prismatic">
    <origin xyz="-0.6 -0.5 0.1"/>
    <parent link="world"/><child link="drawer"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.15" effort="0" velocity="10"/>
    <dynamics damping="1" friction="0.5"/>
  </joint>
'''

PATH = '''devices:
  - device: spidar
    pointer: pointer
    repeat: 20
    waypoints:
      - {time: 0.5, xyz: [0, 0, 0]}
      - {time: 1.5, xyz: [0, 0, -0.012]}
      - {time: 2.5, xyz: [0.006, 0, -0.012]}
      - {time: 3.5, xyz: [0, 0, 0]}
'''


def listed(name, comment, models):
    return (f'# {comment} Written by make_scenes.py.\nname: {name}\nsettings: {{step: 0.001}}\n'
            f'material: {{stiffness: {STIFFNESS:.1e}, mu_static: 0.5, mu_dynamic: 0.5}}\nmodels:\n' + ''.join(models) + PATH)


def model(file, prefix='', place=None, more=''):
    pose = f', pose: {{xyz: [{", ".join(number(x) for x in place)}]}}' if place else ''
    return '  - {file: ' + file + (f', prefix: {prefix}' if prefix else '') + pose + more + '}\n'


def city():
    """150 stacks of five in streets about a place of 2 m, on which the hand, a heap of 100, two robots, a door and a drawer are."""
    pitch, places = 0.3, []
    for row in range(-8, 8):
        for column in range(-8, 8):
            x, y = (column + 0.5) * pitch, (row + 0.5) * pitch
            if max(abs(x), abs(y)) > 1.2:
                places.append((x, y, 0))
    places = sorted(places, key=lambda p: (p[0] ** 2 + p[1] ** 2, p))[:149]
    models = [model('city_ground.urdf'), model('stack5.urdf', 's000_')]
    models += [model('stack5.urdf', f's{i + 1:03d}_', place) for i, place in enumerate(places)]
    models.append(model('heap100.urdf', 'heap_', (0.7, 0, 0)))
    joints = ', joints: {panda_joint2: 0.2, panda_joint4: -2.2, panda_joint6: 2.55, panda_joint7: 0.785}'
    for prefix, y in (('left_', 0.75), ('right_', -0.75)):
        models.append(model('package://example-robot-data/robots/panda_description/urdf/panda.urdf', prefix, (-0.2, y, 0),
                            ', drive: hold' + joints))
    return listed('city', 'A hand among 850 cubes in 150 stacks and a heap, two Pandas that hold their poses, a door and a drawer.', models)


def files():
    """By name: its text."""
    ground = body('floor', (8, 8, 0.5), (0, 0, -0.25), 'fixed')
    pile = body('floor', (2, 2, 0.5), (0, 0, -0.25), 'fixed')
    return {
        'stack5.urdf': stack(),
        'heap100.urdf': heap(100, 4),
        'heap300.urdf': heap(300, 5),
        'city_ground.urdf': HEAD.format(name='city_ground', comment='Floor, door, drawer and pointer of city.yaml.') + ground + DOOR +
                            POINTER.format(place='0 0 0.515') + '</robot>\n',
        'city.yaml': city(),
        'pile300_ground.urdf': HEAD.format(name='pile300_ground', comment='Floor and pointer of pile300.yaml.') + pile +
                               POINTER.format(place='0 0 1.4') + '</robot>\n',
        'pile300.yaml': listed('pile300', 'A hand over 300 cubes that fall into a bin.',
                               [model('pile300_ground.urdf'), model('heap300.urdf')]),
    }


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else HERE
    for name, text in files().items():
        with open(os.path.join(folder, name), 'w', encoding='utf-8') as file:
            file.write(text)


if __name__ == '__main__':
    main()
