"""Listening to topics and starting nodes, for the tests of this folder."""
import contextlib
import os
import signal
import subprocess
import threading
import time

import rospy
import rosnode
import rosgraph

PATIENCE = 30.0  # [s] for events that take less than one on an idle machine
NODELET = "/usr/lib/nodelet/nodelet"


def program(package, name):
    """An executable of a package, as built or as installed."""
    for path in os.environ["CMAKE_PREFIX_PATH"].split(":"):
        file = os.path.join(path, "lib", package, name)
        if os.path.exists(file):
            return file
    raise AssertionError(f"{name} of {package} was not built")


class Probe:
    """Keeps what arrives on a topic, with the time of arrival."""

    def __init__(self, topic, kind, keep=2000, queue=100):
        self.messages, self.times = [], []
        self._keep = keep
        self._arrived = threading.Condition()
        self._subscriber = rospy.Subscriber(topic, kind, self._take, queue_size=queue)
        self.topic = topic

    def _take(self, message):
        with self._arrived:
            self.messages = (self.messages + [message])[-self._keep:]
            self.times = (self.times + [time.monotonic()])[-self._keep:]
            self._arrived.notify_all()

    def wait(self, count=1, timeout=PATIENCE, accept=lambda message: True):
        """The last of `count` messages that `accept` takes."""
        end = time.monotonic() + timeout
        with self._arrived:
            while True:
                taken = [m for m in self.messages if accept(m)]
                if len(taken) >= count:
                    return taken[-1]
                left = end - time.monotonic()
                if left <= 0:
                    raise AssertionError(f"{self.topic}: {len(taken)} of {count} messages within {timeout} s")
                self._arrived.wait(left)

    def clear(self):
        with self._arrived:
            self.messages, self.times = [], []

    def rate(self):
        with self._arrived:
            if len(self.times) < 3:
                return 0.0
            return (len(self.times) - 1) / (self.times[-1] - self.times[0])

    def close(self):
        self._subscriber.unregister()


def node_pid(name):
    """Process that the node `name` runs in."""
    return rosnode.ServerProxy(rosnode.get_api_uri(rosgraph.Master("/test"), name)).getPid("/test")[2]


def threads_of(pid):
    """Names of the threads of a process, sorted."""
    names = []
    for task in os.listdir(f"/proc/{pid}/task"):
        try:
            with open(f"/proc/{pid}/task/{task}/comm", encoding="utf-8") as comm:
                names.append(comm.read().strip())
        except OSError:
            pass  # it ended between the two lines
    return sorted(names)


def wait_until(what, condition, timeout=PATIENCE, seen=lambda: ""):
    """Until `condition` holds; the error says `what` and what `seen` tells at its end."""
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"not within {timeout} s: {what} {seen()}")
        time.sleep(0.02)


def load_nodelet(kind, name, manager, **parameters):
    """Loads a nodelet as roslaunch does; it is unloaded when the process that this returns gets SIGINT."""
    for key, value in parameters.items():
        rospy.set_param(f"{name}/{key}", value)
    namespace, leaf = name.rsplit("/", 1)
    environment = dict(os.environ, ROS_NAMESPACE=namespace or "/")
    return subprocess.Popen([NODELET, "load", kind, manager, f"__name:={leaf}"], env=environment,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def load_stack(device="spidar_g6x3r", rate=1000, driver=None, bridge=None, scene="touch_cube"):
    """Driver, simulation of a scene and bridge in the manager /haptics; what `unload_stack` wants."""
    rospy.wait_for_service("/haptics/load_nodelet", 20)
    return [load_nodelet("spidar_driver/DriverNodelet", "/spidar/driver", "/haptics", device=device, rate=rate, alone=False,
                         **(driver or {})),
            load_nodelet("penalty_sim/SimulationNodelet", "/simulation", "/haptics", scene=scene, rate=rate, alone=False),
            load_nodelet("haptic_bridge/BridgeNodelet", "/bridge", "/haptics", rate=rate, **(bridge or {}))]


def unload_stack(stack):
    for process in reversed(stack):
        unload(process)


@contextlib.contextmanager
def recorded(bag):
    """`bag` has all that is recorded within; it is closed at the end."""
    recorder = subprocess.Popen(["rosbag", "record", "-O", bag, "-e", ".*recorded/.*"])
    try:
        yield
        time.sleep(1)  # what was published last is on its way
    finally:
        recorder.send_signal(signal.SIGINT)
        recorder.wait(20)
    # `rosbag record` ends before the program that it started; that one renames the bag when it has closed it.
    wait_until("the bag is closed", lambda: os.path.exists(bag), 20)


def replay(bag):
    """Runs a recorded bag again: its figures. Fails when it cannot be, or comes out otherwise."""
    done = subprocess.run([program("penalty_sim", "haptic_replay"), bag], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return {name: float(value) for word, name, value, *_ in map(str.split, done.stdout.splitlines()) if word == "figure"}


def unload(process, timeout=PATIENCE):
    """Asks the loader to unload its nodelet; its exit code."""
    process.send_signal(signal.SIGINT)
    try:
        return process.wait(timeout)
    finally:
        if process.poll() is None:
            process.kill()
        process.stdout.close()
