// Forward dynamics of robots as loaded, against an independent library: KDL's recursive Newton-Euler must
// give back the joint forces that our accelerations came from.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <kdl/tree.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <random>

#include "haptic_core/dynamics/articulated_body.h"
#include "temporary_files.h"

namespace haptic {
namespace kdl_test {

namespace fs = std::filesystem;

KDL::Vector vector(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

KDL::Frame frame(const Pose& X) {
  const Matrix3& R = X.R;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          vector(X.p)};
}

KDL::RigidBodyInertia inertia(const LinkInertia& body) {
  const Matrix3& I = body.I_C;
  return KDL::RigidBodyInertia(body.mass, vector(body.p_LC),
                               KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
}

KDL::Tree kdlTree(const ArticulationDef& def) {
  KDL::Tree tree("base");
  for (std::size_t i = 0; i < def.links.size(); ++i) {
    const LinkDef& link = def.links[i];
    const Pose X_PJ = link.parent < 0 ? def.X_WA * link.joint.X_PJ : link.joint.X_PJ;
    KDL::Joint joint(link.joint.name, KDL::Joint::None);
    if (link.joint.type != JointType::kFixed) {
      joint =
          KDL::Joint(link.joint.name, vector(X_PJ.p), vector(X_PJ.R * link.joint.axis),
                     link.joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis);
    }
    const std::string parent = link.parent < 0 ? "base" : "s" + std::to_string(link.parent);
    EXPECT_TRUE(tree.addSegment(
        KDL::Segment("s" + std::to_string(i), joint, frame(X_PJ), inertia(link.inertia)), parent));
  }
  return tree;
}

/// Largest |τ_KDL − τ| over the largest |τ_KDL|, over random states, forces of joints and gravity.
double worstDifference(const ArticulationDef& def) {
  const Articulation ours(treeOf(def));
  const KDL::Tree tree = kdlTree(def);
  EXPECT_EQ(static_cast<int>(tree.getNrOfJoints()), ours.nv());
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double worst = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Vector3 gravity(uniform(random), uniform(random), -9.8);
    std::vector<double> q(ours.nq()), v(ours.nv()), tau(ours.nv()), v_dot(ours.nv());
    for (auto* numbers : {&q, &v, &tau}) {
      for (double& x : *numbers) x = uniform(random);
    }
    std::vector<LinkWork> work(ours.linkCount());
    forwardKinematics(ours, q.data(), v.data(), work.data());
    accelerations(ours, gravity, tau.data(), nullptr, work.data(), v_dot.data());
    KDL::TreeIdSolver_RNE solver(tree, vector(gravity));
    KDL::JntArray kq(ours.nv()), kv(ours.nv()), ka(ours.nv()), forces(ours.nv());
    std::vector<int> index(ours.nv());
    for (int i = 0; i < ours.linkCount(); ++i) {
      const LinkModel& link = ours.link(i);
      if (link.dof == 0) continue;
      const int k = static_cast<int>(tree.getSegment("s" + std::to_string(i))->second.q_nr);
      index[link.v] = k;
      kq(k) = q[link.q];
      kv(k) = v[link.v];
      ka(k) = v_dot[link.v];
    }
    EXPECT_GE(solver.CartToJnt(kq, kv, ka, KDL::WrenchMap(), forces), 0);
    double largest = 1, difference = 0;
    for (int i = 0; i < ours.nv(); ++i) {
      largest = std::max(largest, std::abs(forces(index[i])));
      difference = std::max(difference, std::abs(forces(index[i]) - tau[i]));
    }
    worst = std::max(worst, difference / largest);
  }
  return worst;
}

/// Accelerations of light links are large, so that the forces of joints near the base are small differences
/// of large ones: a few hundred roundings of a number ten thousand times the force.
constexpr double kTolerance = 1e-9;

TEST(Kdl, BranchedRobotWithSlidingAndTurningJoints) {
  std::string text = boxLink("trunk", 10, 0.3), parent;
  for (int limb = 0; limb < 4; ++limb) {
    parent = "trunk";
    for (int i = 0; i < 5; ++i) {
      const std::string name = "l" + std::to_string(limb) + std::to_string(i);
      text += boxLink(name, 0.5 + 0.1 * i, 0.05);
      text += joint("j_" + name, i == 3 ? "prismatic" : "revolute", parent, name,
                    std::string(i % 2 ? "<axis xyz=\"0 0.6 0.8\"/>" : "<axis xyz=\"1 0 0\"/>") +
                        "<limit lower=\"-1\" upper=\"1\" effort=\"20\" velocity=\"5\"/>",
                    "0.1 " + std::to_string(0.3 * limb) + " -0.2");
      parent = name;
    }
  }
  EXPECT_LT(worstDifference(loadText(robot(text)).world.articulations.at(0)), kTolerance);
}

TEST(Kdl, PublishedRobots) {
  const char* chosen = std::getenv("HAPTIC_ROBOTS");
  const fs::path folder =
      chosen ? fs::path(chosen) : fs::path(HAPTIC_SCENES) / "../../../shared/example-robot-data";
  std::error_code code;
  int tried = 0;
  for (fs::recursive_directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    if (entry->path().extension() != ".urdf") continue;
    const SceneDef scene = loadScene(entry->path().string());
    const ArticulationDef& def = scene.world.articulations.at(0);
    const bool simple = std::all_of(def.links.begin(), def.links.end(), [](const LinkDef& link) {
      return link.joint.type == JointType::kFixed || link.joint.type == JointType::kRevolute ||
             link.joint.type == JointType::kPrismatic;
    });
    if (!simple) continue;
    EXPECT_LT(worstDifference(def), kTolerance) << entry->path();
    ++tried;
  }
  if (tried == 0) GTEST_SKIP() << "no robots below " << folder << "; set HAPTIC_ROBOTS";
}

}  // namespace kdl_test
}  // namespace haptic
