#include "haptic_core/dynamics/kinematics.h"

#include "haptic_core/dynamics/quaternion_step.h"

namespace haptic {
namespace {

Eigen::Map<const Vector3> vec3(const double* p) {
  return Eigen::Map<const Vector3>(p);
}
Quaternion quaternion(const double* p) {
  return Quaternion(p[0], p[1], p[2], p[3]);
}

void store(const Quaternion& r, double* p) {
  p[0] = r.w();
  p[1] = r.x();
  p[2] = r.y();
  p[3] = r.z();
}

/// Pose of a link on a joint that hangs on R_WP, p_WP; fills X_WL, p_WO, r, S, p_OC.
void placeLink(const LinkModel& link, const double* q, const Matrix3& R_WP, const Vector3& p_WP,
               LinkWork& w) {
  switch (link.type) {
    case JointType::kFixed:
      w.X_WL.R.noalias() = R_WP * link.R_PJ;
      w.r.noalias() = R_WP * link.p_PJ;
      break;
    case JointType::kRevolute: {
      const double s = std::sin(q[0]), c = std::cos(q[0]);
      const Matrix3 R_PL = link.turn[0] + c * link.turn[1] + s * link.turn[2];
      w.X_WL.R.noalias() = R_WP * R_PL;
      w.r.noalias() = R_WP * link.p_PJ;
      w.S.col(0).noalias() = R_WP * link.axis_P;
      break;
    }
    case JointType::kPrismatic:
      w.X_WL.R.noalias() = R_WP * link.R_PJ;
      w.S.col(0).noalias() = R_WP * link.axis_P;
      w.r = R_WP * link.p_PJ + q[0] * w.S.col(0);
      break;
    case JointType::kPlanar: {
      const double s = std::sin(q[2]), c = std::cos(q[2]);
      Matrix3 R_z;
      R_z << c, -s, 0, s, c, 0, 0, 0, 1;
      w.S.noalias() = R_WP * link.R_PJ;
      w.X_WL.R = w.S * R_z * link.R_JL;
      w.r = R_WP * link.p_PJ + q[0] * w.S.col(0) + q[1] * w.S.col(1);
      break;
    }
    case JointType::kSpherical:
      w.S.noalias() = R_WP * link.R_PJ;
      w.X_WL.R.noalias() = w.S * quaternion(q).toRotationMatrix();
      w.r.noalias() = R_WP * link.p_PJ;
      break;
    case JointType::kFloating:
      w.X_WL.R = quaternion(q + 3).toRotationMatrix();
      w.r = vec3(q);
      break;
  }
  w.p_WO = p_WP + w.r;
  w.X_WL.p = w.p_WO;
  if (link.type == JointType::kFloating) {
    w.X_WL.p.noalias() -= w.X_WL.R * link.p_LO;
    w.p_OC.setZero();
  } else {
    w.p_OC.noalias() = w.X_WL.R * link.p_OC;
  }
}

/// Twist of the link and its acceleration at v̇ = 0, from the parent's.
void moveLink(const LinkModel& link, const double* v, const LinkWork* parent, LinkWork& w) {
  if (link.type == JointType::kFloating) {
    w.omega = vec3(v);
    w.velocity = vec3(v + 3);
    return;
  }
  Vector3 slide = Vector3::Zero(), turn = Vector3::Zero();  // of L over P
  switch (link.type) {
    case JointType::kRevolute:
      turn = v[0] * w.S.col(0);
      break;
    case JointType::kPrismatic:
      slide = v[0] * w.S.col(0);
      break;
    case JointType::kPlanar:
      slide = v[0] * w.S.col(0) + v[1] * w.S.col(1);
      turn = v[2] * w.S.col(2);
      break;
    case JointType::kSpherical:
      turn.noalias() = w.S * vec3(v);
      break;
    default:
      break;
  }
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

namespace {

/// placeLink and moveLink of a free body.
void placeFree(const LinkModel& link, const double* q, const double* v, LinkWork& w) {
  w.X_WL.R = quaternion(q + 3).toRotationMatrix();
  w.p_WO = w.r = vec3(q);
  w.X_WL.p = w.p_WO - w.X_WL.R * link.p_LO;
  w.p_OC.setZero();
  w.omega = vec3(v);
  w.velocity = vec3(v + 3);
  w.F_ext = Wrench{};
}

}  // namespace

void forwardKinematics(const Articulation& articulation, const double* q, const double* v,
                       LinkWork* work) noexcept {
  if (articulation.isFreeBody()) {
    placeFree(articulation.link(0), q, v, *work);
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
    double* qi = q + link.q;
    const double* vi = v + link.v;
    switch (link.type) {
      case JointType::kFixed:
        break;
      case JointType::kRevolute:
      case JointType::kPrismatic:
        qi[0] += h * vi[0];
        break;
      case JointType::kPlanar:
        for (int k = 0; k < 3; ++k) qi[k] += h * vi[k];
        break;
      case JointType::kSpherical:
        store(renormalised(quaternionStep(h * vec3(vi)) * quaternion(qi)), qi);
        break;
      case JointType::kFloating:
        for (int k = 0; k < 3; ++k) qi[k] += h * vi[3 + k];
        store(renormalised(quaternionStep(h * vec3(vi)) * quaternion(qi + 3)), qi + 3);
        break;
    }
  }
}

void addGeneralisedForce(const Articulation& articulation, const LinkWork* work, int link, const Wrench& F_W,
                         const Vector3& p_W, double* generalised) noexcept {
  for (int i = link; i >= 0; i = articulation.link(i).parent) {
    const LinkModel& model = articulation.link(i);
    const LinkWork& w = work[i];
    double* g = generalised + model.v;
    if (model.type == JointType::kFixed) continue;
    if (model.type == JointType::kPrismatic) {
      g[0] += w.S.col(0).dot(F_W.force);
      continue;
    }
    const Vector3 torque = F_W.torque + (p_W - w.p_WO).cross(F_W.force);  // about O
    switch (model.type) {
      case JointType::kRevolute:
        g[0] += w.S.col(0).dot(torque);
        break;
      case JointType::kPlanar:
        g[0] += w.S.col(0).dot(F_W.force);
        g[1] += w.S.col(1).dot(F_W.force);
        g[2] += w.S.col(2).dot(torque);
        break;
      case JointType::kSpherical:
        for (int k = 0; k < 3; ++k) g[k] += w.S.col(k).dot(torque);
        break;
      default:
        for (int k = 0; k < 3; ++k) {
          g[k] += torque[k];
          g[3 + k] += F_W.force[k];
        }
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
    Vector3 turn = Vector3::Zero();
    switch (model.type) {
      case JointType::kFixed:
        continue;
      case JointType::kPrismatic:
        V.linear += vi[0] * w.S.col(0);
        continue;
      case JointType::kRevolute:
        turn = vi[0] * w.S.col(0);
        break;
      case JointType::kPlanar:
        V.linear += vi[0] * w.S.col(0) + vi[1] * w.S.col(1);
        turn = vi[2] * w.S.col(2);
        break;
      case JointType::kSpherical:
        turn.noalias() = w.S * vec3(vi);
        break;
      case JointType::kFloating:
        V.linear += vec3(vi + 3);
        turn = vec3(vi);
        break;
    }
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
    switch (model.type) {
      case JointType::kFixed:
        break;
      case JointType::kPrismatic:
        column(model.v, zero, w.S.col(0));
        break;
      case JointType::kRevolute:
        column(model.v, w.S.col(0), w.S.col(0).cross(arm));
        break;
      case JointType::kPlanar:
        column(model.v, zero, w.S.col(0));
        column(model.v + 1, zero, w.S.col(1));
        column(model.v + 2, w.S.col(2), w.S.col(2).cross(arm));
        break;
      case JointType::kSpherical:
        for (int k = 0; k < 3; ++k) column(model.v + k, w.S.col(k), w.S.col(k).cross(arm));
        break;
      case JointType::kFloating:
        for (int k = 0; k < 3; ++k) {
          column(model.v + k, Vector3::Unit(k), Vector3::Unit(k).cross(arm));
          column(model.v + 3 + k, zero, Vector3::Unit(k));
        }
        break;
    }
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
