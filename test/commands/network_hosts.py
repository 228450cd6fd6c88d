"""Hosts of their own for a test: two network namespaces with a wire between them. Needs root and the right to make them."""
import os
import subprocess

from run_verb import ROOT

SETUP = os.path.join(ROOT, "build", "devel", "setup.sh")


def sh(command):
    return subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)


class Hosts:
    """Hosts `a` and `b` of 10.213.NET.0/24; `a` has the master. Names carry this process: another run has its own."""

    def __init__(self, net, port):
        self.port = port
        self.name = {host: f"h{net}{host}{os.getpid()}" for host in "ab"}
        self.address = {"a": f"10.213.{net}.1", "b": f"10.213.{net}.2"}
        self.why_not = self._make()

    def _make(self):
        """Empty when the hosts stand; else why they do not."""
        name = self.name
        steps = [f"ip netns add {name[host]}" for host in "ab"]
        steps += [f"ip link add {name['a']} netns {name['a']} type veth peer name {name['b']} netns {name['b']}"]
        for host in "ab":
            steps += [f"ip -n {name[host]} addr add {self.address[host]}/24 dev {name[host]}",
                      f"ip -n {name[host]} link set {name[host]} up", f"ip -n {name[host]} link set lo up"]
        # Names are asked for at host b, and nobody answers there unless a test does.
        steps += [f"mkdir -p /etc/netns/{name['a']}", f"echo nameserver {self.address['b']} >/etc/netns/{name['a']}/resolv.conf"]
        for step in steps:
            done = sh(step)
            if done.returncode != 0:
                self.remove()
                return f"{step}: {done.stderr.strip()}"
        return ""

    def remove(self):
        for host in "ab":
            sh(f"ip netns del {self.name[host]}")
        sh(f"rm -rf /etc/netns/{self.name['a']}")

    def wire(self, host, state):
        sh(f"ip -n {self.name[host]} link set {self.name[host]} {state}")

    def start(self, host, command, errors=subprocess.STDOUT):
        """A shell command on a host, as a process group of its own."""
        script = (f". {SETUP}; export ROS_IP={self.address[host]} "
                  f"ROS_MASTER_URI=http://{self.address['a']}:{self.port}; exec {command}")
        return subprocess.Popen(["ip", "netns", "exec", self.name[host], "sh", "-c", script], stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=errors, text=True, start_new_session=True)

    def call(self, host, command, seconds=60):
        """Its output, once it has ended; what there is when the time is over."""
        return self.start(host, f"timeout {seconds} {command}").communicate(timeout=seconds + 30)[0]
