"""A study's loop in this process, with the device's twin in a simulated hand: no node, no clock, as fast as it goes. It keeps no
recording; what is measured is the same."""
import numpy as np

from presented import Samples

HAND_PERIOD = 5e-3   # the simulated hand is led and looked at so often [s]
FADE_IN = 0.6        # the loop fades the force in over 0.5 s after each start (soft_start), and a hand waits for it at home [s]


class LoopRig:
    def __init__(self, device):
        import haptic  # built where pybind11-dev is installed
        self.haptic, self.device = haptic, device
        self.loop = self.rows = None
        self.nominal = float('nan')   # of the stiffness that was touched, as the scene says [N/m]

    def load(self, scene, rate):
        self.loop = self.haptic.Loop(scene, self.device, rate)
        self.rows, self.nominal = [], float('nan')
        self.loop.hands[0].move_to(np.eye(4))
        self.loop.tick(round(FADE_IN / self.loop.period))

    def explore(self, hand, seconds, until_lift_off=False):
        """The Samples of an interval in which `hand` leads the grip."""
        ticks = max(1, round(HAND_PERIOD / self.loop.period))
        felt, X, touched = self.loop.hands[0], np.eye(4), False
        begin, self.rows, stiffness = self.loop.time, [], []
        while self.loop.time - begin < seconds:
            X[:3, 3] = hand.position(self.loop.time - begin)
            felt.move_to(X)
            self.loop.tick(ticks)
            self.rows.append((self.loop.time - begin, *felt.X_BG[:3, 3], *felt.achieved[3:], felt.in_contact, felt.flags,
                              felt.stiffness_share))
            if felt.in_contact:
                stiffness.append(felt.stiffness)
            if until_lift_off and touched and not felt.in_contact:
                break
            touched = touched or felt.in_contact
        if stiffness:
            self.nominal = float(np.median(stiffness))
        rows = np.array(self.rows, dtype=float)
        return Samples(rows[:, 0], rows[:, 1:4], rows[:, 4:7], rows[:, 7] > 0, rows[:, 8].astype(np.uint32), rows[:, 9],
                       np.ones(len(rows)))  # no tick is lost here
