#!/usr/bin/env python3
"""Takes the pictures of the documentation: each scene that has a hand, in rviz, while the hand touches something.

    launch/doc/take_pictures.py [SCENE...]        (default: all of them; about 25 s each)

rviz draws on a display of its own (Xvfb) with software GL. The camera is computed from what is shown: device frames and
bodies. Pictures are taken whenever the pointers press harder than in the best one so far; the last stays.
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
FIELD_OF_VIEW = math.radians(45)        # rviz's own, vertical
PITCH = 0.42
YAWS = (4.3, 5.1, 3.5, 5.9, 2.7, 0.5, 1.2, 1.9)  # beside the diagonals: no edge of a frame stands before the grip
MARGIN = 1.06
GRIP = 0.02                             # about its radius [m]
NEAR = 0.005                            # what begins nearer to a grip than this is in its hand [m]
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


def rotation(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class Watch:
    """What the running demo shows: bodies, frames of devices, and how hard the pointers press."""

    def __init__(self, devices):
        self.devices, self.bodies, self.frames, self.texts, self.force = devices, {}, {}, {}, {}
        self.felt_at, self.now = None, {}
        self.buffer = tf2_ros.Buffer()
        self.subscribers = [rospy.Subscriber("/markers", MarkerArray, self.see)]
        for device in devices:
            self.subscribers.append(rospy.Subscriber(f"/{device}/markers", MarkerArray, self.see))
        self.subscribers.append(rospy.Subscriber("/tick_statistics", TickStatistics, self.meet, queue_size=1))
        self.subscribers.append(rospy.Subscriber("/contacts", Contacts, self.feel, queue_size=1))
        self.listener = tf2_ros.TransformListener(self.buffer)

    def see(self, message):
        for marker in message.markers:
            if marker.ns == "bodies":
                self.bodies[marker.id] = marker
            elif marker.ns == "frame" and marker.points and marker.type == marker.LINE_LIST:
                self.frames[marker.header.frame_id] = marker
            elif marker.ns == "text":
                known = self.texts.setdefault((marker.header.frame_id, marker.id), marker)
                if marker.pose.position.z < known.pose.position.z:  # it stays below the lowest body
                    self.texts[marker.header.frame_id, marker.id] = marker

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

    def complete(self):
        return self.bodies and len(self.frames) == len(self.devices) and len(self.texts) > len(self.devices) and self.force

    def in_world(self, marker, points):
        at = self.buffer.lookup_transform("world", marker.header.frame_id, rospy.Time(0), rospy.Duration(5)).transform
        here = np.asarray(points) @ rotation(marker.pose.orientation).T
        p, t = marker.pose.position, at.translation
        return (here + [p.x, p.y, p.z]) @ rotation(at.rotation).T + [t.x, t.y, t.z]


def corners(low, high):
    return np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def extent(watch):
    """Points in the world that the picture has to hold: frames of devices, and bodies. Of a body that is larger than the
    devices, such as a floor, what lies near them."""
    points = [watch.in_world(m, [[p.x, p.y, p.z] for p in m.points]) for m in watch.frames.values()]
    low, high = np.vstack(points).min(0), np.vstack(points).max(0)
    grown = 0.1 * (high - low)
    origins = np.vstack([watch.in_world(m, [[0, 0, 0]]) for m in watch.bodies.values()])
    for marker in watch.bodies.values():
        size = np.array([marker.scale.x, marker.scale.y, marker.scale.z]) / 2
        if marker.type == marker.MESH_RESOURCE:  # its scale is no size: it reaches half way to the nearest other body
            apart = np.linalg.norm(origins - watch.in_world(marker, [[0, 0, 0]]), axis=1)
            size = np.full(3, min(apart[apart > 0.01], default=0) / 2)
        body = watch.in_world(marker, corners(-size, size))
        if np.any(np.ptp(body, axis=0) > high - low):
            body = np.clip(body, low - grown, high + grown)
        points.append(body)
    return np.vstack(points)


def axes(yaw):
    """Of the camera: to it, to its right, up."""
    back = np.array([math.cos(PITCH) * math.cos(yaw), math.cos(PITCH) * math.sin(yaw), math.sin(PITCH)])
    right = np.array([-math.sin(yaw), math.cos(yaw), 0])
    return back, right, np.cross(back, right)


def hidden(watch, point, back):
    """How many bodies stand between a point and the camera. Meshes count by nothing: their size is not known here."""
    count = 0
    for marker in watch.bodies.values():
        if marker.type == marker.MESH_RESOURCE:
            continue
        origin, *ends = watch.in_world(marker, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        turn = np.array(ends) - origin                      # rows: the body's axes in the world
        p, d = turn @ (point - origin), turn @ back
        half = np.array([marker.scale.x, marker.scale.y, marker.scale.z]) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (-half - p) / d, (half - p) / d
        enters, leaves = np.nanmax(np.minimum(one, other)), np.nanmin(np.maximum(one, other))
        count += enters < leaves and enters > NEAR
    return count


def best_yaw(watch):
    """The first of YAWS from which fewest bodies hide the hands."""
    hands = [watch.buffer.lookup_transform("world", device + "_grip", rospy.Time(0), rospy.Duration(5)).transform.translation
             for device in watch.devices]
    around = GRIP * np.vstack([np.eye(3), -np.eye(3)])
    points = [np.array([p.x, p.y, p.z]) + offset for p in hands for offset in around]
    counts = [sum(hidden(watch, point, axes(yaw)[0]) for point in points) for yaw in YAWS]
    return YAWS[counts.index(min(counts))]


def camera(watch):
    """Yaw, focal point, and distance at which all of it, and the texts, just fit."""
    points = extent(watch)
    yaw = best_yaw(watch)
    back, right, up = axes(yaw)
    for marker in watch.texts.values():   # a letter of DejaVu is about half as wide as high; texts face the camera
        lines = marker.text.split("\n")
        half = 0.27 * marker.scale.z * max(map(len, lines)) * right
        height = 0.95 * marker.scale.z * len(lines) * up
        centre = watch.in_world(marker, [[0, 0, 0]])[0]
        points = np.vstack([points, centre + half + height, centre - half + height, centre + half - height, centre - half - height])
    tangent = math.tan(FIELD_OF_VIEW / 2)
    focus = (points.min(0) + points.max(0)) / 2
    for _ in range(20):                    # shifts the focus until left and right, and above and below, are as full
        x, y, z = (points - focus) @ right, (points - focus) @ up, (points - focus) @ back
        distance = max(np.max(np.abs(x) / (tangent * WIDTH / HEIGHT) + z), np.max(np.abs(y) / tangent + z))
        u, v = x / (distance - z), y / (distance - z)
        focus = focus + distance * ((u.max() + u.min()) / 2 * right + (v.max() + v.min()) / 2 * up)
    return yaw, focus, MARGIN * distance


def write_config(path, devices, yaw, focus, distance):
    """The demo's own view, without panels, from that camera."""
    with open(os.path.join(ROOT, "launch", "rviz", "demo_dark.rviz" if devices == ["spidar"] else "two_hands_dark.rviz")) as file:
        config = yaml.safe_load(file)
    view = config["Visualization Manager"]["Views"]["Current"]
    view.update({"Distance": float(distance), "Yaw": yaw, "Pitch": PITCH,
                 "Focal Point": dict(zip("XYZ", map(float, focus)))})
    config["Panels"] = []
    config["Window Geometry"] = {"Hide Left Dock": True, "Hide Right Dock": True,
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
        watch = Watch(devices)
        wait_for("bodies and devices", watch.complete, demo)
        time.sleep(SETTLE)
        write_config(config, devices, *camera(watch))
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
    import numpy as np
    import rosgraph
    import rospy
    import tf2_ros
    import yaml
    from haptic_msgs.msg import Contacts, TickStatistics
    from std_srvs.srv import Trigger
    from visualization_msgs.msg import MarkerArray
    main()
