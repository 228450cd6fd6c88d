/// KDL's forward dynamics of a chain, by numbers alone. KDL's arrays are Eigen's, whose alignment depends on -march: it is
/// compiled as Debian compiled KDL, in a library of its own that shares no inline function with the benchmark.
#pragma once

namespace haptic::bench {

/// A revolute joint and the body behind it; the segment ends in `tip`. Axes of the link's frame.
struct KdlSegment {
  double axis[3];
  double tip[3];      ///< where the next joint sits [m]
  double mass;        ///< [kg]
  double centre[3];   ///< of mass, from the tip [m]
  double inertia[6];  ///< about the centre of mass: xx yy zz xy xz yz [kg m²]
};

struct KdlSolver;

KdlSolver* kdlMake(const KdlSegment* segments, int count, double gravity);
void kdlFree(KdlSolver* solver);
void kdlSetState(KdlSolver* solver, const double* q, const double* v);
void kdlEvaluate(KdlSolver* solver, double* v_dot);

}  // namespace haptic::bench
