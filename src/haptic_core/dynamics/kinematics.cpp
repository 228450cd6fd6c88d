#include "haptic_core/dynamics/kinematics.h"

#include "haptic_core/base/elementary.h"
#include "haptic_core/dynamics/quaternion_step.h"

namespace haptic {
namespace {

Eigen::Map<const Vector3> vec3(const double* p) {
  return Eigen::Map<const Vector3>(p);
}

/// Pose of a link on a joint that hangs on R_WP, p_WP; fills X_WL, p_WO, r, S, p_OC.
void placeLink(const LinkModel& link, const double* q, const Matrix3& R_WP, const Vector3& p_WP, LinkWork& w) {
  if (link.floating) {
    w.X_WL.R = quaternionAt(q + 3).toRotationMatrix();
    w.r = vec3(q);
    w.p_WO = p_WP + w.r;
    w.X_WL.p.noalias() = w.p_WO - w.X_WL.R * link.p_LO;
    w.p_OC.setZero();
    return;
  }
  if (link.dof == 1) {
    w.S.col(0).noalias() = R_WP * link.axes_P.col(0);
  } else if (link.dof > 1) {
    w.S.noalias() = R_WP * link.axes_P;
  }
  if (link.turns == 1) {
    const auto [s, c] = elementary::sinCos(q[link.slides]);
    const Matrix3 R_PL = link.turn[0] + c * link.turn[1] + s * link.turn[2];
    w.X_WL.R.noalias() = R_WP * R_PL;
  } else if (link.turns == 3) {
    w.X_WL.R.noalias() = R_WP * (link.R_PJ * quaternionAt(q + link.slides).toRotationMatrix());
  } else {
    w.X_WL.R.noalias() = R_WP * link.R_PJ;
  }
  w.r.noalias() = R_WP * link.p_PJ;
  for (int k = 0; k < link.slides; ++k) w.r += q[k] * w.S.col(k);
  w.p_WO = p_WP + w.r;
  w.X_WL.p = w.p_WO;
  w.p_OC.noalias() = w.X_WL.R * link.p_OC;
}

/// Σ S_k v_k over the axes from `first` up to `end`; zero for none.
inline Vector3 alongAxes(const Matrix3& S, const double* v, int first, int end) {
  if (first == end) return Vector3::Zero();
  Vector3 sum = v[first] * S.col(first);
  for (int k = first + 1; k < end; ++k) sum += v[k] * S.col(k);
  return sum;
}

/// Twist of the link and its acceleration at v̇ = 0, from the parent's.
void moveLink(const LinkModel& link, const double* v, const LinkWork* parent, LinkWork& w) {
  if (link.floating) {
    w.omega = vec3(v);
    w.velocity = vec3(v + 3);
    return;
  }
  const Vector3 slide = alongAxes(w.S, v, 0, link.slides), turn = alongAxes(w.S, v, link.slides, link.dof);  // of L over P
  if (!parent) {
    w.omega = turn;
    w.velocity = slide;
    w.bias_angular.setZero();
    w.bias_linear.setZero();
    return;
  }
  const Vector3& omega_P = parent->omega;
  const Vector3 carried = omega_P.cross(w.r);
  w.omega = omega_P + turn;
  w.velocity = parent->velocity + carried + slide;
  w.bias_angular = omega_P.cross(turn);
  w.bias_linear = omega_P.cross(carried + 2 * slide);  // centripetal and Coriolis
}

}  // namespace

void forwardKinematics(const Articulation& articulation, const double* q, const double* v,
                       LinkWork* work) noexcept {
  if (articulation.isFreeBody()) {
    work->X_WL.R = quaternionAt(q + 3).toRotationMatrix();
    placeTurned(articulation.link(0), q, v, *work);
    return;
  }
  const Matrix3 identity = Matrix3::Identity();
  const Vector3 zero = Vector3::Zero();
  const int n = articulation.linkCount();
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    LinkWork& w = work[i];
    const LinkWork* parent = link.parent < 0 ? nullptr : work + link.parent;
    placeLink(link, q + link.q, parent ? parent->X_WL.R : identity, parent ? parent->p_WO : zero, w);
    moveLink(link, v + link.v, parent, w);
    w.F_ext.torque.setZero();
    w.F_ext.force.setZero();
  }
}

void forwardVelocities(const Articulation& articulation, const double* v, LinkWork* work) noexcept {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    moveLink(link, v + link.v, link.parent < 0 ? nullptr : work + link.parent, work[i]);
  }
}

void integratePositions(const Articulation& articulation, double* q, const double* v, double h) noexcept {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    for (int k = 0; k < link.slides; ++k) q[link.q + k] += h * v[link.v_slide + k];
    double* const turned = q + link.q + link.slides;
    if (link.turns == 1) {
      *turned += h * v[link.v_turn];
    } else if (link.turns == 3) {
      storeQuaternion(renormalised(quaternionStep(h * vec3(v + link.v_turn)) * quaternionAt(turned)), turned);
    }
  }
}

void addGeneralisedForce(const Articulation& articulation, const LinkWork* work, int link, const Wrench& F_W,
                         const Vector3& p_W, double* generalised) noexcept {
  for (int i = link; i >= 0; i = articulation.link(i).parent) {
    const LinkModel& model = articulation.link(i);
    const LinkWork& w = work[i];
    double* g = generalised + model.v;
    if (model.dof == 0) continue;
    if (model.turns == 0) {
      for (int k = 0; k < model.slides; ++k) g[k] += w.S.col(k).dot(F_W.force);
      continue;
    }
    const Vector3 torque = F_W.torque + (p_W - w.p_WO).cross(F_W.force);  // about O
    if (model.dof == 1) {
      g[0] += w.S.col(0).dot(torque);
    } else if (model.floating) {
      for (int k = 0; k < 3; ++k) {
        g[k] += torque[k];
        g[3 + k] += F_W.force[k];
      }
    } else {
      for (int k = 0; k < model.dof; ++k) g[k] += w.S.col(k).dot(k < model.slides ? F_W.force : torque);
    }
  }
}

Twist pointTwist(const Articulation& articulation, const LinkWork* work, int link, const Vector3& p_W,
                 const double* v) noexcept {
  Twist V;
  for (int i = link; i >= 0; i = articulation.link(i).parent) {
    const LinkModel& model = articulation.link(i);
    const LinkWork& w = work[i];
    const double* vi = v + model.v;
    if (model.dof == 0) continue;
    if (model.slides > 0) V.linear += model.floating ? Vector3(vec3(vi + 3)) : alongAxes(w.S, vi, 0, model.slides);
    if (model.turns == 0) continue;
    const Vector3 turn = model.floating ? Vector3(vec3(vi)) : alongAxes(w.S, vi, model.slides, model.dof);
    V.angular += turn;
    V.linear += turn.cross(p_W - w.p_WO);
  }
  return V;
}

void pointJacobian(const Articulation& articulation, const LinkWork* work, int link, const Vector3& p_W,
                   double* J, int stride) noexcept {
  const auto column = [&](int dof, const Vector3& angular, const Vector3& linear) {
    for (int k = 0; k < 3; ++k) {
      J[k * stride + dof] = angular[k];
      J[(3 + k) * stride + dof] = linear[k];
    }
  };
  const Vector3 zero = Vector3::Zero();
  for (int i = link; i >= 0; i = articulation.link(i).parent) {
    const LinkModel& model = articulation.link(i);
    const LinkWork& w = work[i];
    const Vector3 arm = p_W - w.p_WO;
    if (model.floating) {
      for (int k = 0; k < 3; ++k) {
        column(model.v + k, Vector3::Unit(k), Vector3::Unit(k).cross(arm));
        column(model.v + 3 + k, zero, Vector3::Unit(k));
      }
      continue;
    }
    for (int k = 0; k < model.slides; ++k) column(model.v + k, zero, w.S.col(k));
    for (int k = model.slides; k < model.dof; ++k) column(model.v + k, w.S.col(k), w.S.col(k).cross(arm));
  }
}

double kineticEnergy(const Articulation& articulation, const LinkWork* work) noexcept {
  double energy = 0;
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    const Vector3 omega_L = work[i].X_WL.R.transpose() * work[i].omega;
    const Vector3 v_WC = work[i].velocity + work[i].omega.cross(work[i].p_OC);
    energy += 0.5 * (omega_L.dot(link.I_C * omega_L) + link.mass * v_WC.squaredNorm());
  }
  return energy;
}

double potentialEnergy(const Articulation& articulation, const LinkWork* work,
                       const Vector3& gravity) noexcept {
  double energy = 0;
  for (int i = 0; i < articulation.linkCount(); ++i)
    energy -= articulation.link(i).mass * gravity.dot(work[i].p_WC());
  return energy;
}

Wrench momentum(const Articulation& articulation, const LinkWork* work, const Vector3& p_W) noexcept {
  Wrench L;
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    const Matrix3& R = work[i].X_WL.R;
    const Vector3 P = link.mass * (work[i].velocity + work[i].omega.cross(work[i].p_OC));
    L.torque += R * (link.I_C * (R.transpose() * work[i].omega)) + (work[i].p_WC() - p_W).cross(P);
    L.force += P;
  }
  return L;
}

}  // namespace haptic
