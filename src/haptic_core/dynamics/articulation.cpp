#include "haptic_core/dynamics/articulation.h"

#include <cmath>

#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/base/error.h"
#include "haptic_core/base/symmetric_matrix.h"
#include "haptic_core/dynamics/quaternion_step.h"
#include "haptic_core/dynamics/thread.h"

namespace haptic {
namespace {

// Unit vectors written in URDF carry 6 digits or so; a longer deviation is a mistake, not rounding.
constexpr double kAxisTolerance = 1e-3;
// Published inertias are rounded: a moment may fall below zero by this share of the trace.
constexpr double kMomentTolerance = 1e-3;
// What counts where a link has no mass or no moment about an axis, of the tree's mass and of its other moments. Less, and numbers
// that bound how easily a link moves lose their digits; more, and one that is just slender (1:1e4) counts as harder to move [1].
constexpr double kLeastShare = 1e-9;
constexpr double kLeastReach = 1e-2;  // radius of gyration of a link that has mass and no extent at all [m]

void checkInertia(const std::string& where, const LinkInertia& inertia) {
  if (!std::isfinite(inertia.mass) || !inertia.p_LC.allFinite() || !inertia.I_C.allFinite())
    throw SetupError(where, "inertia is not a finite number", "give mass, origin and inertia");
  if (inertia.mass < 0)
    throw SetupError(where, "mass " + std::to_string(inertia.mass) + " kg is negative", "");
  const double trace = inertia.I_C.trace();
  if ((inertia.I_C - inertia.I_C.transpose()).cwiseAbs().maxCoeff() > 1e-9 * trace)
    throw SetupError(where, "inertia matrix is not symmetric", "");
  const Vector3 moments = principalAxes(inertia.I_C).value;
  if (moments.minCoeff() < -kMomentTolerance * trace)
    throw SetupError(where, "a principal moment of inertia is negative", "check the signs of ixy, ixz, iyz");
  // A moment larger than the sum of the others belongs to no body, but published robots have such links, and the
  // equations hold for any positive inertia: who reads the file warns of it.
}

void checkJoint(const std::string& where, const JointDef& joint) {
  if (hasAxis(kindOf(joint.type)) && !(std::abs(joint.axis.norm() - 1) < kAxisTolerance))
    throw SetupError(where, "axis is not a unit vector", "normalise it");
  if (!joint.X_PJ.R.allFinite() || !joint.X_PJ.p.allFinite() || !std::isfinite(joint.position) ||
      !std::isfinite(joint.velocity))
    throw SetupError(where, "origin or position is not a finite number", "");
  if (!(joint.lower <= joint.upper))
    throw SetupError(where, "lower limit is above the upper one", "exchange them");
  if (!(joint.damping >= 0) || !(joint.friction >= 0) || !(joint.drive_stiffness >= 0) ||
      !(joint.drive_damping >= 0) || !(joint.max_effort >= 0) || !(joint.spring_stiffness >= 0) || std::isinf(joint.spring_stiffness) ||
      !std::isfinite(joint.spring_position))
    throw SetupError(where, "damping, friction, gains of drives and springs, and effort must be numbers >= 0", "");
}

void checkThread(const std::string& where, const TreeDef& tree, const JointDef& slide) {
  if (slide.thread_friction == 0) return;
  const bool slides = kindOf(slide.type).slides == 1 && isScalar(slide.type);
  if (!slides || slide.mimic_joint < 0 || kindOf(tree.links[slide.mimic_joint].joint.type).turns != 1)
    throw SetupError(where, "only a slide that follows a turn has a thread", "let it mimic the turn");
  if (!(slide.thread_friction > 0) || !(slide.thread_radius > 0) || std::isinf(slide.thread_radius) ||
      !(slide.thread_flank >= 0 && slide.thread_flank < 1.5))
    throw SetupError(where, "a thread's friction and radius must be numbers > 0, its flank's angle from 0 to 1.5 rad", "");
  if (!Thread(slide).turns())
    throw SetupError(where, "the thread's friction holds at every torque", "lower the friction, or the lead over the pitch diameter");
}

}  // namespace

Articulation::Articulation(const TreeDef& def) : def_(def) {
  const int n = static_cast<int>(def.links.size());
  links_.resize(n);
  for (int i = 0; i < n; ++i) {
    const BodyDef& body = def.links[i];
    const std::string where = def.name + "/" + body.name;
    if (body.parent >= i || body.parent < -1)
      throw SetupError(where, "parent does not come before its child", "order the links from root to leaves");
    checkJoint(where + " (joint " + body.joint.name + ")", body.joint);
    checkInertia(where, body.inertia);
    const int mimic = body.joint.mimic_joint;
    if (mimic >= n || mimic == i || (mimic >= 0 && !isScalar(def.links[mimic].joint.type)) ||
        (mimic >= 0 && !isScalar(body.joint.type)))
      throw SetupError(where + " (joint " + body.joint.name + ")", "mimics a joint that has not one degree of freedom",
                       "");
    checkThread(where + " (joint " + body.joint.name + ")", def, body.joint);
    compileLink(i);
  }
  free_body_ = n == 1 && links_[0].floating;
  double mass = 0;
  for (const LinkModel& link : links_) mass += link.mass;
  for (int i = 0; i < n; ++i) boundMobility(i, mass);
}

void Articulation::boundMobility(int i, double tree_mass) {
  LinkModel& link = links_[i];
  const double mass = std::max(link.mass, kLeastShare * tree_mass);
  if (!(mass > 0)) return;  // nothing of the tree has any: no force moves it
  const double turns_C = link.I_C.trace(), turns_O = link.I_O.trace();
  const double scale = turns_C > 0 ? turns_C : turns_O > 0 ? turns_O : mass * kLeastReach * kLeastReach;
  const PrincipalAxes moments = principalAxes(link.I_C);
  Matrix3 I_C = link.I_C;
  if (!(moments.value.minCoeff() > kLeastShare * scale)) {
    const Vector3 least = moments.value.cwiseMax(kLeastShare * scale);
    I_C = moments.axes * least.asDiagonal() * moments.axes.transpose();
  }
  link.mobility = 1 / mass;
  link.turn_mobility = I_C.inverse();
  link.rooted = link.parent < 0 && !link.floating && link.dof > 0;
  if (!link.rooted) return;
  const JointDef& joint = def_.links[i].joint;
  for (int k = 0; k < link.dof; ++k) {
    const Vector3 axis = axisOf(kindOf(joint.type), k, joint.axis.normalized());
    if (k < link.slides) {
      link.S_C.col(k) << Vector3::Zero(), axis;
    } else {
      link.S_C.col(k) << axis, axis.cross(link.p_OC);
    }
  }
  const auto turns = link.S_C.topLeftCorner(3, link.dof), slides = link.S_C.bottomLeftCorner(3, link.dof);
  const Eigen::MatrixXd inertia = turns.transpose() * I_C * turns + mass * slides.transpose() * slides;
  link.joint_mobility.topLeftCorner(link.dof, link.dof) = inverse(inertia);
}

void Articulation::compileLink(int i) {
  BodyDef& body = def_.links[i];
  LinkModel& link = links_[i];
  const JointDef& joint = body.joint;
  const std::string where = def_.name + "/" + body.name;
  const JointKind& kind = kindOf(joint.type);
  const bool floating = link.floating = kind.floating;
  link.parent = floating ? -1 : body.parent;
  root_.push_back(link.parent < 0 ? i : root_[link.parent]);
  link.slides = kind.slides;
  link.turns = kind.turns;
  link.dof = degreesOf(kind);
  link.q = nq_;
  link.v = nv_;
  link.v_slide = nv_ + (floating ? kind.turns : 0);
  link.v_turn = nv_ + (floating ? 0 : kind.slides);
  nq_ += positionsOf(kind);
  nv_ += link.dof;

  Pose X_PJ = joint.X_PJ;
  if (body.parent < 0) X_PJ = def_.X_WA * X_PJ;
  const Vector3 axis = joint.axis.normalized();
  const Vector3 p_LO_parent = link.parent < 0 ? Vector3::Zero() : links_[link.parent].p_LO;
  link.p_PJ = X_PJ.p - p_LO_parent;
  link.R_PJ = X_PJ.R;
  for (int k = 0; k < link.dof && !floating; ++k) link.axes_P.col(k) = X_PJ.R * axisOf(kind, k, axis);
  if (link.turns == 1) {
    const Vector3 about = axisOf(kind, link.slides, axis);
    link.turn[0] = X_PJ.R * about * about.transpose();
    link.turn[1] = X_PJ.R - link.turn[0];
    link.turn[2] = X_PJ.R * crossMatrix(about);
  }
  link.mass = body.inertia.mass;
  link.I_C = body.inertia.I_C;
  link.p_LO = floating ? body.inertia.p_LC : Vector3::Zero();
  link.p_OC = body.inertia.p_LC - link.p_LO;
  link.I_O = link.I_C +
             link.mass * (link.p_OC.squaredNorm() * Matrix3::Identity() - link.p_OC * link.p_OC.transpose());
  if (floating) {
    if (!(link.mass > 0))
      throw SetupError(where, "a floating link has no mass", "give <inertial> or a density");
    if (!(principalAxes(link.I_C).value.minCoeff() > 0))
      throw SetupError(where, "a floating link has no inertia about some axis",
                       "give <inertial> or a density");
    link.I_O_inverse = link.I_C.inverse();
  }
}

void Articulation::initialState(double* q, double* v) const {
  for (int i = 0; i < nv_; ++i) v[i] = 0;
  std::vector<Pose> X_W(links_.size());  // link frames at the initial state, to place floating links
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const LinkModel& link = links_[i];
    const BodyDef& body = def_.links[i];
    double* qi = q + link.q;
    const Pose& X_WP = body.parent < 0 ? def_.X_WA : X_W[body.parent];
    X_W[i] = X_WP * body.joint.X_PJ;
    if (!link.floating) {
      const JointKind& kind = kindOf(body.joint.type);
      for (int k = 0; k < positionsOf(kind); ++k) qi[k] = 0;
      if (link.turns == 3) qi[link.slides] = 1;  // the quaternion of no rotation
      if (link.dof == 1) {
        qi[0] = body.joint.position;
        v[link.v] = body.joint.velocity;
        X_W[i] = X_W[i] * scalarPose(kind, body.joint.axis.normalized(), qi[0]);
      }
      continue;
    }
    const Vector3 p_WC = X_W[i] * link.p_LO;
    for (int k = 0; k < 3; ++k) qi[k] = p_WC[k];
    storeQuaternion(Quaternion(X_W[i].R).normalized(), qi + 3);
    const Twist V = def_.V_WA.shifted(p_WC - def_.X_WA.p);
    Eigen::Map<Vector3>(v + link.v) = V.angular;
    Eigen::Map<Vector3>(v + link.v + 3) = V.linear;
  }
}

}  // namespace haptic
