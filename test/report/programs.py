"""Where the report's programs are, and the machine. As a program it prints the machine's name, as results files have it."""
import glob
import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def find(folder, name):
    """Path of a built program below `folder`; None when it is not there."""
    found = [path for path in glob.glob(os.path.join(folder, '**', name), recursive=True)
             if os.path.isfile(path) and os.access(path, os.X_OK)]
    return min(found, key=len) if found else None


def machine():
    """This machine, in one line: times of another one are not comparable."""
    with open('/proc/cpuinfo') as file:
        model = next((line.split(':', 1)[1].strip() for line in file if line.startswith('model name')), '?')
    return f'{model}, {os.cpu_count()} cores, {os.uname().sysname} {os.uname().release}'


if __name__ == '__main__':
    print(machine())
