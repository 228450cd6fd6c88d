"""Calls a verb of ./run as a user does, and finds what it left running."""
import os
import re
import signal
import subprocess
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRESS = re.compile(r"[\w -]+: \d+ s(:|,|$)")  # what is shown while something lasts; not an error
RUN = os.path.join(ROOT, "run")


def descendants(marker):
    """Processes that carry `marker` (NAME=VALUE) in their environment: what a call started and left."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/environ", "rb") as environment:
                if marker.encode() in environment.read().split(b"\0") and int(pid) != os.getpid():
                    found.append(int(pid))
        except OSError:
            pass  # ended meanwhile, or another user's
    return found


class Call:
    """One call: `code`, `seconds`, `out`, `errors` (lines that are neither empty nor progress), `left` (processes)."""

    def __init__(self, *arguments, interrupt_after=None, limit=120, **environment):
        marker = f"HAPTIC_TEST_CALL={os.getpid()}-{time.monotonic_ns()}"
        variables = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "ROS_MASTER_URI")}
        variables.update(environment)
        variables["HAPTIC_TEST_CALL"] = marker.split("=")[1]
        start = time.monotonic()
        process = subprocess.Popen([RUN, *arguments], env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        try:
            if interrupt_after is not None:
                time.sleep(interrupt_after)
                start = time.monotonic()
                process.send_signal(signal.SIGTERM)
            self.out, errors = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            process.terminate()
            self.out, errors = process.communicate(timeout=30)
        self.seconds = time.monotonic() - start
        self.code = process.returncode
        self.errors = [line for line in errors.splitlines() if line.strip() and not PROGRESS.match(line)]
        self.left = descendants(marker)

    def figures(self):
        values = {}
        for line in self.out.splitlines():
            words = line.split()
            if len(words) >= 3 and words[0] == "figure":
                values[words[1]] = float(words[2])
        return values
