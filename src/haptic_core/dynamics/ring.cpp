#include "haptic_core/dynamics/ring.h"

#include <algorithm>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

int rowsOf(RingDef::Type type) {
  return type == RingDef::Type::kPoint ? 3 : type == RingDef::Type::kHinge ? 5 : 6;
}

/// Two unit vectors across an axis.
void across(const Vector3& axis, Vector3& first, Vector3& second) {
  first = axis.unitOrthogonal();
  second = axis.cross(first);
}

}  // namespace

Rings::Rings(const Articulation& articulation, std::vector<RingDef> rings)
    : articulation_(articulation), rings_(std::move(rings)) {
  for (const RingDef& ring : rings_) {
    const int n = articulation.linkCount();
    if (ring.link_a < -1 || ring.link_a >= n || ring.link_b < -1 || ring.link_b >= n ||
        ring.link_a == ring.link_b)
      throw SetupError(articulation.def().name + "/" + ring.name,
                       "a ring joins links that are not there, or one link", "name two links of the model");
    rows_ += rowsOf(ring.type);
  }
  for (int i = 0; i < articulation.linkCount(); ++i)
    if (articulation.def().links[i].joint.mimic_joint >= 0) mimics_.push_back(i);
  rows_ += static_cast<int>(mimics_.size());
}

Rings::Frames Rings::frames(const RingDef& ring, const LinkWork* work) const noexcept {
  return {ring.link_a < 0 ? ring.X_AF : work[ring.link_a].X_WL * ring.X_AF,
          ring.link_b < 0 ? ring.X_BF : work[ring.link_b].X_WL * ring.X_BF};
}

void Rings::residual(const LinkWork* work, const double* q, double* phi) const noexcept {
  int row = 0;
  for (const RingDef& ring : rings_) {
    const Frames f = frames(ring, work);
    const Vector3 apart = f.X_WA.R.transpose() * (f.X_WB.p - f.X_WA.p);
    for (int k = 0; k < 3; ++k) phi[row++] = apart[k];
    if (ring.type == RingDef::Type::kHinge) {
      Vector3 first, second;
      across(ring.axis, first, second);
      const Vector3 tilt = ring.axis.cross(f.X_WA.R.transpose() * (f.X_WB.R * ring.axis));
      phi[row++] = tilt.dot(first);
      phi[row++] = tilt.dot(second);
    } else if (ring.type == RingDef::Type::kWeld) {
      const Vector3 turn = vectorFromRotation(Quaternion(f.X_WA.R.transpose() * f.X_WB.R));
      for (int k = 0; k < 3; ++k) phi[row++] = turn[k];
    }
  }
  for (int i : mimics_) {
    const JointDef& joint = articulation_.def().links[i].joint;
    phi[row++] = q[articulation_.link(i).q] -
                 (joint.mimic_multiplier * q[articulation_.link(joint.mimic_joint).q] + joint.mimic_offset);
  }
}

void Rings::jacobian(const LinkWork* work, double* G) const noexcept {
  const int nv = articulation_.nv();
  for (int i = 0; i < rows_ * nv; ++i) G[i] = 0;
  double* row = G;
  for (const RingDef& ring : rings_) {
    const Frames f = frames(ring, work);
    // Row e·(J_b − J_a) = J_bᵀ e − J_aᵀ e: a unit force or torque on b against one on a.
    const auto add = [&](const Wrench& unit) {
      if (ring.link_b >= 0) addGeneralisedForce(articulation_, work, ring.link_b, unit, f.X_WB.p, row);
      if (ring.link_a >= 0) addGeneralisedForce(articulation_, work, ring.link_a, -unit, f.X_WA.p, row);
      row += nv;
    };
    for (int k = 0; k < 3; ++k) add({Vector3::Zero(), f.X_WA.R.col(k)});
    if (ring.type == RingDef::Type::kHinge) {
      Vector3 first, second;
      across(ring.axis, first, second);
      add({f.X_WA.R * first, Vector3::Zero()});
      add({f.X_WA.R * second, Vector3::Zero()});
    } else if (ring.type == RingDef::Type::kWeld) {
      for (int k = 0; k < 3; ++k) add({f.X_WA.R.col(k), Vector3::Zero()});
    }
  }
  for (int i : mimics_) {
    const JointDef& joint = articulation_.def().links[i].joint;
    row[articulation_.link(i).v] = 1;
    row[articulation_.link(joint.mimic_joint).v] = -joint.mimic_multiplier;
    row += nv;
  }
}

void Rings::shareScale(double* of_equation) const noexcept {
  for (const RingDef& ring : rings_) {
    for (const int count : {3, rowsOf(ring.type) - 3}) {
      if (count == 0) continue;
      std::fill_n(of_equation, count, *std::max_element(of_equation, of_equation + count));
      of_equation += count;
    }
  }
}

double Rings::closure(const LinkWork* work) const noexcept {
  double largest = 0;
  for (const RingDef& ring : rings_) {
    const Frames f = frames(ring, work);
    largest = std::max(largest, (f.X_WB.p - f.X_WA.p).norm());
  }
  return largest;
}

}  // namespace haptic
