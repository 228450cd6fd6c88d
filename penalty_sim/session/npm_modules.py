"""The packages of a package-lock.json, fetched by npm once and kept below build/: no code of others is in this repository."""
import fcntl
import hashlib
import os
import shutil
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
VIEW = os.path.join(HERE, 'view3d')
KEPT = os.path.join(HERE, '..', '..', 'build', 'npm')
PATIENCE = 120  # for a registry that does not answer [s]


class Unavailable(Exception):
    """One line that says why and what to do."""


def digest(*names, source=VIEW):
    """Of the contents of files of `source`."""
    total = hashlib.sha256()
    for name in names:
        with open(os.path.join(source, name), 'rb') as file:
            total.update(file.read())
    return total.hexdigest()[:16]


def modules(source=VIEW):
    """Folder that holds node_modules as the lock in `source` pins them, by their sums. Raises Unavailable."""
    folder = os.path.join(KEPT, digest('package-lock.json', source=source))
    if os.path.isdir(folder):
        return folder
    if not shutil.which('npm'):
        raise Unavailable('npm is not here: ./run setup npm')
    os.makedirs(KEPT, exist_ok=True)
    with open(os.path.join(KEPT, 'lock'), 'w', encoding='utf-8') as lock:  # two calls at once fetch once
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not os.path.isdir(folder):
            fetch(folder, source)
    return folder


def fetch(folder, source):
    with tempfile.TemporaryDirectory(dir=KEPT) as fresh:
        for name in ('package.json', 'package-lock.json'):
            shutil.copy(os.path.join(source, name), fresh)
        try:
            done = subprocess.run(['npm', 'ci', '--ignore-scripts', '--no-audit', '--no-fund', '--fetch-retries=1'], cwd=fresh, check=False,
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE)
        except subprocess.TimeoutExpired as error:
            raise Unavailable(f'npm did not end within {PATIENCE} s: its registry cannot be reached from here') from error
        if done.returncode != 0:
            said = [line for line in done.stderr.splitlines() if line.startswith('npm ') and 'code' in line] or done.stderr.splitlines()
            raise Unavailable(f'npm could not fetch its packages ({said[0].strip() if said else "no reason given"}): try again where its '
                              'registry can be reached')
        os.rename(fresh, folder)
        os.makedirs(fresh)  # for the end of the block
