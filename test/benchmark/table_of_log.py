"""A benchmark's log as a table in markdown, for programs NAME.py LOG [WHERE]."""
import sys


def run(name, usage, rows, markdown, arguments):
    """Prints markdown(rows(open log), where); the code of the program."""
    if not 1 <= len(arguments) <= 2:
        print(usage, file=sys.stderr)
        return 2
    try:
        with open(arguments[0], encoding="utf-8") as log:
            print(markdown(rows(log), *arguments[1:]), end="")
    except (OSError, ValueError) as error:
        print(f"{name}: {arguments[0]}: {error}", file=sys.stderr)
        return 1
    return 0
