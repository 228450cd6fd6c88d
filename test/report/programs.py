"""Where the report's programs are, and the machine. As a program it prints the machine's name, as results files have it."""
import glob
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
WASM_PEERS = os.path.join(ROOT, 'test', 'peers', 'wasm')
sys.path.insert(0, os.path.join(ROOT, 'penalty_sim', 'session'))
import npm_modules  # noqa: E402


def find(folder, name):
    """Path of a built program below `folder`; None when it is not there."""
    found = [path for path in glob.glob(os.path.join(folder, '**', name), recursive=True)
             if os.path.isfile(path) and os.access(path, os.X_OK)]
    return min(found, key=len) if found else None


def fetched_wasm_peers():
    """Folder of the engines in WebAssembly, if a report or bench has fetched them before, else ''. Asks no registry."""
    folder = os.path.join(npm_modules.KEPT, npm_modules.digest('package-lock.json', source=WASM_PEERS))
    return folder if os.path.isdir(folder) else ''


def machine():
    """This machine, in one line: times of another one are not comparable."""
    with open('/proc/cpuinfo') as file:
        model = next((line.split(':', 1)[1].strip() for line in file if line.startswith('model name')), '?')
    return f'{model}, {os.cpu_count()} cores, {os.uname().sysname} {os.uname().release}'


if __name__ == '__main__':
    print(machine())
