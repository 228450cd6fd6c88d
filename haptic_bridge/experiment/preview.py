"""What a condition gives a hand, before anybody feels it: the simulated hand explores it once on the device's twin, in this process."""
import math
from dataclasses import dataclass

import numpy as np

import condition_scene
from presented import Estimate, presented
from simulated_subject import SimulatedHand

SEED = 1          # of the hand that looks: the same every time
UNITS = {'stiffness': 'N/m', 'friction': '', 'mass': 'kg', 'none': ''}
CLAMPS = ('ForceClamped', 'TorqueClamped', 'SlewLimited', 'NotPresentable', 'TensionAtMax', 'TorqueIgnored')


@dataclass
class Preview:
    nominal: float       # as the scene says, in the unit of the measure
    presented: Estimate  # by the strings
    stiffness: float     # of what was touched [N/m]
    peak: float          # [N]
    share: float         # least, of the stiffness that a relaxed hand bears
    clamps: list         # limits of the device that acted


def clamp_bits():
    import session_data
    return sum(1 << session_data.FLAGS.index(name) for name in CLAMPS)


def key_of(condition):
    return repr(sorted((k, v) for k, v in condition.items() if k != 'name'))


class Previews:
    """Previews of a study's conditions, each made once."""

    def __init__(self, study, rig, folder):
        self.study, self.rig, self.folder, self.known = study, rig, folder, {}

    def of(self, condition):
        key = key_of(condition)
        if key not in self.known:
            self.known[key] = self._look(condition)
        return self.known[key]

    def nominal(self, condition):
        return self.of(condition).nominal

    def _look(self, condition):
        import session_data
        study = self.study
        self.rig.load(condition_scene.write(study, condition, self.folder), condition.get('rate', study.rate))
        hand = SimulatedHand(study.hand, study.measure, np.random.default_rng(SEED))
        samples = self.rig.explore(hand, min(2.0, study.phases.explore_seconds))
        flags = int(np.bitwise_or.reduce(samples.flags[samples.contact])) if samples.contact.any() else 0
        nominal = {'stiffness': self.rig.nominal, 'friction': condition.get('friction', math.nan),
                   'mass': condition.get('mass', math.nan)}.get(study.measure, math.nan)
        return Preview(nominal, presented(study.measure, samples, condition, study.added_delay(condition)),
                       self.rig.nominal,
                       float(np.linalg.norm(samples.force, axis=1).max()), float(samples.share[samples.contact].min(initial=1)),
                       [name for name in CLAMPS if flags >> session_data.FLAGS.index(name) & 1])
