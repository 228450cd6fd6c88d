#!/usr/bin/python3
"""Counts what a driver took of others' commands until it is interrupted: `accepted N` wrenches taken, `pulses N` times that the
force on the hand rose above 0.5 N, `force F` [N] at most. Prints `ready` once it hears the driver."""
import signal
import threading

import rospy
from geometry_msgs.msg import WrenchStamped

RISES, FALLS = 0.5, 0.3  # [N] a hand that nothing presses feels less


class Witness:
    def __init__(self):
        self.accepted = self.pulses = 0
        self.force = 0.0
        self.high = False
        self.heard = threading.Event()
        rospy.Subscriber("/spidar/recorded/wrench_command", WrenchStamped, self.take)
        rospy.Subscriber("/spidar/wrench", WrenchStamped, self.feel, queue_size=1000)

    def take(self, _):
        self.accepted += 1

    def feel(self, message):
        f = message.wrench.force
        size = (f.x * f.x + f.y * f.y + f.z * f.z) ** 0.5
        self.force = max(self.force, size)
        if size > RISES and not self.high:
            self.pulses += 1
        self.high = size > (FALLS if self.high else RISES)
        self.heard.set()


def main():
    rospy.init_node("witness", anonymous=True, disable_signals=True)
    stop = threading.Event()
    signal.signal(signal.SIGINT, lambda *_: stop.set())
    witness = Witness()
    witness.heard.wait()
    witness.pulses, witness.force = 0, 0.0
    print("ready", flush=True)
    stop.wait()
    print("accepted", witness.accepted, "pulses", witness.pulses, "force", witness.force, flush=True)


if __name__ == "__main__":
    main()
