#!/usr/bin/python3
"""What Doxygen misses in the sources: public symbols without a word, and comments that it cannot read.

    launch/doc/site/undocumented.py LOG      prints each warning of a finished run, then `figure docs.undocumented_cpp N 1`
"""
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
SILENT = " is not documented"


def warnings(log):
    """Each once, without the path of the repository."""
    with open(log, encoding="utf-8") as file:
        return sorted({line.strip().replace(ROOT + os.sep, "") for line in file if line.strip()})


def read_sources(settings=""):
    """What Doxygen warns of, in a site of its own that is thrown away: seconds. `settings` replace those of the site."""
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "warnings.log")
        with open(os.path.join(ROOT, "launch", "doc", "site", "Doxyfile"), encoding="utf-8") as file:
            doxyfile = file.read().replace("build/docs/pages ", "")  # made of what is built
        doxyfile += f"\nOUTPUT_DIRECTORY={folder}\nWARN_LOGFILE={log}\n{settings}\n"
        subprocess.run(["doxygen", "-"], input=doxyfile, text=True, cwd=ROOT, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        return warnings(log)


def main():
    found = warnings(sys.argv[1])
    for line in found:
        print(line)
    print(f"figure docs.undocumented_cpp {sum(SILENT in line for line in found)} 1")


if __name__ == "__main__":
    main()
