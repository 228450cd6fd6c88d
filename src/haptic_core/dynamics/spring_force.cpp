/// A spring with a damper between two points, with a rest length and a limit of its force:
///     f = clamp(-k (ℓ - ℓ0) - d ℓ', -most, most)  on B along n = (p_WB - p_WA)/ℓ.
/// Beyond the limit it pulls with a constant force; its energy goes on as a straight line. Where the points meet, n is undefined: a
/// spring of rest length 0 is isotropic there, one that is longer does nothing.
#include "haptic_core/dynamics/force_kinds.h"

namespace haptic {
namespace {

/// ∫ clamp(k x, ±most) dx [J].
double storedAt(double x, double k, double most) {
  const double pull = k * std::abs(x);
  if (!(pull > most)) return 0.5 * pull * std::abs(x);
  return most * (std::abs(x) - 0.5 * most / k);
}

}  // namespace

void actAsSpring(const double* parameter, const ForceEnds& ends, LinkForce& force) noexcept {
  const double k = parameter[kSpringStiffness], d = parameter[kSpringDamping], rest = parameter[kSpringRestLength],
               most = parameter[kSpringMost];
  force.place(ends, ends.X_WA() * ends.p_A, ends.b->X_WL * ends.p_B);
  const Vector3 r = force.p_WB - force.p_WA;
  const double length = r.norm(), stretch = length - rest;
  force.stored = storedAt(stretch, k, most);
  if (!(length > 0)) {
    if (rest > 0) return;
    force.way_K.diagonal().setConstant(k);
    force.way_D.diagonal().setConstant(d);
    force.F.force = -d * force.V.linear;
    return;
  }
  LineForce& line = force.line;
  line.n = r / length;
  line.spring = -k * stretch;
  line.damper = -d * line.n.dot(force.V.linear);
  line.stiffness = k;
  line.damping = d;
  line.least = -most;
  line.most = most;
  // A pull also turns the line back; a push would turn it on.
  const double tension = std::max(0.0, -line.within(line.spring));
  force.way_K = tension / length * (Matrix3::Identity() - line.n * line.n.transpose());
}

}  // namespace haptic
