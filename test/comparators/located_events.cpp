#include "located_events.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic::comparators {
namespace {

/// How a contact began inside the step: since when, and by how much a damper beside the spring has slowed the approach.
struct Touch {
  double since = 0;  ///< [s]; 0: not inside this step
  double decay = 0;  ///< x of e⁻ˣ [1]

  static Touch of(const ContactVolume& contact, double approach, const PairLaw& law, const FrictionMemory& memory,
                  const Advance& advance) {
    Touch touch;
    if (memory.touching != 0 || !(approach > 0) || contact.depth >= advance.time * approach) return touch;
    touch.since = contact.depth / approach;
    const bool brakes = jumpsAtTouch(law.pressure) && law.reduced_mass > 0;
    if (brakes) touch.decay = law.material.damping * contact.A0 * touch.since / law.reduced_mass;
    return touch;
  }
  double slowed() const { return elementary::exp(-decay); }
  /// Mean of the damper's force over the time since, by the force at its end.
  double mean() const { return decay > 0 ? elementary::expm1(decay) / decay : 1.0; }
};

/// A contact that began inside the step, after the share α. Its force grows like (t - t_touch)ⁿ with n = 1 on a
/// face, 2 on an edge, 3 on a corner: from dVol/dt = A0 ḋ, n = A0·depth/Vol. Then ∫F dt = F s/(n + 1) with s the
/// time since touch, of a damper alone (force like Vol's rate) F s/n; the trapezoidal rule takes F h/2.
void correctTouch(const ContactVolume& contact, const Touch& touch, PressureLaw law, double h, const LocatedForce& force,
                  LocatedEvent& event) {
  if (!(touch.since > 0)) return;
  const double since = touch.since;
  const double n = std::clamp(contact.A0 * contact.depth / contact.volume, 1.0, 3.0);
  const double spring = since / (n + 1) - h / 2, damper = touch.mean() * since / n - h / 2;
  const double elastic = jumpsAtTouch(law) ? force.elastic_force : force.normal_force;
  const double moments = jumpsAtTouch(law) ? damper : spring;
  event.elastic_P = force.elastic() * spring;
  event.impulse_P += force.beyond_P * spring;
  event.impulse_P.force.z() += spring * elastic + damper * (force.normal_force - elastic);
  event.impulse_P.torque.head<2>() += moments * (force.F_BP_P.torque - force.beyond_P.torque).head<2>();
  event.at = 1 - since / h;
  event.has_impulse = true;
}

/// The slip came to a stop inside the step, at a constant rate of the slip rate: only what came after loads the springs.
struct Stop {
  double at = 1;          ///< share of the step; 1: it did not
  FrictionMemory memory;  ///< measured from here and now, with the slip that the stop leaves

  Stop(const ContactVolume& contact, const Pose& X_AB, const Twist& V_P, const FrictionMemory& told, const PairLaw& law,
       const Advance& advance)
      : memory(told) {
    FrictionMemory before = told;
    carryMemory(advance.belts, advance.run, X_AB, contact.X_AP, before);
    if (before.touching == 0 || before.sliding == 0 || !(layerArea(contact) > 0)) return;
    const Matrix3& R_AP = contact.X_AP.R;
    const SharedTurn since(X_AB.R * before.anchor.X_AB.R.transpose());
    const auto inP = [&](const Vector3& v_M, double about_n) {
      const Vector3 v = R_AP.transpose() * since.toA(v_M);
      return Vector3(v.x(), v.y(), law.torsion ? about_n : 0.0);
    };
    const Vector3 old = inP(before.rate_M, before.spin), held = inP(before.slip_M, before.twist);
    const Vector3 rate(V_P.linear.x(), V_P.linear.y(), law.torsion ? V_P.angular.z() : 0.0);
    const double A0 = layerArea(contact);
    const Vector3 weight(A0, A0, torsionArea(contact));
    const double forward = old.dot(weight.cwiseProduct(old)), backward = -old.dot(weight.cwiseProduct(rate));
    if (!(backward > 0)) return;
    at = forward / (forward + backward);
    const Vector3 slip = held + rate * (0.5 * (1 - at) * advance.time);
    memory.anchor = {X_AB, contact.X_AP.p, R_AP.col(2), R_AP.leftCols<2>() * slip.head<2>(), slip.z()};
    memory.slip_M = since.toA(before.slip_M);
    memory.rate_M = since.toA(before.rate_M);
    memory.force_M = since.toA(before.force_M);
    carryMemory(advance.belts, -advance.run, X_AB, contact.X_AP, memory);  // belts go on by themselves
  }
};

/// ∫f dt over a step that yields after the share α: f0 … limit, then sliding; the rule takes (f0 + f1) h/2. `stuck`: as if it held.
void correctYield(const ContactVolume& contact, const FrictionMemory& memory, const LocatedForce& stuck, const LocatedForce& force,
                  double h, LocatedEvent& event) {
  const auto planar = [](const Wrench& F) { return Vector3(F.force.x(), F.force.y(), F.torque.z()); };
  const double load = stuck.memory.load;
  const double alpha = std::clamp((1 - memory.load) / std::max(load - memory.load, 1e-300), 0.0, 1.0);
  Vector3 before = contact.X_AP.R.transpose() * force.since.toA(memory.force_M);
  before.z() = memory.torque;
  const Vector3 beyond = planar(force.beyond_P), held = (planar(stuck.F_BP_P) - beyond) / std::max(1.0, load);
  const Vector3 missed = (before * (alpha - 1) + held * alpha + (planar(force.F_BP_P) - beyond) * (1 - 2 * alpha)) * (0.5 * h);
  event.at = alpha;
  event.impulse_P.force.head<2>() = missed.head<2>();
  event.impulse_P.torque.z() = missed.z();
  event.has_impulse = !missed.isZero(0);
}

}  // namespace

LocatedForce forceWithEvents(const ContactVolume& contact, const Pose& X_AB, ContactWorkspace& workspace, const Twist& V_AB_P,
                             const FrictionMemory& memory, const PairLaw& law, const Advance& advance, LocatedEvent& event) noexcept {
  event = {};
  const Touch touch = Touch::of(contact, -V_AB_P.linear.z(), law, memory, advance);
  Twist V_end = V_AB_P;  // slower than predicted: the damper has been at work since the touch
  if (touch.decay > 0) V_end.linear.z() *= touch.slowed();
  const Stop stop(contact, X_AB, V_AB_P, memory, law, advance);
  const LocatedForce force = locatedForce(contact, X_AB, workspace, V_end, stop.memory, law, advance);
  const bool slides = force.memory.sliding != 0;
  if (stop.at < 1 && !slides && force.normal_force > 0) event.at = stop.at;
  if (slides && memory.touching != 0 && memory.sliding == 0) {
    Advance holding = advance;
    holding.yielding = Yielding::kNever;
    correctYield(contact, memory, locatedForce(contact, X_AB, workspace, V_end, memory, law, holding), force, advance.time, event);
  }
  correctTouch(contact, touch, law.pressure, advance.time, force, event);
  return force;
}

}  // namespace haptic::comparators
