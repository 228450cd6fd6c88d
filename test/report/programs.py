"""Where the report's programs are."""
import glob
import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def find(folder, name):
    """Path of a built program below `folder`; None when it is not there."""
    found = [path for path in glob.glob(os.path.join(folder, '**', name), recursive=True)
             if os.path.isfile(path) and os.access(path, os.X_OK)]
    return min(found, key=len) if found else None
