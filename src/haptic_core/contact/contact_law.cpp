#include "haptic_core/contact/contact_law.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/contact_integrals.h"

namespace haptic {
namespace {

/// r_τ over the radius of gyration of the pressure: ⅔ R over R/√2 for uniform pressure on a disc of radius R.
constexpr double kTorsionRadius = 2.0 / 3.0 * M_SQRT2;

/// Largest distance of V's vertices from its centroid, along the patch [m].
double patchReach(const ContactWorkspace& workspace, const ContactVolume& contact) {
  double reach2 = 0;
  for (const Vector3& vertex : workspace.vertices()) {
    reach2 = std::max(reach2, (contact.X_AP.R.transpose() * (vertex - contact.X_AP.p)).head<2>().squaredNorm());
  }
  return std::sqrt(reach2);
}

/// Normal wrench about P: force along z and moments about x and y.
struct NormalWrench {
  double force = 0, moment_x = 0, moment_y = 0;
  double damping_power = 0;
};

/// p = k d (φ - a·r) where positive, with φ = 1 - c v_z and a = c (-ω_y, ω_x).
NormalWrench huntCrossley(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V, double k,
                          double c) {
  const double phi = 1 - c * V.linear.z();
  const Vector2 a(-c * V.angular.y(), c * V.angular.x());
  // No point of V lies farther from its centroid than its diameter; where even that cannot turn the sign, the
  // whole patch presses and ∫ r d = 0.
  PartMoments part{contact.volume, Vector2::Zero(), contact.V2, contact.A0, contact.A1, contact.A2};
  if (phi - a.norm() * patchReach(workspace, contact) < 0) part = momentsWhere(workspace, contact, a, phi);
  NormalWrench n;
  n.force = k * (phi * part.volume - a.dot(part.V1));
  const Vector2 moment = k * (phi * part.V1 - part.V2 * a);  // ∫ r p
  n.moment_x = moment.y();
  n.moment_y = -moment.x();
  // The dampers' share of the power: p - k d on -ḋ = v_z + (a·r)/c, over the part; outside it the spring is held.
  const double vz = V.linear.z();
  if (c > 0) {
    const Vector2 slope = a / c;
    n.damping_power = k * c * (vz * vz * part.volume + 2 * vz * slope.dot(part.V1) + slope.dot(part.V2 * slope));
  }
  return n;
}

NormalWrench linear(const ContactVolume& contact, const Twist& V, double k, double b) {
  const double vz = V.linear.z(), wx = V.angular.x(), wy = V.angular.y();
  const double Ax = contact.A1.x(), Ay = contact.A1.y();
  const double Axx = contact.A2(0, 0), Axy = contact.A2(0, 1), Ayy = contact.A2(1, 1);
  NormalWrench n;
  const double rate = vz * contact.A0 + wx * Ay - wy * Ax;  // -∫ ḋ
  n.force = k * contact.volume - b * rate;
  n.moment_x = -b * (vz * Ay + wx * Ayy - wy * Axy);
  n.moment_y = b * (vz * Ax + wx * Axy - wy * Axx);
  if (n.force <= 0) return {};
  n.damping_power = b * (vz * rate + wx * (vz * Ay + wx * Ayy - wy * Axy) - wy * (vz * Ax + wx * Axy - wy * Axx));
  return n;
}

/// Friction by return mapping; fills force, torsion, memory and powers.
void friction(const ContactVolume& contact, const Twist& V, const FrictionMemory& memory, const PairLaw& law,
              double h, ContactForce& out) noexcept {
  const ContactMaterial& m = law.material;
  const double N = out.normal_force, A0 = contact.A0;
  if (N <= 0 || A0 <= 0 || m.mu_static <= 0) {
    out.memory = {};
    return;
  }
  const double J = std::max(0.0, contact.A2.trace() - contact.A1.squaredNorm() / A0);
  const double gyration2 = contact.volume > 0 ? contact.V2.trace() / contact.volume : J / A0;
  const double torsion_radius = kTorsionRadius * std::sqrt(std::max(0.0, gyration2));
  const double kt = m.tangential_stiffness;
  const double bt = tangentialDamping(law, A0);

  const Vector3 slip_P = contact.X_AP.R.transpose() * memory.slip_A;
  const Vector2 v = V.linear.head<2>();
  const double w = V.angular.z();
  Vector2 slip = slip_P.head<2>() + h * v;
  double twist = memory.twist + h * w;
  Vector2 f = -A0 * (kt * slip + bt * v);
  double tau = -J * (kt * twist + bt * w);

  const double limit = (memory.sliding > 0 ? m.mu_dynamic : m.mu_static) * N;
  const double torsion_limit = limit * torsion_radius;
  const double load = std::sqrt(f.squaredNorm() / (limit * limit) +
                                (torsion_limit > 0 ? tau * tau / (torsion_limit * torsion_limit) : 0.0));
  out.sticking = load <= 1;
  if (!out.sticking) {
    const double scale = m.mu_dynamic / (memory.sliding > 0 ? m.mu_dynamic : m.mu_static) / load;
    f *= scale;
    tau *= scale;
    // The anchors follow: the elastic part that is left carries what the damper does not.
    slip = -(f / A0 + bt * v) / kt;
    if (J > 0) twist = -(tau / J + bt * w) / kt;
  }
  const double damper = bt * (A0 * v.squaredNorm() + J * w * w);
  const double dissipated = -(f.dot(v) + tau * w);
  if (out.sticking) {
    out.damping_power += damper;
  } else {
    out.friction_power = std::max(0.0, dissipated);
  }
  out.F_BP_P.force.head<2>() = f;
  out.F_BP_P.torque.z() += tau;
  out.memory.slip_A = contact.X_AP.R * Vector3(slip.x(), slip.y(), 0);
  out.memory.twist = twist;
  out.memory.sliding = out.sticking ? 0 : 1;
}

}  // namespace

ContactForce contactForce(const ContactVolume& contact, ContactWorkspace& workspace, const Twist& V_AB_P,
                          const FrictionMemory& memory, const PairLaw& law, double h) noexcept {
  ContactForce out;
  const ContactMaterial& m = law.material;
  const NormalWrench normal = law.pressure == PressureLaw::kHuntCrossley
                                  ? huntCrossley(contact, workspace, V_AB_P, m.stiffness, m.dissipation)
                                  : linear(contact, V_AB_P, m.stiffness, m.damping);
  out.normal_force = normal.force;
  out.damping_power = normal.damping_power;
  out.F_BP_P.force.z() = normal.force;
  out.F_BP_P.torque = Vector3(normal.moment_x, normal.moment_y, 0);
  friction(contact, V_AB_P, memory, law, h, out);
  return out;
}

}  // namespace haptic
