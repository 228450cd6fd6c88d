#!/usr/bin/python3
"""What a step costs from Python beyond the step itself, and how many arrays are copies. `./run bench python`."""
import os
import statistics
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "build", "devel", "lib", "python3", "dist-packages"))
os.environ["ROS_PACKAGE_PATH"] = ROOT + ":" + os.environ.get("ROS_PACKAGE_PATH", "")
import haptic  # noqa: E402
import numpy as np  # noqa: E402

STEPS, ROUNDS = 2000, 31


def seconds(act):
    begin = time.perf_counter()
    act()
    return time.perf_counter() - begin


def one_by_one(world):
    for _ in range(STEPS):
        world.step()


def main():
    world = haptic.World("touch_cube")
    world.step(1000)  # the cube lies still: every step costs the same
    both = [(seconds(lambda: one_by_one(world)), seconds(lambda: world.step(STEPS))) for _ in range(ROUNDS)]
    overhead = statistics.median(single - together for single, together in both) / STEPS
    arrays = [world.q, world.v, world.positions, world.rotations, world.contacts]
    addresses = [array.ctypes.data for array in arrays]
    world.step(100)
    again = [world.q, world.v, world.positions, world.rotations, world.contacts]
    copies = sum(not np.shares_memory(a, b) or a.ctypes.data != at for a, b, at in zip(arrays, again, addresses))
    print(f"figure python.step_overhead_ns {1e9 * overhead:.0f} ns")
    print(f"figure python.copies {copies} 1")


if __name__ == "__main__":
    main()
