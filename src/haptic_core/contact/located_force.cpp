#include "haptic_core/contact/located_force.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

/// A contact that began inside the step, after the share α. Its force grows like (t - t_touch)ⁿ with n = 1 on a
/// face, 2 on an edge, 3 on a corner: from dVol/dt = A0 ḋ, n = A0·depth/Vol. Then ∫F dt = F s/(n + 1) with s the
/// time since touch, of a damper alone (force like Vol's rate) F s/n; the trapezoidal rule takes F h/2.
void correctTouch(const ContactVolume& contact, const NormalPressure& normal, double approach, PressureLaw law,
                  double h, LocatedForce& out) {
  if (!(approach > 0) || contact.depth >= h * approach) return;
  const double since = contact.depth / approach;
  const double n = std::clamp(contact.A0 * contact.depth / contact.volume, 1.0, 3.0);
  const double spring = since / (n + 1) - h / 2, damper = since / n - h / 2;
  const double elastic = law == PressureLaw::kLinear ? normal.elastic_force : normal.force;
  const double moments = law == PressureLaw::kLinear ? damper : spring;
  out.impulse_P.force.z() = spring * elastic + damper * (normal.force - elastic);
  out.impulse_P.torque.head<2>() = moments * Vector2(normal.first.y(), -normal.first.x());
  out.event = 1 - since / h;
  out.has_impulse = true;
}

/// Foundation of modulus `normal` under the whole patch and `tangential` along it: the quadratic form of
/// v_z + ω_x y - ω_y x, v_x - ω_z y', … over the area.
Matrix6 foundation(const ContactVolume& contact, double normal, double tangential, bool torsion) {
  const double Ax = contact.A1.x(), Ay = contact.A1.y();
  const double xx = contact.A2(0, 0), xy = contact.A2(0, 1), yy = contact.A2(1, 1);
  Matrix6 out = Matrix6::Zero();
  Eigen::Matrix3d n;  // in (ω_x, ω_y, v_z)
  n << yy, -xy, Ay, -xy, xx, -Ax, Ay, -Ax, contact.A0;
  n *= normal;
  const int index[3] = {0, 1, 5};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out(index[i], index[j]) = n(i, j);
  }
  out(2, 2) = torsion ? tangential * torsionArea(contact) : 0.0;
  out(3, 3) = out(4, 4) = tangential * contact.A0;
  return out;
}

}  // namespace

Matrix6 contactStiffness(const ContactVolume& contact, const PairLaw& law, bool sticking) noexcept {
  const double kt = sticking && law.material.mu_static > 0 ? law.material.tangential_stiffness : 0.0;
  return foundation(contact, law.material.stiffness, kt, law.torsion);
}

Matrix6 contactDamping(const ContactVolume& contact, const PairLaw& law, bool sticking,
                       const Advance& advance) noexcept {
  const ContactMaterial& m = law.material;
  // Hunt–Crossley's damper k c d, with d spread evenly.
  const double b = law.pressure == PressureLaw::kLinear ? m.damping
                                                        : m.stiffness * m.dissipation * contact.volume / contact.A0;
  const double bt = tangentialDamping(law, contact.A0) +
                    m.tangential_stiffness * advance.time * (1 - advance.old_share);
  return foundation(contact, b, sticking && m.mu_static > 0 ? bt : 0.0, law.torsion);
}

LocatedForce locatedForce(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V,
                          const FrictionMemory& memory, const PairLaw& law, const Advance& advance) noexcept {
  LocatedForce out;
  const NormalPressure normal = normalPressure(contact, workspace, V, law.pressure, law.material);
  const FrictionForce friction = frictionForce(contact, workspace, normal, V, memory, law, advance);
  out.normal_force = normal.force;
  out.clipped = normal.clipped;
  out.F_BP_P.force << friction.force, normal.force;
  out.F_BP_P.torque << normal.first.y(), -normal.first.x(), friction.torque;
  out.sticking = !friction.sliding;
  out.event = friction.event;
  if (advance.old_share > 0) {
    out.impulse_P.force.head<2>() = friction.impulse;
    out.impulse_P.torque.z() = friction.angular_impulse;
    out.has_impulse = !friction.impulse.isZero(0) || friction.angular_impulse != 0;
    if (memory.touching == 0) correctTouch(contact, normal, -V.linear.z(), law.pressure, advance.time, out);
  }

  const Matrix3& R_AP = contact.X_AP.R;
  const double A0 = contact.A0, J = torsionArea(contact), kt = law.material.tangential_stiffness;
  FrictionMemory& next = out.memory;
  next.slip_A = R_AP.leftCols<2>() * friction.slip;
  next.rate_A = R_AP.leftCols<2>() * V.linear.head<2>();
  next.force_A = R_AP.leftCols<2>() * friction.force;
  next.twist = friction.twist;
  next.spin = V.angular.z();
  next.torque = friction.torque;
  next.load = friction.load;
  next.area = A0;
  next.torsion = J;
  next.sliding = friction.sliding ? 1 : 0;
  next.touching = 1;
  next.power = -(friction.force.dot(V.linear.head<2>()) + friction.torque * V.angular.z());
  next.energy = 0.5 * kt * (A0 * friction.slip.squaredNorm() + J * friction.twist * friction.twist);
  next.damping_power = normal.damping_power;
  next.elastic_power = -V.linear.z() * normal.elastic_force;
  return out;
}

}  // namespace haptic
