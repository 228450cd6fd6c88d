#!/usr/bin/env python3
"""Writes the large scenes beside this file: city.yaml, pile300.yaml and workshop.yaml, and the models that they list.

    python3 urdf/scenes/large/make_scenes.py [FOLDER]

A test compares the files with what this writes. Lengths in metres, masses in kilograms, angles in radians.
"""
import math
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
    return (f'# {comment} Written by make_scenes.py.\nname: {name}\nsettings: {{step: 0.001, far_step: 0.001}}\n'
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


STEEL, WOOD, RUBBER, BRASS = '0.55 0.57 0.6 1', '0.72 0.52 0.3 1', '0.18 0.18 0.2 1', '0.8 0.65 0.3 1'
PEG, BEFORE_WALL = 0.012, 0.035  # side of a peg; where tools hang before the wall [m]


def moments(kind, size):
    """Of a box or an upright cylinder (radius, length) of 1 kg, about its middle [m²]."""
    if kind == 'box':
        x, y, z = size
        return (y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12
    radius, length = size
    side = radius * radius / 4 + length * length / 12
    return side, side, radius * radius / 2


def tool(name, place, parts):
    """A body of `parts` (kind, size, middle, mass, colour), whose frame is at `place`."""
    mass = sum(part[3] for part in parts)
    middle = [sum(part[3] * part[2][axis] for part in parts) / mass for axis in range(3)]
    inertia = [0.0, 0.0, 0.0]
    shapes = ''
    for i, (kind, size, at, part_mass, colour) in enumerate(parts):
        away = [(at[axis] - middle[axis]) ** 2 for axis in range(3)]
        for axis, own in enumerate(moments(kind, size)):
            inertia[axis] += part_mass * (own + sum(away) - away[axis])
        words = (f'box size="{" ".join(number(side) for side in size)}"' if kind == 'box' else
                 f'cylinder radius="{number(size[0])}" length="{number(size[1])}"')
        origin = f'<origin xyz="{" ".join(number(x) for x in at)}"/>'
        shapes += (f'    <visual>{origin}<geometry><{words}/></geometry><material name="{name}_{i}"><color rgba="{colour}"/></material>'
                   f'</visual>\n    <collision>{origin}<geometry><{words}/></geometry></collision>\n')
    ixx, iyy, izz = (number(moment) for moment in inertia)
    return (f'  <link name="{name}">\n    <inertial><origin xyz="{" ".join(number(x) for x in middle)}"/><mass value="{number(mass)}"/>'
            f'<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial>\n{shapes}  </link>\n'
            f'  <joint name="{name}_joint" type="floating">\n    <origin xyz="{" ".join(number(x) for x in place)}"/>\n'
            f'    <parent link="world"/><child link="{name}"/>\n  </joint>\n')


def hanging(name, y, top, head, handle, masses, colours):
    """Two pegs whose upper sides are at `top`, and between them a tool's handle; its head lies on both, as deep as its weight presses."""
    depth, width, height = head
    thick, length = handle
    gap = thick + 0.012
    sink = sum(masses) * GRAVITY / (STIFFNESS * 2 * PEG * depth)
    pegs = ''.join(body(f'{name}_peg{i}', (0.06, PEG, PEG), (0.03, y + side * (gap + PEG) / 2, top - PEG / 2), 'fixed', colour=BRASS)
                   for i, side in enumerate((-1, 1)))
    parts = [('box', head, (0, 0, height / 2), masses[0], colours[0]), ('box', (thick, thick, length), (0, 0, -length / 2), masses[1], colours[1])]
    return pegs + tool(name, (BEFORE_WALL, y, top - sink), parts)


def lying(name, x, y, top, parts):
    """A tool on a shelf whose upper side is at `top`: its first part lies there, as deep as the whole presses it."""
    kind, size = parts[0][:2]
    area = size[0] * size[1] if kind == 'box' else math.pi * size[0] ** 2
    sink = sum(part[3] for part in parts) * GRAVITY / (STIFFNESS * area)
    return tool(name, (x, y, top - sink), parts)


def workshop():
    """21 tools hang on pegs in three rows, nine lie on a shelf below them."""
    text = body('floor', (3, 3, 0.5), (0, 0, -0.25), 'fixed') + body('wall', (0.05, 2.4, 1.9), (-0.025, 0, 0.95), 'fixed', colour='0.8 0.78 0.72 1')
    hung = (('hammer', (0.03, 0.11, 0.03), (0.025, 0.28), (0.5, 0.12), (STEEL, WOOD)), ('mallet', (0.05, 0.12, 0.07), (0.03, 0.26), (0.4, 0.15), (RUBBER, WOOD)),
            ('hatchet', (0.025, 0.14, 0.09), (0.03, 0.3), (0.6, 0.2), (STEEL, WOOD)), ('pick', (0.025, 0.22, 0.025), (0.03, 0.32), (0.7, 0.25), (STEEL, WOOD)),
            ('brush', (0.04, 0.1, 0.03), (0.02, 0.18), (0.05, 0.05), (WOOD, WOOD)), ('scraper', (0.02, 0.09, 0.06), (0.02, 0.15), (0.1, 0.08), (STEEL, RUBBER)),
            ('square', (0.02, 0.2, 0.03), (0.015, 0.3), (0.15, 0.1), (WOOD, STEEL)))
    for row, top in enumerate((1.7, 1.3, 0.9)):
        for column, (name, head, handle, masses, colours) in enumerate(hung):
            size = 1 - 0.12 * row  # each row is smaller than the one above it
            scaled = [tuple(size * side for side in sides) for sides in (head, handle)]
            text += hanging(f'{name}{row}', -0.9 + 0.3 * column, top, *scaled, [size ** 3 * mass for mass in masses], colours)
    shelf = 0.4
    text += body('shelf', (0.3, 2.2, 0.03), (0.15, 0, shelf - 0.015), 'fixed')
    on_it = (('level', [('box', (0.03, 0.3, 0.05), (0, 0, 0.025), 0.4, '0.85 0.65 0.2 1')]),
             ('plane', [('box', (0.06, 0.2, 0.03), (0, 0, 0.015), 0.8, STEEL), ('box', (0.02, 0.03, 0.05), (0, -0.06, 0.055), 0.05, WOOD)]),
             ('tin', [('cylinder', (0.04, 0.1), (0, 0, 0.05), 0.3, '0.25 0.45 0.8 1')]), ('file', [('box', (0.02, 0.25, 0.006), (0, 0, 0.003), 0.15, STEEL)]),
             ('tape', [('cylinder', (0.035, 0.025), (0, 0, 0.0125), 0.2, '0.8 0.3 0.25 1')]),
             ('box', [('box', (0.15, 0.2, 0.12), (0, 0, 0.06), 1.5, '0.35 0.5 0.35 1'), ('box', (0.02, 0.12, 0.02), (0, 0, 0.13), 0.1, RUBBER)]),
             ('jar', [('cylinder', (0.03, 0.08), (0, 0, 0.04), 0.2, '0.55 0.4 0.7 1'), ('cylinder', (0.032, 0.015), (0, 0, 0.0875), 0.05, BRASS)]),
             ('clamp', [('box', (0.03, 0.2, 0.01), (0, 0, 0.005), 0.3, STEEL), ('box', (0.03, 0.015, 0.06), (0, -0.09, 0.04), 0.15, STEEL)]),
             ('block', [('box', (0.08, 0.08, 0.08), (0, 0, 0.04), 0.25, WOOD)]))
    y = -0.95
    for name, parts in on_it:
        kind, size = parts[0][:2]
        half = size[1] / 2 if kind == 'box' else size[0]
        text += lying(f'shelf_{name}', 0.15, y + half, shelf, parts)
        y += 2 * half + 0.05
    hammer = (BEFORE_WALL, -0.9, 1.7 + 0.03)  # the hand is above its head
    return HEAD.format(name='workshop_wall', comment='Wall, shelf, 30 tools and pointer of workshop.yaml.') + text + \
        POINTER.format(place=' '.join(number(x) for x in (hammer[0], hammer[1], hammer[2] + 0.015))) + '</robot>\n'


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
        'workshop_wall.urdf': workshop(),
        'workshop.yaml': listed('workshop', 'A hand before a wall on which 21 tools hang, and a shelf with nine.', [model('workshop_wall.urdf')]),
    }


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else HERE
    for name, text in files().items():
        with open(os.path.join(folder, name), 'w', encoding='utf-8') as file:
            file.write(text)


if __name__ == '__main__':
    main()
