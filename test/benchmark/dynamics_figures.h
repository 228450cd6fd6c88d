/// The parts of `./run bench dynamics`; each prints its figures. Scenes: test/scenes; definitions: the report's list.
#pragma once

namespace haptic::bench {

/// Angle of a falling cube about its edge, and how fast it grows.
struct EdgeState {
  double angle, rate;  ///< [rad], [rad/s]
};

/// Angle at a share of a step of h between two states: the cubic through both ends' angles and rates, of error h⁴.
inline double between(const EdgeState& a, const EdgeState& b, double share, double h) {
  const double da = a.rate * h, db = b.rate * h;
  return a.angle + share * (da + share * (3 * (b.angle - a.angle) - 2 * da - db + share * (2 * (a.angle - b.angle) + da + db)));
}

/// Share of the step at which the angle falls through a level that lies between its ends, by bisection.
inline double passage(const EdgeState& a, const EdgeState& b, double level, double h) {
  double lo = 0, hi = 1;
  for (int i = 0; i < 60; ++i) (between(a, b, (lo + hi) / 2, h) > level ? lo : hi) = (lo + hi) / 2;
  return lo;
}

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
