#!/usr/bin/python3
"""Files with odd texts in every attribute (test/scene/odd_texts.h): how many end the process that reads them.

    text.files_check     loaded by the scene library, as ./run check does, each in a process of its own
    text.files_python    loaded by the package haptic
    text.files_spawn     given to ~spawn of a running loop with its driver: as a file, as text, as a parameter
    text.crashes         of all these: ended by a signal, an exception that is no SetupError, or no answer
"""
import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
import xmlrpc.client

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "test", "ros")]

PATIENCE = 120  # [s] for one file; a busy machine needs a few for the slowest


def figure(name, value):
    print(f"figure {name} {value} 1", flush=True)


def crashes_of_library(program, count):
    """As the program counts them."""
    done = subprocess.run([program, "load", str(count)], stdout=subprocess.PIPE, text=True, check=False)
    print("".join(f"# library: {line}\n" for line in done.stdout.splitlines()), end="")
    return int(done.stdout.split()[-1])


def load_in_turn(files, first, told):
    """Of a child process: tells the number of each file before it reads it."""
    import haptic
    for i in range(first, len(files)):
        told.write(f"{i}\n")
        told.flush()
        signal.alarm(PATIENCE)
        try:
            scene = haptic.Scene(files[i], default_density=1000, missing_meshes="skip")
            haptic.World(scene)
            scene.text().encode()
        except haptic.SetupError as error:
            if len(str(error).splitlines()) != 1:
                raise


def crashes_of_python(files):
    """A child reads on until it ends; the next one begins behind the file that ended it."""
    crashes, first = 0, 0
    while first < len(files):
        end, begin = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(end)
            code = 1
            try:
                with os.fdopen(begin, "w") as told:
                    load_in_turn(files, first, told)
                code = 0
            except BaseException:  # whatever it is, the parent counts it
                traceback.print_exc()
            finally:
                os._exit(code)
        os.close(begin)
        with os.fdopen(end) as told:
            last = int(([""] + told.read().split())[-1] or first)
        status = os.waitpid(child, 0)[1]
        if status != 0:
            crashes += 1
            print(f"# python: {os.path.basename(files[last])}: status {status}", flush=True)
        first = last + 1
    return crashes


class Loop:
    """A master, and a manager with driver (a twin), simulation and bridge."""

    def __init__(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
        import rosgraph
        import rospy
        import topic_probe
        self.rospy, self.probe = rospy, topic_probe
        self.master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        topic_probe.wait_until("a master", rosgraph.Master("/bench", os.environ["ROS_MASTER_URI"]).is_online, PATIENCE)
        rospy.init_node("odd_texts", disable_signals=True)
        self.start()

    def start(self):
        self.manager = subprocess.Popen([self.probe.NODELET, "manager", "__name:=haptics"], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        self.stack = self.probe.load_stack()
        self.rospy.wait_for_service("/simulation/spawn", PATIENCE)

    def close(self):
        self.probe.unload_stack(self.stack)
        for process in (self.manager, self.master):
            process.terminate()
            process.wait(PATIENCE)

    def again(self):
        self.manager.kill()
        self.manager.wait()
        for process in self.stack:
            process.kill()
            process.wait()
        self.start()

    def spawn(self, path, road):
        """False: the manager has ended, or does not answer."""
        from haptic_msgs.srv import Delete, Spawn
        asked = {"model": path}
        if road > 0:
            with open(path, encoding="latin-1", newline="") as file:
                text = file.read()
            asked = {"urdf": text}
            if road == 2:
                try:
                    self.rospy.set_param("/odd_text", text)
                    asked = {"model": "param:/odd_text"}
                except (xmlrpc.client.Error, OSError, ValueError, self.rospy.ROSException):
                    pass  # no text that a parameter can have: it goes as text
        signal.alarm(PATIENCE)
        try:
            answer = self.rospy.ServiceProxy("/simulation/spawn", Spawn)(name="odd", **asked)
            if answer.success:
                self.rospy.ServiceProxy("/simulation/delete", Delete)(name="odd")
            return len(answer.message.splitlines()) <= 1 and self.manager.poll() is None
        except (self.rospy.ServiceException, self.rospy.ROSException, TimeoutError, UnicodeDecodeError) as error:
            print(f"# spawn: {error}")
            return False
        finally:
            signal.alarm(0)


def out_of_patience(*_):
    raise TimeoutError("no answer")


def crashes_of_spawn(files):
    signal.signal(signal.SIGALRM, out_of_patience)
    loop, crashes = Loop(), 0
    try:
        for i, path in enumerate(files):
            if loop.spawn(path, i % 3):
                continue
            crashes += 1
            print(f"# spawn: {os.path.basename(path)}: road {i % 3}, manager {loop.manager.poll()}", flush=True)
            loop.again()
    finally:
        loop.close()
    return crashes


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--program", required=True, help="odd_files of test/scene")
    arguments.add_argument("--check", type=int, default=10000)
    arguments.add_argument("--python", type=int, default=3000)
    arguments.add_argument("--spawn", type=int, default=500)
    counts = arguments.parse_args()
    crashes = crashes_of_library(counts.program, counts.check) if counts.check else 0
    figure("text.files_check", counts.check)
    with tempfile.TemporaryDirectory() as folder:
        most = max(counts.python, counts.spawn, 1)
        subprocess.run([counts.program, "write", str(most), folder], check=True)
        files = [os.path.join(folder, f"odd_{i}.urdf") for i in range(most)]
        crashes += crashes_of_python(files[:counts.python])
        figure("text.files_python", counts.python)
        if counts.spawn:
            crashes += crashes_of_spawn(files[:counts.spawn])
        figure("text.files_spawn", counts.spawn)
    figure("text.crashes", crashes)
    return 0 if crashes == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
