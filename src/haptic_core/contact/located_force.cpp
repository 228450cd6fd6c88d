#include "haptic_core/contact/located_force.h"

namespace haptic {
ContactPower contactPower(const Wrench& F, const Wrench& elastic, const Twist& V) noexcept {
  const Wrench rest = F - elastic;
  return {-power(elastic, V), -(rest.force.z() * V.linear.z() + rest.torque.head<2>().dot(V.angular.head<2>())),
          -(rest.force.head<2>().dot(V.linear.head<2>()) + rest.torque.z() * V.angular.z())};
}

Matrix6 PatchTangent::combined(double x, double y) const noexcept {
  const PatchMoments w = stiffness * x + damping * y;
  Matrix6 out = Matrix6::Zero();
  // The quadratic form of v_z + ω_x r_y - ω_y r_x over the patch.
  out(0, 0) = w.m2(1, 1);
  out(1, 1) = w.m2(0, 0);
  out(5, 5) = w.m0;
  out(0, 1) = out(1, 0) = -w.m2(0, 1);
  out(0, 5) = out(5, 0) = w.m1.y();
  out(1, 5) = out(5, 1) = -w.m1.x();
  const Matrix3 layer = (x * tangential_stiffness + y * tangential_damping) * compliant_area;
  out.block<2, 2>(3, 3) = layer.topLeftCorner<2, 2>();
  out.block<1, 2>(2, 3) = layer.row(2).head<2>();
  out.block<2, 1>(3, 2) = layer.col(2).head<2>();
  out(2, 2) = layer(2, 2);
  return out;
}

LocatedForce locatedForce(const ContactVolume& contact, const Pose& X_AB, ContactWorkspace& workspace, const Twist& V,
                          const FrictionMemory& told, const PairLaw& law, const Advance& advance) noexcept {
  LocatedForce out;
  FrictionMemory memory = told;
  out.on_belt = advance.belts.any();
  out.surface_turn = carryMemory(advance.belts, advance.run, X_AB, contact.X_AP, memory);
  const NormalPressure normal = normalPressure(contact, workspace, V, law.pressure, law.material);
  const FrictionForce friction = frictionForce(contact, X_AB, workspace, normal, V, memory, law, advance);
  out.normal_force = normal.force;
  out.elastic_force = normal.elastic_force;
  out.clipped = normal.clipped;
  out.pressed = normal.pressed;
  out.incomplete = normal.dropped > 0;
  out.F_BP_P.force << friction.force, normal.force;
  out.F_BP_P.torque << normal.first.y(), -normal.first.x(), friction.torque;
  out.gradient_P = beyondNormal(contact, workspace, law.pressure, normal);
  out.beyond_P = out.gradient_P * shareBeyond(normal);
  out.F_BP_P += out.beyond_P;
  out.sticking = !friction.sliding;
  out.tangent = {normal.stiffness, normal.damping, friction.compliant_area, law.material.tangential_stiffness,
                 tangentialDamping(law, layerArea(contact))};
  out.layer = friction.layer;
  out.trial = friction.trial;
  out.renewed = friction.renewed;
  out.since = friction.since;

  const Matrix3& R_AP = contact.X_AP.R;
  const double A0 = layerArea(contact), J = torsionArea(contact), kt = law.material.tangential_stiffness;
  FrictionMemory& next = out.memory;
  next.point_A = contact.X_AP.p;
  next.normal_A = R_AP.col(2);
  const Vector3 slip_A = R_AP.leftCols<2>() * friction.slip;
  next.slip_M = out.toM(slip_A);
  next.anchor = memory.anchor;
  next.anchor.slip_A -= R_AP.leftCols<2>() * friction.spread.head<2>();
  next.anchor.twist -= friction.spread.z();
  if (friction.renewed) next.anchor = {X_AB, contact.X_AP.p, next.normal_A, slip_A, friction.twist};
  next.rate_M = out.toM(R_AP.leftCols<2>() * V.linear.head<2>());
  next.force_M = out.toM(R_AP.leftCols<2>() * friction.force);
  next.twist = friction.twist;
  next.spin = V.angular.z();
  next.torque = friction.torque;
  next.load = friction.load;
  next.area = A0;
  next.torsion = J;
  next.sliding = friction.sliding ? 1 : 0;
  next.touching = 1;
  next.began = 1 - memory.touching;
  next.energy = 0.5 * kt * (A0 * friction.slip.squaredNorm() + J * friction.twist * friction.twist);
  return out;
}

}  // namespace haptic
