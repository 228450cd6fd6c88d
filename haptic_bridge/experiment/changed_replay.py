#!/usr/bin/python3
"""A recorded trial through a changed world: the same hand, step by step, in another stiffness, friction or mass."""
import argparse
import os
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), 'penalty_sim', 'session')]

import numpy as np  # noqa: E402
import rosbag  # noqa: E402

import condition_scene  # noqa: E402
import session_data  # noqa: E402
import session_folder  # noqa: E402
import study as study_file  # noqa: E402
from strict_yaml import Refused  # noqa: E402

CHANGEABLE = sorted(k for k, v in study_file.PROPERTIES.items() if v[1] is not None and k != 'rate' and k not in study_file.DELAYS)


def change_of(word):
    """{property: value} of KEY=VALUE."""
    key, _, value = word.partition('=')
    if key not in CHANGEABLE:
        raise Refused(f"--with {word}: '{key}' cannot be changed; there are {', '.join(CHANGEABLE)}, as stiffness=2e7")
    _, low, high = study_file.PROPERTIES[key]
    try:
        number = float(value)
    except ValueError:
        number = float('nan')
    if not low <= number <= high:
        raise Refused(f'--with {word}: give {key} from {low:g} to {high:g}')
    return {key: number}


def write_changed(bag, study, change, out):
    """The recording with each scene under `change`. The build is renamed: its hashes are not those of this world."""
    with rosbag.Bag(bag) as recorded, rosbag.Bag(out, 'w') as changed:
        for topic, message, stamp in recorded.read_messages():
            if topic.endswith('recorded/session'):
                message.scene_text = condition_scene.changed_text(message.scene_file, message.scene_text, study.target, change)
                message.scene_file, message.build = os.path.basename(message.scene_file), 'a changed world'
            changed.write(topic, message, stamp)


def line(name, sessions):
    hand = sessions[0].hands()[0]
    axes = [np.concatenate([s.table[f'{hand}.achieved_force_{a}'] for s in sessions]) for a in 'xyz']
    force = np.linalg.norm(np.stack(axes, axis=1), axis=1)
    depth = np.concatenate([s.table[f'{hand}.contact_depth'] for s in sessions])
    print(f'  {name:10s} peak force {force.max():.3f} N, mean in touch {force[depth > 0].mean() if (depth > 0).any() else 0:.3f} N, '
          f'deepest {1e3 * depth.max():.3f} mm')
    return force


def main():
    parser = argparse.ArgumentParser(prog='./run replay', description=__doc__)
    parser.add_argument('session')
    parser.add_argument('bag')
    parser.add_argument('--with', dest='changes', action='append', default=[])
    parser.add_argument('--program', required=True)
    options = parser.parse_args()
    try:
        info, _ = session_folder.read(options.session)
        study = study_file.read(info['study_file'] if os.path.exists(info['study_file']) else os.path.join(options.session, 'study.yaml'))
        change = {k: v for word in options.changes for k, v in change_of(word).items()}
        with tempfile.TemporaryDirectory(prefix='haptic_changed_') as folder:
            bag = os.path.join(folder, 'changed.bag')
            write_changed(options.bag, study, change, bag)
            print(f"{os.path.basename(options.bag)} with {', '.join(options.changes)}: the recorded hand is led through the changed world. "
                  'It does not react: a real hand would have moved otherwise')
            before = line('recorded', session_data.read(options.bag, options.program))
            after = line('changed', session_data.read(bag, options.program))
        print(f'figure replay.changed_force_n_max {np.abs(after - before).max():.6g} N')
    except (Refused, session_data.Refused) as refusal:
        print(f'replay: {refusal}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
