/// Random trees of every joint type, for oracles that need many.
#pragma once
#include <random>
#include <string>
#include <vector>

#include "haptic_core/dynamics/articulation.h"

namespace haptic::test {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low = -1, double high = 1) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Vector3 randomVector(Random& random, double size = 1) {
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return size * Vector3(x, y, z);
}

inline Quaternion randomRotation(Random& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random), x = normal(random), y = normal(random), z = normal(random);
  return Quaternion(w, x, y, z).normalized();
}

/// Inertia of a solid box with random sides, about a random centre, in random axes: always physical.
inline LinkInertia randomInertia(Random& random) {
  LinkInertia inertia;
  inertia.mass = uniform(random, 0.2, 2);
  inertia.p_LC = randomVector(random, 0.1);
  const Vector3 side(uniform(random, 0.05, 0.3), uniform(random, 0.05, 0.3), uniform(random, 0.05, 0.3));
  const Vector3 s2 = side.cwiseAbs2();
  const Vector3 moments = inertia.mass / 12 * Vector3(s2.y() + s2.z(), s2.z() + s2.x(), s2.x() + s2.y());
  const Matrix3 R = randomRotation(random).toRotationMatrix();
  inertia.I_C = R * moments.asDiagonal() * R.transpose();
  inertia.I_C = 0.5 * (inertia.I_C + inertia.I_C.transpose()).eval();
  return inertia;
}

/// The parent of a link is any of the last `reach` before it: 4 makes trees deep, 60 bushy.
inline TreeDef randomTree(Random& random, int links, bool floating, int reach = 4) {
  TreeDef tree;
  tree.name = "tree";
  tree.X_WA = Pose(randomRotation(random), randomVector(random));
  std::vector<JointType> types = {JointType::kRevolute, JointType::kRevolute};  // what robots have most of
  for (const JointKind& kind : kJointKinds) {
    if (!kind.floating && degreesOf(kind) > 0) types.push_back(kind.type);
  }
  types.push_back(JointType::kFixed);
  for (int i = 0; i < links; ++i) {
    BodyDef body;
    body.name = "link" + std::to_string(i);
    body.parent = i == 0 ? -1 : i - 1 - static_cast<int>(random() % std::min(i, reach));
    body.joint.name = "joint" + std::to_string(i);
    body.joint.type = types[random() % types.size()];
    if (i == 0) body.joint.type = floating ? JointType::kFloating : JointType::kRevolute;
    body.joint.X_PJ = Pose(randomRotation(random), randomVector(random, 0.3));
    body.joint.axis = randomVector(random).normalized();
    body.inertia = randomInertia(random);
    tree.links.push_back(body);
  }
  return tree;
}

inline void randomState(Random& random, const Articulation& tree, std::vector<double>& q,
                        std::vector<double>& v) {
  q.assign(tree.nq(), 0);
  v.assign(tree.nv(), 0);
  for (double& x : q) x = uniform(random, -2, 2);
  for (double& x : v) x = uniform(random, -2, 2);
  for (int i = 0; i < tree.linkCount(); ++i) {
    const LinkModel& link = tree.link(i);
    const int at = link.q + link.slides;
    if (link.turns != 3) continue;
    const Quaternion r = randomRotation(random);
    q[at] = r.w();
    q[at + 1] = r.x();
    q[at + 2] = r.y();
    q[at + 3] = r.z();
  }
}

}  // namespace haptic::test
