"""SPIDAR haptics from Python: worlds in contact, string devices, and the haptic loop with a simulated device.

    import haptic
    world = haptic.World('touch_cube')
    world.step(1000)
    print(world.positions[world.link('cube')], world.contacts['normal_force'])

Arrays are views of the simulator's own memory: nothing is copied, and they show the next step as soon as it is made. Keep
`array.copy()` of what shall stay. SI units. Poses are 4 x 4 homogeneous matrices, `X_WG`: of frame G in frame W. Twists are
angular before linear, wrenches torque before force. What cannot be done raises `SetupError`, one line: what, where, what to do.
"""
from ._haptic import (Certificate, Device, EnergyLedger, Hand, Loop, PoseSolution, Scene, SetupError, StepReport, TensionReport,
                      World, __version__, certify)

__all__ = ['Certificate', 'Device', 'EnergyLedger', 'Hand', 'Loop', 'PoseSolution', 'Scene', 'SetupError', 'StepReport',
           'TensionReport', 'World', 'certify', '__version__']
