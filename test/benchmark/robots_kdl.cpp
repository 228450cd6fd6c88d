#include "robots_kdl.h"

#include <algorithm>
#include <cmath>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <random>
#include <string>
#include <vector>

#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/dynamics/kinematics.h"

namespace haptic::bench {
namespace {

KDL::Vector vector(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame frame(const Pose& X) {
  const Matrix3& R = X.R;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)), vector(X.p)};
}

std::string segmentName(std::size_t link) { return "s" + std::to_string(link); }

KDL::Tree treeFor(const ArticulationDef& def) {
  KDL::Tree tree("base");
  for (std::size_t i = 0; i < def.links.size(); ++i) {
    const LinkDef& link = def.links[i];
    const Pose X_PJ = link.parent < 0 ? def.X_WA * link.joint.X_PJ : link.joint.X_PJ;
    const Matrix3& I = link.inertia.I_C;
    const KDL::RigidBodyInertia inertia(link.inertia.mass, vector(link.inertia.p_LC),
                                        KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
    KDL::Joint joint(link.joint.name, KDL::Joint::None);
    if (link.joint.type != JointType::kFixed) {
      joint = KDL::Joint(link.joint.name, vector(X_PJ.p), vector(X_PJ.R * link.joint.axis),
                         link.joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis);
    }
    tree.addSegment(KDL::Segment(segmentName(i), joint, frame(X_PJ), inertia),
                    link.parent < 0 ? "base" : segmentName(static_cast<std::size_t>(link.parent)));
  }
  return tree;
}

struct Worst {
  double difference = 0, size = 0;
  void take(double ours, double theirs) {
    difference = std::max(difference, std::abs(ours - theirs));
    size = std::max(size, std::abs(theirs));
  }
  double scaled() const { return size > 0 ? difference / size : difference; }
};

}  // namespace

bool kdlKnows(const ArticulationDef& tree) {
  return std::all_of(tree.links.begin(), tree.links.end(), [](const LinkDef& link) {
    return link.joint.type == JointType::kFixed || isScalar(link.joint.type);
  });
}

double differenceFromKdl(const ArticulationDef& def) {
  const Articulation ours(treeOf(def));
  const KDL::Tree tree = treeFor(def);
  const int n = ours.nv();
  std::vector<int> index(n);
  for (int i = 0; i < ours.linkCount(); ++i) {
    if (ours.link(i).dof > 0) index[ours.link(i).v] = static_cast<int>(tree.getSegment(segmentName(i))->second.q_nr);
  }
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  KDL::TreeFkSolverPos_recursive poses(tree);
  KDL::TreeIdSolver_RNE weightless(tree, KDL::Vector::Zero()), heavy(tree, KDL::Vector(0, 0, -9.8));
  std::vector<LinkWork> work(ours.linkCount());
  double worst = 0;
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<double> q(ours.nq()), v(n, 0.0), M(static_cast<std::size_t>(n) * n), tau(n);
    KDL::JntArray kq(n), rest(n), kv_dot(n), forces(n);
    for (int i = 0; i < n; ++i) q[i] = uniform(random), kq(index[i]) = q[i];
    forwardKinematics(ours, q.data(), v.data(), work.data());
    Worst pose, mass, gravity;
    for (int i = 0; i < ours.linkCount(); ++i) {
      KDL::Frame X;
      poses.JntToCart(kq, X, segmentName(i));
      for (int k = 0; k < 3; ++k) {
        pose.take(work[i].X_WL.p[k], X.p[k]);
        for (int l = 0; l < 3; ++l) pose.take(work[i].X_WL.R(k, l), X.M(k, l));
      }
    }
    inverseDynamics(ours, Vector3(0, 0, -9.8), nullptr, work.data(), tau.data());
    heavy.CartToJnt(kq, rest, rest, KDL::WrenchMap(), forces);
    for (int i = 0; i < n; ++i) gravity.take(tau[i], forces(index[i]));
    massMatrix(ours, work.data(), M.data());
    for (int j = 0; j < n; ++j) {
      KDL::SetToZero(kv_dot);
      kv_dot(index[j]) = 1;
      weightless.CartToJnt(kq, rest, kv_dot, KDL::WrenchMap(), forces);
      for (int i = 0; i < n; ++i) mass.take(M[static_cast<std::size_t>(i) * n + j], forces(index[i]));
    }
    for (const Worst& each : {pose, mass, gravity}) worst = std::max(worst, each.scaled());
  }
  return worst;
}

std::vector<double> kdlInverseDynamics(const ArticulationDef& def, const std::vector<double>& q, const std::vector<double>& v,
                                       const std::vector<double>& v_dot, const Vector3& gravity) {
  const KDL::Tree tree = treeFor(def);
  const auto n = static_cast<unsigned>(q.size());
  KDL::TreeIdSolver_RNE solver(tree, vector(gravity));
  KDL::JntArray kq(n), kv(n), ka(n), forces(n);
  std::vector<unsigned> index;
  for (std::size_t i = 0; i < def.links.size(); ++i) {
    if (def.links[i].joint.type != JointType::kFixed) index.push_back(tree.getSegment(segmentName(i))->second.q_nr);
  }
  for (std::size_t i = 0; i < index.size(); ++i) kq(index[i]) = q[i], kv(index[i]) = v[i], ka(index[i]) = v_dot[i];
  solver.CartToJnt(kq, kv, ka, KDL::WrenchMap(), forces);
  std::vector<double> found;
  for (const unsigned i : index) found.push_back(forces(i));
  return found;
}

}  // namespace haptic::bench
