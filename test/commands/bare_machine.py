"""A machine on which nothing is installed yet, as far as ./run can see: programs dpkg-query, apt-get and sudo in front of the path."""
import os
import pty
import select
import signal
import subprocess
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

# Nothing is installed until apt-get install was called; then all that is really here, but for what stands in `removed`.
DPKG_QUERY = """#!/bin/sh
[ -e "$here/installed" ] || exit 0
/usr/bin/dpkg-query "$@" | grep -vwF -e "$(cat "$here/removed" 2>/dev/null || echo none-is-called-so)"
"""
APT_GET = """#!/bin/sh
echo "$*" >>"$here/calls"
case " $* " in
  *' update '*) echo 'Fetched 9,999 kB in 1s (9,999 kB/s)' ;;
  *' --print-uris '*)
    echo '0 upgraded, 65 newly installed, 0 to remove and 0 not upgraded.'
    echo "Need to get ${HAPTIC_TEST_MB:-145} MB of archives."
    echo "After this operation, ${HAPTIC_TEST_MB:-726} MB of additional disk space will be used." ;;
  *' install '*) echo "$(id -u)" >"$here/installed"; rm -f "$here/removed" ;;
esac
"""
# What sudo is here: it asks for a password on the terminal unless `free`. Root is that of a user namespace, which owns the user's files.
SUDO = """#!/bin/sh
while :; do
  case ${1:-} in -n) quiet=yes; shift ;; --) shift; break ;; *) break ;; esac
done
if [ ! -e "$here/free" ]; then
  [ -z "${quiet:-}" ] || exit 1
  printf 'password: ' >/dev/tty
  read -r word </dev/tty
  [ "$word" = secret ] || exit 1
fi
echo "$*" >>"$here/sudo_calls"
SUDO_UID=0 SUDO_GID=0 exec unshare --map-root-user "$@"
"""


class BareMachine:
    """`folder` holds the programs; the call's environment puts them in front. `reached` is made by the real apt-get, which must not be."""

    def __init__(self, folder, sudo=None, removed=None, installed=False):
        self.folder = os.path.join(folder, "bin")
        os.makedirs(self.folder)
        os.chmod(folder, 0o777)
        os.chmod(self.folder, 0o777)
        programs = {"dpkg-query": DPKG_QUERY, "apt-get": APT_GET}
        if sudo:
            programs["sudo"] = SUDO
        for name, text in programs.items():
            path = os.path.join(self.folder, name)
            with open(path, "w", encoding="utf-8") as out:
                out.write(text.replace("#!/bin/sh\n", f"#!/bin/sh\nhere='{self.folder}'\n", 1))
            os.chmod(path, 0o755)
        for name, wanted in (("free", sudo == "free"), ("installed", installed), ("removed", removed)):
            if wanted:
                with open(os.path.join(self.folder, name), "w", encoding="utf-8") as out:
                    out.write(f"{removed}\n" if name == "removed" else "")
        self.reached = os.path.join(self.folder, "reached")
        config = os.path.join(self.folder, "apt.conf")
        with open(config, "w", encoding="utf-8") as out:
            for hook in ("APT::Update::Pre-Invoke", "DPkg::Pre-Invoke"):
                out.write(f'{hook} {{"touch {self.reached}; false";}};\n')
        self.environment = {"PATH": f"{self.folder}:{os.environ['PATH']}", "APT_CONFIG": config}

    def text(self, name):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            return ""
        with open(path, encoding="utf-8") as file:
            return file.read()

    def remove(self, names):
        """Packages with these names count as not installed, until the next apt-get install."""
        with open(os.path.join(self.folder, "removed"), "w", encoding="utf-8") as out:
            out.write("".join(f"{name}\n" for name in sorted(names)))

    def installs(self):
        """The calls of apt-get that installed something."""
        return [line for line in self.text("calls").splitlines() if " install " in f" {line} " and "--print-uris" not in line]


def checkout_of_scripts(folder, owner=None):
    """The verbs without anything that is built, as a checkout of its own, whose configuration waits to be interrupted."""
    place = os.path.join(folder, "checkout ä b")
    for name in ("run", "packages.apt", "launch/verbs", "urdf", "test/benchmark", "test/core", "test/report/results"):
        target = os.path.join(place, name)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        subprocess.run(["cp", "-r", os.path.join(ROOT, name), target], check=True)
    os.makedirs(os.path.join(place, "src"))
    for name in ("CMakeLists.txt", "src/CMakeLists.txt"):
        with open(os.path.join(place, name), "w", encoding="utf-8") as out:
            out.write("cmake_minimum_required(VERSION 3.16)\nproject(waits NONE)\nexecute_process(COMMAND sleep 300)\n")
    if owner is not None:
        subprocess.run(["chown", "-R", str(owner), folder], check=True)
    return place


def on_a_terminal(words, answers, limit=60, **options):
    """Runs a program on a terminal of its own, types an answer for each prompt, and returns its exit code and all that it said."""
    parent, child = pty.openpty()

    def take_terminal():
        os.setsid()
        import fcntl
        import termios
        fcntl.ioctl(child, termios.TIOCSCTTY, 0)
        if options.get("user") is not None:
            os.setgid(options["user"])
            os.setuid(options["user"])
    process = subprocess.Popen(words, stdin=child, stdout=child, stderr=child, preexec_fn=take_terminal, close_fds=True,
                               env=options.get("env"), cwd=options.get("cwd"))
    os.close(child)
    said, left, deadline = "", list(answers), time.monotonic() + limit
    while time.monotonic() < deadline:
        ready, _, _ = select.select([parent], [], [], 0.1)
        if ready:
            try:
                data = os.read(parent, 4096)
            except OSError:  # the other side is closed
                break
            if not data:
                break
            said += data.decode(errors="replace")
            if left and left[0][0] in said:
                os.write(parent, (left.pop(0)[1] + "\n").encode())
        elif process.poll() is not None:
            break
    if process.poll() is None and time.monotonic() >= deadline:
        process.send_signal(signal.SIGTERM)
    code = process.wait(timeout=30)
    os.close(parent)
    return code, said
