/// The parts of `./run bench dynamics`; each prints its figures. Scenes: test/scenes; definitions: the report's list.
#pragma once

namespace haptic::bench {

void restAndBounce();   ///< rest.*, bounce.*, energy.*
void tiltedCube();      ///< tilt.*
void spinningTop();     ///< top.*
void freeRotation();    ///< free.*
void stickSlip();       ///< stickslip.*
void slopeAndSliding(); ///< ramp.*, sliding.*, seam.*
void spinFriction();    ///< spin.*
void stacks();          ///< one_cube.*, stack15.*, pyramid15.*, blocks.*
void allocations();
void peers();           ///< peer.*: ODE, Bullet and MuJoCo on the same scenes

}  // namespace haptic::bench
