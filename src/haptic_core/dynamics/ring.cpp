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
    double mass = 0, moment = 0;
    const auto add = [&](int link, const Pose& X_LF) {
      if (link < 0) return;
      const LinkInertia& body = articulation.def().links[link].inertia;
      mass += body.mass;
      moment += body.mass * (X_LF.p - body.p_LC).squaredNorm() + 0.5 * body.I_C.trace();
    };
    add(ring.link_a, ring.X_AF);
    add(ring.link_b, ring.X_BF);
    gyration2_.push_back(moment > 0 ? moment / mass : 1);  // links without inertia of their own have no scale
  }
  for (int i = 0; i < articulation.linkCount(); ++i)
    if (articulation.def().links[i].joint.mimic_joint >= 0) mimics_.push_back(i);
  rows_ += static_cast<int>(mimics_.size());
}

int Rings::mimicRow(int link) const {
  const auto at = std::lower_bound(mimics_.begin(), mimics_.end(), link);
  return rows_ - static_cast<int>(mimics_.end() - at);
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

void Rings::acceleration(const LinkWork* work, const double* v_dot, double* phi_ddot) const noexcept {
  struct Point {
    Vector3 omega = Vector3::Zero(), velocity = Vector3::Zero(), alpha = Vector3::Zero(), acceleration = Vector3::Zero();
  };
  const auto pointOf = [&](int link, const Vector3& p_W) -> Point {
    if (link < 0) return {};
    const LinkWork& w = work[link];
    const Vector3 arm = p_W - w.p_WO, turning = w.omega.cross(arm);
    return {w.omega, w.velocity + turning, w.alpha, w.acceleration + w.alpha.cross(arm) + w.omega.cross(turning)};
  };
  for (const RingDef& ring : rings_) {
    const Frames f = frames(ring, work);
    const Point a = pointOf(ring.link_a, f.X_WA.p), b = pointOf(ring.link_b, f.X_WB.p);
    // A row's direction e turns with a: (e·Δ)' = e·Δ' + (ω_a × e)·Δ.
    const auto add = [&](const Vector3& e, const Vector3& rate, const Vector3& change) {
      *phi_ddot++ = e.dot(change) + a.omega.cross(e).dot(rate);
    };
    const Vector3 turn = b.omega - a.omega, turn_rate = b.alpha - a.alpha;
    for (int k = 0; k < 3; ++k) add(f.X_WA.R.col(k), b.velocity - a.velocity, b.acceleration - a.acceleration);
    if (ring.type == RingDef::Type::kHinge) {
      Vector3 first, second;
      across(ring.axis, first, second);
      add(f.X_WA.R * first, turn, turn_rate);
      add(f.X_WA.R * second, turn, turn_rate);
    } else if (ring.type == RingDef::Type::kWeld) {
      for (int k = 0; k < 3; ++k) add(f.X_WA.R.col(k), turn, turn_rate);
    }
  }
  for (int i : mimics_) {
    const JointDef& joint = articulation_.def().links[i].joint;
    *phi_ddot++ = v_dot[articulation_.link(i).v] - joint.mimic_multiplier * v_dot[articulation_.link(joint.mimic_joint).v];
  }
}

void Rings::shareScale(double* of_equation) const noexcept {
  for (std::size_t i = 0; i < rings_.size(); ++i) {
    const int turns = rowsOf(rings_[i].type) - 3;
    double largest = 0;
    for (int k = 0; k < 3 + turns; ++k) largest = std::max(largest, of_equation[k] * (k < 3 ? 1 : gyration2_[i]));
    std::fill_n(of_equation, 3, largest);
    std::fill_n(of_equation + 3, turns, largest / gyration2_[i]);
    of_equation += 3 + turns;
  }
}

void Rings::follow(double* q, double* v) const noexcept {
  for (int i : mimics_) {
    const JointDef& joint = articulation_.def().links[i].joint;
    const LinkModel &follower = articulation_.link(i), &leader = articulation_.link(joint.mimic_joint);
    q[follower.q] = joint.mimic_multiplier * q[leader.q] + joint.mimic_offset;
    v[follower.v] = joint.mimic_multiplier * v[leader.v];
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
