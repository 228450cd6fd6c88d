#include "haptic_core/contact/contact_gradient.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

/// The factor (1 + c ḋ) of the stiffness does not fall below this: a patch that parts fast presses little, but a
/// Newton step that believed it weightless would throw it back in.
constexpr double kLeastPressing = 0.05;

/// ∫ w [y, -x, 1]ᵀ [y, -x, 1] over the moments (m0, m1, m2) of w, into rows and columns θ_x, θ_y, z.
void addNormal(double scale, double m0, const Vector2& m1, const Matrix2& m2, Matrix6& out) {
  const double x = m1.x(), y = m1.y(), xx = m2(0, 0), xy = m2(0, 1), yy = m2(1, 1);
  const double block[3][3] = {{yy, -xy, y}, {-xy, xx, -x}, {y, -x, m0}};
  constexpr int kIndex[3] = {0, 1, 5};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out(kIndex[i], kIndex[j]) += scale * block[i][j];
  }
}

}  // namespace

ContactGradient contactGradient(const ContactVolume& contact, const Twist& V, const FrictionMemory& memory,
                                const PairLaw& law, double h, const ContactForce& force) noexcept {
  ContactGradient g;
  const ContactMaterial& m = law.material;
  if (force.normal_force <= 0) return g;
  if (law.pressure == PressureLaw::kHuntCrossley) {
    const double pressing = std::max(kLeastPressing, 1 - m.dissipation * V.linear.z());
    addNormal(m.stiffness * pressing, contact.A0, contact.A1, contact.A2, g.stiffness);
    addNormal(m.stiffness * m.dissipation, contact.volume, Vector2::Zero(), contact.V2, g.damping);
  } else {
    addNormal(m.stiffness, contact.A0, contact.A1, contact.A2, g.stiffness);
    addNormal(m.damping, contact.A0, contact.A1, contact.A2, g.damping);
  }
  if (m.mu_static <= 0 || contact.A0 <= 0) return g;
  const double J = std::max(0.0, contact.A2.trace() - contact.A1.squaredNorm() / contact.A0);
  const double kt = m.tangential_stiffness, bt = tangentialDamping(law, contact.A0);
  double along = 1, across = 1;  // share of the springs along the direction of slip, and across it
  Vector2 direction = Vector2::UnitX();
  if (!force.sticking) {
    const Vector3 slip_P = contact.X_AP.R.transpose() * memory.slip_A;
    const Vector2 trial = contact.A0 * (kt * (slip_P.head<2>() + h * V.linear.head<2>()) + bt * V.linear.head<2>());
    const double size = trial.norm();
    const double given = force.F_BP_P.force.head<2>().norm();
    across = size > 0 ? std::min(1.0, given / size) : 0;
    along = 0;
    if (size > 0) direction = trial / size;
  }
  const Matrix2 projection = across * Matrix2::Identity() + (along - across) * direction * direction.transpose();
  g.stiffness.block<2, 2>(3, 3) += kt * contact.A0 * projection;
  g.damping.block<2, 2>(3, 3) += bt * contact.A0 * projection;
  g.stiffness(2, 2) += across * kt * J;
  g.damping(2, 2) += across * bt * J;
  return g;
}

}  // namespace haptic
