"""A session on disk: sub-ID/ses-N below the study's folder. A trial's recording, then its row, are on disk before the next trial
begins; what a kill leaves is read again without the trial that ran.

    trials.csv    one row a trial, in the order in which they ended; columns in trials.json (names of BIDS' behavioural data)
    session.json  study, seed, versions, machine, device, certificates
    study.yaml    the study as it was
    trials/       trial-017.bag: what ./run replay, report and export read
    scenes/       each condition's URDF
    running.json  the trial that runs now; left behind, that trial was interrupted"""
import csv
import errno
import fcntl
import io
import json
import os
import re

from strict_yaml import Refused

TEXT, NUMBER = 'string', 'number'
COLUMNS = {
    'trial': (NUMBER, '1', 'number of the trial in this session, of `trials/trial-NNN.bag` and of ./run replay --trial'),
    'onset': (NUMBER, 's', 'start of the trial after the start of the session; a session that was interrupted counts on'),
    'duration': (NUMBER, 's', 'from onset to the end of the answer'),
    'order': (NUMBER, '1', 'place in the planned order, from 0; a repeated trial has the same one again'),
    'block': (NUMBER, '1', 'block, from 1; 0: practice before the first'),
    'trial_type': (TEXT, '', 'practice, main or catch'),
    'condition': (TEXT, '', 'what was compared or judged'),
    'track': (NUMBER, '1', 'track of a staircase; 0: none'),
    'comparison': (NUMBER, '1', 'interval with the condition, from 1; the other has the standard'),
    'level': (NUMBER, '', 'value of the study\'s parameter in this condition'),
    'status': (TEXT, '', 'ok; skipped; or left out and repeated: interrupted (the program ended), stopped (STOP or a fault), unplugged, '
               'outside (beyond the tolerance), repeated (the experimenter asked)'),
    'response': (TEXT, '', 'the answer'),
    'correct': (TEXT, '', '1 right, 0 wrong, empty where no answer is right'),
    'response_time': (NUMBER, 's', 'from the question to the answer'),
    'nominal_1': (NUMBER, '', 'what the first interval should present, in the unit of `presented_1`'),
    'presented_1': (NUMBER, '', 'what it presented, from tensions and pose: N/m, friction, or kg'),
    'presented_1_error': (NUMBER, '', 'standard error of that'),
    'nominal_2': (NUMBER, '', 'the second interval, likewise'),
    'presented_2': (NUMBER, '', 'the second interval, likewise'),
    'presented_2_error': (NUMBER, '', 'the second interval, likewise'),
    'within_tolerance': (TEXT, '', '1: all that was presented is within the study\'s tolerance; empty: nothing is measured'),
    'peak_force': (NUMBER, 'N', 'largest force on the hand'),
    'mean_force': (NUMBER, 'N', 'mean force on the hand while it touched'),
    'path': (NUMBER, 'm', 'way of the grip while it explored'),
    'contacts': (NUMBER, '1', 'touches that began'),
    'clamped_share': (NUMBER, '1', 'of the ticks in touch in which a limit of the device acted'),
    'softened_share': (NUMBER, '1', 'of the looks in touch in which the contact was weakened to what a relaxed hand bears'),
    'faded_share': (NUMBER, '1', 'of the ticks in touch in which the force was faded, mostly after a hand was let in: the larger of both intervals; '
                    'such ticks do not count in `presented`'),
    'delay_ms': (NUMBER, 'ms', 'mean age of the counts when the loop took them, and half a tick'),
    'added_delay_1_ms': (NUMBER, 'ms', 'that the condition of the first interval adds to pose and force together, in whole ticks'),
    'added_delay_2_ms': (NUMBER, 'ms', 'the second interval, likewise'),
    'missed_ticks': (NUMBER, '1', 'ticks that were lost because the machine was late'),
    'replay_mismatches': (NUMBER, '1', 'ticks that a replay of the recording did not reproduce bit for bit'),
    'recording': (TEXT, '', 'bag of the trial below the session'),
    'note': (TEXT, '', 'of the experimenter, or why the trial ended')}
ACCEPTED = ('ok', 'skipped')
SHOWN_DIGITS = 9


def text_of(value):
    if value is None or (isinstance(value, float) and value != value):
        return ''
    if isinstance(value, bool):
        return str(int(value))
    return f'{value:.{SHOWN_DIGITS}g}' if isinstance(value, float) else ' '.join(str(value).split())  # one line a row


def sync_folder(path):
    folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def why(error):
    return 'the disk is full; free some space and go on with the same command' if error.errno in (errno.ENOSPC, errno.EDQUOT) \
        else error.strerror


def write_whole(path, content):
    """The file is there complete or not at all, also after a loss of power."""
    part = path + '.part'
    try:
        with open(part, 'w', encoding='utf-8') as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
        sync_folder(os.path.dirname(path))
    except OSError as error:
        raise Refused(f'{path}: cannot be written: {why(error)}') from error


def rows_of(path):
    """Complete rows of a trials.csv, as dicts of text, and how many bytes they take: a line that was cut short does not count."""
    try:
        with open(path, 'rb') as file:
            content = file.read()
    except FileNotFoundError:
        return [], 0
    whole = content[:content.rfind(b'\n') + 1]
    return list(csv.DictReader(io.StringIO(whole.decode('utf-8'), newline=''))), len(whole)


def read(path):
    """(info, rows) of a session's folder, for reading only."""
    try:
        with open(os.path.join(path, 'session.json'), encoding='utf-8') as file:
            info = json.load(file)
    except (OSError, ValueError) as error:
        raise Refused(f'{path}: is no session: session.json cannot be read; give the folder sub-ID/ses-N of a study') from error
    return info, rows_of(os.path.join(path, 'trials.csv'))[0]


class SessionFolder:
    """One session, locked while it runs."""

    def __init__(self, root, study, subject, session, seed, info):
        if not re.fullmatch(r'[A-Za-z0-9]{1,32}', subject):
            raise Refused(f"--subject '{subject}': give a pseudonym of letters and digits, as s01: no name is kept")
        self.path = os.path.abspath(os.path.join(root, f'sub-{subject}', f'ses-{session}'))
        self.table = os.path.join(self.path, 'trials.csv')
        self.new = False
        try:
            for folder in ('trials', 'scenes'):
                os.makedirs(os.path.join(self.path, folder), exist_ok=True)
            self.lock = open(os.path.join(self.path, '.lock'), 'w', encoding='utf-8')  # held until the process ends
        except OSError as error:
            raise Refused(f'{self.path}: cannot be made: {why(error)}') from error
        try:
            self._open(study, subject, session, seed, info)
        except BaseException:
            self.lock.close()
            raise

    def _open(self, study, subject, session, seed, info):
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise Refused(f'{self.path}: another program runs this session; end it, or take another --session') from error
        self.new = not os.path.exists(os.path.join(self.path, 'session.json'))
        if self.new:
            self._begin(study, subject, session, seed, info)
        else:
            self._go_on(study, seed)
        self.rows, size = rows_of(self.table)
        if os.path.exists(self.table):
            os.truncate(self.table, size)  # a row that a kill cut short
        if not size:
            self._append(','.join(COLUMNS) + '\n')
        self.interrupted = self._take_interrupted()

    def _begin(self, study, subject, session, seed, info):
        columns = {name: {'Description': what, **({'Units': unit} if unit and kind == NUMBER else {}), 'Format': kind}
                   for name, (kind, unit, what) in COLUMNS.items()}
        write_whole(os.path.join(self.path, 'trials.json'), json.dumps(columns, indent=2) + '\n')
        write_whole(os.path.join(self.path, 'study.yaml'), study.text)
        self.info = {'study': study.name, 'study_file': study.path, 'study_sha256': study.digest, 'subject': subject, 'session': session,
                     'seed': study.seed if seed is None else seed, 'complete': False, 'seconds': 0.0, 'answers': {}, **info}
        self.save_info()

    def _go_on(self, study, seed):
        self.info, _ = read(self.path)
        if self.info['study_sha256'] != study.digest:
            raise Refused(f'{self.path}: was begun with another text of {study.name}; its study.yaml has it. '
                          'Go on with that, or take another --session')
        if self.info['complete']:
            raise Refused(f'{self.path}: is complete; take another --session')
        if seed is not None and seed != self.info['seed']:
            raise Refused(f"{self.path}: was begun with seed {self.info['seed']}, not {seed}; leave --seed out to go on")

    def _take_interrupted(self):
        """The trial that ran when the program ended, as a row that says so."""
        path = os.path.join(self.path, 'running.json')
        try:
            with open(path, encoding='utf-8') as file:
                row = json.load(file)
        except (OSError, ValueError):
            return None
        if any(int(r['trial']) == row['trial'] for r in self.rows):
            return None
        self.append({**row, 'status': 'interrupted', 'note': 'the program ended during this trial'})
        return row

    def save_info(self):
        write_whole(os.path.join(self.path, 'session.json'), json.dumps(self.info, indent=2) + '\n')

    def running(self, row):
        write_whole(os.path.join(self.path, 'running.json'), json.dumps(row) + '\n')

    def _append(self, line):
        """All of it or nothing, on disk."""
        data = line.encode('utf-8')
        table = os.open(self.table, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        before = os.fstat(table).st_size
        try:
            if os.write(table, data) != len(data):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            os.fsync(table)
        except OSError as error:
            os.ftruncate(table, before)
            raise Refused(f'{self.table}: the row could not be written: {why(error)}') from error
        finally:
            os.close(table)
        sync_folder(self.path)

    def append(self, row):
        row = {name: text_of(row.get(name)) for name in COLUMNS}
        out = io.StringIO(newline='')
        csv.DictWriter(out, COLUMNS, lineterminator='\n').writerow(row)
        self._append(out.getvalue())
        self.rows.append(row)

    def next_trial(self):
        return 1 + max((int(row['trial']) for row in self.rows), default=0)

    def elapsed(self):
        """Seconds of the session up to the end of its last row, however the program ended."""
        ends = [float(row['onset']) + float(row['duration'] or 0) for row in self.rows if row['onset']]
        return max([self.info['seconds']] + ends)

    def answers(self):
        """Of the accepted trials in order: right, wrong, or None."""
        return [{'1': True, '0': False}.get(row['correct']) for row in self.rows if row['status'] in ACCEPTED]

    def bag(self, trial):
        return os.path.join('trials', f'trial-{trial:03d}.bag')

    def finish(self, complete):
        self.info['complete'] = complete
        self.save_info()
        try:
            os.unlink(os.path.join(self.path, 'running.json'))
        except FileNotFoundError:
            pass
