#!/usr/bin/env python3
"""Takes the pictures of the documentation: each scene that has a hand, in rviz, while the hand touches something.

    launch/doc/take_pictures.py [SCENE...]        (default: all of them; about 25 s each)

rviz draws on a display of its own (Xvfb) with software GL, from where the panel's first view looks. Pictures are taken whenever the
pointers press harder than in the best one so far; the last stays.
"""
import contextlib
import glob
import math
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SYSTEM_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
PICTURES = os.path.join(ROOT, "launch", "doc", "pictures")
WIDTH, HEIGHT = 960, 600                # [pixels]
COLOURS = 192                           # of the palette: bands do not show yet, and no picture exceeds 150 kB
SETTLE = 4                              # what falls has fallen, what rviz loads is there [s]
WATCH = 11                              # paths last 3 to 10 s [s]
SMOOTHING = 0.2                         # time constant of the force that counts: a touch that lasts, no impact [s]
BETTER = 1.05                           # force over that of the picture before
PATIENCE = 40                           # [s]


def scenes_with_a_hand():
    names = []
    for path in sorted(glob.glob(os.path.join(ROOT, "urdf", "scenes", "*.[uy]*"))):
        with open(path, encoding="utf-8") as file:
            text = file.read()
        if re.search(r"<haptic:pointer\b|^devices:", text, re.MULTILINE):
            names.append(os.path.splitext(os.path.basename(path))[0])
    return names


def scene_file(name):
    for suffix in ("yaml", "urdf"):
        path = os.path.join(ROOT, "urdf", "scenes", f"{name}.{suffix}")
        if os.path.exists(path):
            return path
    sys.exit(f"take_pictures: unknown scene '{name}'; there are {' '.join(scenes_with_a_hand())}")


def devices_of(name):
    with open(scene_file(name), encoding="utf-8") as file:
        named = set(re.findall(r"\bdevice(?:=|: *)\"?(\w+)", file.read()))
    return ["left", "right"] if named >= {"left", "right"} else ["spidar"]


@contextlib.contextmanager
def running(command, log, **options):
    """A process group that ends with the block."""
    with open(log, "wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, start_new_session=True, **options)
    try:
        yield process
    finally:
        for number, patience in ((signal.SIGINT, 10), (signal.SIGTERM, 3), (signal.SIGKILL, 3)):
            with contextlib.suppress(ProcessLookupError, subprocess.TimeoutExpired):
                os.killpg(process.pid, number)
                process.wait(patience)
                break


@contextlib.contextmanager
def display(folder):
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "+extension", "GLX", "-nolisten", "tcp"]
    with running(command, os.path.join(folder, "xvfb.log"), pass_fds=[write]):
        os.close(write)
        with os.fdopen(read) as number:
            yield ":" + number.readline().strip()


class Watch:
    """How hard the pointers of the running demo press."""

    def __init__(self):
        self.force, self.felt_at, self.now = {}, None, {}
        rospy.Subscriber("/tick_statistics", TickStatistics, self.meet, queue_size=1)
        rospy.Subscriber("/contacts", Contacts, self.feel, queue_size=1)

    def meet(self, message):
        for hand in message.hands:
            self.force.setdefault(hand.pointer, 0)

    def feel(self, message):
        now = time.time()
        share = 1 - math.exp(-(now - (self.felt_at or now)) / SMOOTHING)
        self.felt_at = now
        for pointer, before in self.force.items():
            pressed = sum(c.normal_force for c in message.contacts if pointer in (c.link_a, c.link_b))
            self.force[pointer] = before + share * (pressed - before)
            self.now[pointer] = pressed

    def least_force(self):
        """Of two hands both are to press."""
        return min(self.force.values(), default=0)

    def lasts(self):
        return all(self.now.get(pointer, 0) > force / 2 for pointer, force in self.force.items())

def write_config(path, devices):
    """The demo's own view: the panel fits the camera, behind a dock that is hidden."""
    with open(os.path.join(ROOT, "launch", "rviz", "demo_light.rviz" if devices == ["spidar"] else "two_hands_light.rviz")) as file:
        config = yaml.safe_load(file)
    config["Window Geometry"] = {"Hide Left Dock": True, "Hide Right Dock": True, "Haptics": {"collapsed": True},
                                 "Width": WIDTH, "Height": HEIGHT, "X": 0, "Y": 0}
    with open(path, "w") as file:
        yaml.safe_dump(config, file)


def wait_for(what, condition, demo):
    end = time.time() + PATIENCE
    while not condition():
        if demo.poll() is not None:
            raise RuntimeError("the demo ended")
        if time.time() > end:
            raise RuntimeError(f"no {what} within {PATIENCE} s")
        time.sleep(0.005)


def shot(path):
    subprocess.run(["import", "-window", "root", path], check=True)


def drawn(path):
    """rviz fills the screen, and has drawn more than its background."""
    shot(path)
    asked = f"%k %[fx:p{{{WIDTH - 3},{HEIGHT - 3}}}.intensity]"
    colours, corner = subprocess.run(["identify", "-format", asked, path], check=True, capture_output=True, text=True).stdout.split()
    return int(colours) > 500 and float(corner) > 0


def looked_at():
    """rviz subscribes to the bodies."""
    publishers_subscribers = rosgraph.Master("/pictures").getSystemState()[1]
    return any(topic == "/markers" and len(nodes) > 1 for topic, nodes in publishers_subscribers)


def take(name, folder):
    devices = devices_of(name)
    launch = "demo.launch" if devices == ["spidar"] else "two_hands.launch"
    command = ["roslaunch", "--disable-title", "--skip-log-check", "--no-summary", "haptic_bringup", launch,
               f"scene:={scene_file(name)}", "rviz:=false"]
    picture, raw = os.path.join(PICTURES, name + ".png"), os.path.join(folder, name + ".png")
    config = os.path.join(folder, name + ".rviz")
    with contextlib.ExitStack() as stack:
        demo = stack.enter_context(running(command, os.path.join(folder, name + ".log")))
        watch = Watch()
        wait_for("hands", lambda: watch.force, demo)
        write_config(config, devices)
        # The window is as large as the screen: menu and tool bar vanish with --fullscreen.
        stack.enter_context(running(["rviz", "--fullscreen", "-d", config], os.path.join(folder, name + ".rviz.log")))
        wait_for("picture in rviz", lambda: drawn(raw) and looked_at(), demo)
        time.sleep(SETTLE)
        rospy.ServiceProxy("/simulation/reset", Trigger)()  # what the hand has pushed away by now comes back
        most, end = 0, time.time() + WATCH
        while time.time() < end:
            if watch.least_force() > BETTER * most + 0.01 and watch.lasts():
                most = watch.least_force()
                shot(raw)
            time.sleep(0.02)
    subprocess.run(["convert", raw, "-strip", "-colors", str(COLOURS), "PNG8:" + picture], check=True)
    print(f"{os.path.relpath(picture, ROOT)}: {os.path.getsize(picture) / 1024:.0f} kB, {most:.2f} N", flush=True)


def main():
    names = sys.argv[1:] or scenes_with_a_hand()
    for name in names:
        scene_file(name)
    os.makedirs(PICTURES, exist_ok=True)
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        os.environ.update(DISPLAY=stack.enter_context(display(folder)), LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1",
                          XDG_RUNTIME_DIR=folder, ROS_HOME=folder)
        stack.enter_context(running(["roscore", "-p", os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1]],
                                    os.path.join(folder, "roscore.log")))
        while not rosgraph.is_master_online():
            time.sleep(0.1)
        rospy.init_node("pictures", disable_signals=True)
        for name in names:
            try:
                take(name, folder)
            except RuntimeError as error:
                with open(os.path.join(folder, name + ".log"), errors="replace") as log:
                    sys.exit(f"take_pictures: {name}: {error}\n{log.read()[-2000:]}")


if __name__ == "__main__":
    if "HAPTIC_PICTURES" not in os.environ:  # once more, with the build's environment and a master of its own
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        os.environ.update(PATH=SYSTEM_PATH, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1", HAPTIC_PICTURES="1")
        os.execv("/bin/sh", ["sh", "-c", '"$0/run" setup run view test && "$0/run" build && . "$0/build/devel/setup.sh" && exec "$@"', ROOT, "/usr/bin/python3"] + sys.argv)
    import rosgraph
    import rospy
    import yaml
    from haptic_msgs.msg import Contacts, TickStatistics
    from std_srvs.srv import Trigger
    main()
