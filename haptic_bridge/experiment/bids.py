"""A study's folder as a BIDS dataset of behavioural data (bids-specification 1.8, "Behavioral experiments (with no neural recordings)"):

    dataset_description.json, README, participants.tsv, .bidsignore   of the study
    sub-ID/ses-N/beh/sub-ID_ses-N_task-STUDY_beh.tsv, .json           of each session: its trials.csv in BIDS' words

All of it is written anew from the sessions on disk; the recordings and what else a session leaves stand in .bidsignore."""
import glob
import json
import os
import re

import session_folder
from session_folder import COLUMNS, NUMBER, write_whole

VERSION = '1.8.0'
IGNORED = ('results*', '*.sessions.json', 'sub-*/ses-*/trials*', 'sub-*/ses-*/scenes/', 'sub-*/ses-*/*.json', 'sub-*/ses-*/*.yaml',
           'sub-*/ses-*/*.log', 'sub-*/ses-*/.lock')
README = '''Behavioural data of the study "{title}", recorded on a haptic device with SPIDAR haptics.

Each row of a _beh.tsv is a trial; its columns are described in the JSON file beside it. Trials whose status is not ok were left out or
repeated. The recordings of all trials, bit for bit, stand in sub-*/ses-*/trials and are not part of BIDS.
'''


def name_of_task(study):
    """BIDS' labels have letters and digits alone."""
    return re.sub(r'[^A-Za-z0-9]', '', study) or 'study'


def table(columns, rows):
    """Tab-separated, n/a where there is nothing."""
    cell = lambda value: str(value).replace('\t', ' ') if value not in ('', None) else 'n/a'  # noqa: E731
    return '\n'.join('\t'.join(line) for line in [columns] + [[cell(row.get(c)) for c in columns] for row in rows]) + '\n'


def sidecar(info):
    about = {'TaskName': info['study'], 'Instructions': 'see study.yaml', 'InstitutionName': 'n/a', 'SoftwareVersions': info.get('version', '') or 'n/a',
             'Manufacturer': 'n/a', 'ManufacturersModelName': info.get('device', '') or 'n/a'}
    for column, (kind, unit, what) in COLUMNS.items():
        about[column] = {'LongName': column.replace('_', ' '), 'Description': what, **({'Units': unit} if unit and kind == NUMBER else {})}
    return about


def write_session(path, info, rows):
    folder = os.path.join(path, 'beh')
    os.makedirs(folder, exist_ok=True)
    base = os.path.join(folder, f"sub-{info['subject']}_ses-{info['session']}_task-{name_of_task(info['study'])}_beh")
    # BIDS wants onset and duration first where a table has both.
    columns = ['onset', 'duration'] + [c for c in COLUMNS if c not in ('onset', 'duration')]
    write_whole(base + '.tsv', table(columns, rows))
    write_whole(base + '.json', json.dumps(sidecar(info), indent=2) + '\n')


def write(root, title):
    """All sessions below the study's folder. Raises Refused where the disk does not take it."""
    subjects = {}
    for path in sorted(glob.glob(os.path.join(root, 'sub-*', 'ses-*'))):
        if not os.path.exists(os.path.join(path, 'session.json')):
            continue
        info, rows = session_folder.read(path)
        write_session(path, info, rows)
        subjects.setdefault(info['subject'], []).append(info)
    described = {'Name': title, 'BIDSVersion': VERSION, 'DatasetType': 'raw', 'License': 'n/a',
                 'GeneratedBy': [{'Name': 'SPIDAR haptics'}]}
    write_whole(os.path.join(root, 'dataset_description.json'), json.dumps(described, indent=2) + '\n')
    write_whole(os.path.join(root, 'README'), README.format(title=title))
    write_whole(os.path.join(root, '.bidsignore'), '\n'.join(IGNORED) + '\n')
    rows = [{'participant_id': 'sub-' + s, 'sessions': len(infos), 'simulated': 'yes' if any(i.get('simulated') is not None for i in infos) else 'no'}
            for s, infos in sorted(subjects.items())]
    write_whole(os.path.join(root, 'participants.tsv'), table(['participant_id', 'sessions', 'simulated'], rows))
    columns = {'participant_id': {'Description': 'pseudonym'}, 'sessions': {'Description': 'sessions of this study on disk'},
               'simulated': {'Description': 'a subject in software', 'Levels': {'yes': 'simulated', 'no': 'a person'}}}
    write_whole(os.path.join(root, 'participants.json'), json.dumps(columns, indent=2) + '\n')
