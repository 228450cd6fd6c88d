#!/usr/bin/python3
"""Runs a session of a study, on a device or on its twin."""
import argparse
import os
import platform
import signal
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), 'penalty_sim', 'session')]

import study as study_file  # noqa: E402
from strict_yaml import Refused  # noqa: E402
from trial_order import Order  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(prog='./run experiment', description=__doc__)
    parser.add_argument('study', metavar='STUDY', help='name of a file in urdf/experiments, or the path of one')
    parser.add_argument('--subject', metavar='ID', help='pseudonym of letters and digits, as s01')
    parser.add_argument('--session', metavar='N', type=int, default=1, help='of this subject, from 1; one that was interrupted goes on')
    parser.add_argument('--seed', metavar='N', type=int, help='of the order; the study names one')
    parser.add_argument('--device', metavar='D', help='name or file; the study names one')
    parser.add_argument('--output', metavar='FOLDER', help='where the study\'s folder is made; here unless given')
    parser.add_argument('--hardware', action='store_true', help='the real device')
    parser.add_argument('--port', metavar='P', default='', help='serial port of its boards; implies --hardware')
    parser.add_argument('--emulated', action='store_true', help=argparse.SUPPRESS)  # the port's boards are ./run's emulator
    parser.add_argument('--windows', action='store_true', help='a window for the subject and one for the experimenter')
    parser.add_argument('--rviz', action='store_true', help='show the scene to the subject, on a screen of its own where there is one; implies --windows')
    parser.add_argument('--marker-port', metavar='P', default='', help='serial line that gets a byte for each event')
    parser.add_argument('--simulate', metavar='N', type=int, help='a simulated subject, the N-th')
    parser.add_argument('--power', action='store_true', help='how many trials are needed: simulated subjects, no loop')
    parser.add_argument('--program', required=True, help=argparse.SUPPRESS)
    return parser.parse_args()


def provenance(options, study, device, certificates):
    """What a session's file says about how it was made. Nothing about the subject."""
    version = os.environ.get('HAPTIC_VERSION', '')
    return {'device': os.path.splitext(os.path.basename(device))[0], 'device_text': open(device, encoding='utf-8').read(),
            'wire': 'emulated' if options.emulated else 'hardware' if options.hardware or options.port else 'twin', 'simulated': options.simulate,
            'version': version, 'python': platform.python_version(), 'machine': platform.machine(), 'system': platform.platform(),
            'rate': study.rate, 'certificates': certificates}


def refuse_rates(study, device):
    """A real device carries no more than its wire does."""
    from check_study import most_rate
    beyond = [f'{rate:g}' for rate in study.rates() if rate > most_rate(device)]
    if beyond:
        raise Refused(f"{study.path}: {', '.join(beyond)} Hz are beyond the {most_rate(device):g} Hz that {os.path.basename(device)} "
                      'carries; leave those levels out of a copy, or run it on the twin')


def session_front(options):
    from fronts import Front, TerminalFront
    if options.windows or options.rviz:
        from windows import WindowFront
        return WindowFront()
    return Front() if options.simulate is not None else TerminalFront()


def certificates_of(previews, study):
    """What a hand gets of the study's conditions, on the twin."""
    out = []
    for condition in study.conditions + [study.standard] * (study.standard not in study.conditions):
        felt = {**study.standard, **condition}
        look = previews.of(felt)
        out.append({'condition': {k: v for k, v in felt.items() if k != 'scene'}, 'stiffness_n_per_m': look.stiffness,
                    'presented': look.presented.value, 'softened_to': look.share, 'limits': look.clamps})
    return out


def run(options):
    from event_markers import EventMarkers
    from loop_rig import LoopRig
    from preview import Previews, clamp_bits
    from session_folder import SessionFolder
    from session_run import Aborted, SessionRun
    from stack_rig import StackRig
    study = study_file.read(options.study)
    device = os.path.abspath(options.device)
    if options.hardware or options.port:
        refuse_rates(study, device)
    with tempfile.TemporaryDirectory(prefix='haptic_study_') as scenes:
        previews = Previews(study, LoopRig(device), scenes)
        folder = SessionFolder(os.path.join(options.output or '.', study.name), study, options.subject, options.session, options.seed,
                               provenance(options, study, device, certificates_of(previews, study)))
        if folder.interrupted:
            print(f"experiment: trial {folder.interrupted['trial']} was interrupted; it is repeated", file=sys.stderr)
        order = Order(study, options.subject, options.session, folder.info['seed'])
        front = session_front(options)
        if study.questionnaire and not folder.info['answers'] and options.simulate is None:
            folder.info['answers'] = front.questionnaire(study.questionnaire)
            folder.save_info()
        rig = StackRig(device, 'file' if options.hardware or options.port else 'twin', os.path.join(folder.path, 'stack.log'),
                       options.program, port=options.port, simulated=options.simulate is not None)
        if options.rviz:
            from scene_view import SceneView
            front.scene = SceneView(os.path.join(folder.path, 'view.log'))
        if options.simulate is None:
            print(f"experiment: in other shells: . build/devel/setup.sh; export ROS_MASTER_URI={os.environ['ROS_MASTER_URI']}",
                  file=sys.stderr)
        markers = EventMarkers(options.marker_port, rig.publish_marker)
        session = SessionRun(study, order, folder, rig, front, markers, previews.nominal, options.simulate, clamp_bits())

        def work():
            try:
                session.run()
                print(f"experiment: {sum(r['status'] == 'ok' for r in folder.rows)} trials of {len(folder.rows)} rows are in {folder.path}")
                return 0
            except (Aborted, KeyboardInterrupt):
                folder.finish(False)
                print(f'experiment: ended; {folder.path} has {len(folder.rows)} rows; the same command goes on', file=sys.stderr)
                return 3
            except Refused as refusal:
                print(f'experiment: {refusal}', file=sys.stderr)
                return 1
            finally:
                if rig.compute_missed:
                    print(f'experiment: in {rig.compute_missed} tenths of a second a tick took longer than its period', file=sys.stderr)
                rig.close()
        return front.run(work)


def main():
    options = arguments()
    signal.signal(signal.SIGTERM, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt()))
    try:
        if options.power:
            import power
            return power.main(study_file.read(options.study), options)
        if not options.subject:
            raise Refused('--subject is missing: give a pseudonym of letters and digits, as s01')
        return run(options)
    except Refused as refusal:
        print(f'experiment: {refusal}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


if __name__ == '__main__':
    sys.exit(main())
