// The table of joint kinds: its order, its axes, and that every kind integrates along them.
#include "haptic_core/dynamics/joint_type.h"

#include <gtest/gtest.h>

#include "haptic_core/dynamics/kinematics.h"
#include "random_tree.h"

namespace haptic::test {
namespace joint_type_test {

TEST(JointKinds, StandInTheOrderOfTheirValuesUnderOneNameEach) {
  for (std::size_t i = 0; i < std::size(kJointKinds); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kJointKinds[i].type), i);
    EXPECT_EQ(jointKind(kJointKinds[i].name), &kJointKinds[i]);
    EXPECT_TRUE(kJointKinds[i].turns == 0 || kJointKinds[i].turns == 1 || kJointKinds[i].turns == 3);
    if (kJointKinds[i].floating) continue;
    EXPECT_EQ(static_cast<int>(std::string(kJointKinds[i].axes).size()), degreesOf(kJointKinds[i]));
  }
  EXPECT_EQ(jointKind("cardan"), nullptr);
}

TEST(JointKinds, AxesAreOfUnitLengthAndAcrossOneAnother) {
  Random random(8);
  for (const JointKind& kind : kJointKinds) {
    const Vector3 a = randomVector(random).normalized();
    for (int k = 0; k < degreesOf(kind) && !kind.floating; ++k) {
      EXPECT_NEAR(axisOf(kind, k, a).norm(), 1, 1e-15) << kind.name;
      for (int j = 0; j < k; ++j) {
        const bool same = kind.axes[j] == kind.axes[k];  // a slide and a turn may share an axis
        EXPECT_NEAR(axisOf(kind, k, a).dot(axisOf(kind, j, a)), same, 1e-15) << kind.name;
      }
    }
  }
}

/// One joint of each kind, moved on by its own velocity: pose and twist agree with one another.
TEST(JointKinds, PositionsFollowVelocities) {
  Random random(9);
  for (const JointKind& kind : kJointKinds) {
    TreeDef def = randomTree(random, 2, true);
    def.links[1].joint.type = kind.type;
    const Articulation tree(def);
    std::vector<double> q, v;
    randomState(random, tree, q, v);
    for (int k = 0; k < 6; ++k) v[tree.link(0).v + k] = 0;  // the parent rests
    std::vector<LinkWork> work(2), before(2), after(2);
    forwardKinematics(tree, q.data(), v.data(), work.data());
    const double h = 1e-5;
    std::vector<double> q0 = q, q1 = q;
    integratePositions(tree, q0.data(), v.data(), -h);
    integratePositions(tree, q1.data(), v.data(), h);
    forwardKinematics(tree, q0.data(), v.data(), before.data());
    forwardKinematics(tree, q1.data(), v.data(), after.data());
    const Pose &X0 = before[1].X_WL, &X1 = after[1].X_WL;
    const Vector3 linear = (X1.p - X0.p) / (2 * h);
    const Vector3 angular = vectorFromRotation(Quaternion(X1.R * X0.R.transpose())) / (2 * h);
    // Central difference: h² v³/6 = 1e-9 at 4 rad/s, rounding 1e-16/h.
    EXPECT_NEAR((linear - work[1].twistAtOrigin().linear).norm(), 0, 3e-9) << kind.name;
    EXPECT_NEAR((angular - work[1].omega).norm(), 0, 3e-9) << kind.name;
  }
}

TEST(JointKinds, ScalarPoseIsWhereKinematicsPutsTheLink) {
  for (const JointKind& kind : kJointKinds) {
    if (!isScalar(kind.type)) continue;
    TreeDef def;
    BodyDef body;
    body.joint.type = kind.type;
    body.joint.axis = Vector3(1, 2, -2) / 3;
    body.joint.position = 0.7;
    body.inertia.mass = 1;
    body.inertia.I_C = Matrix3::Identity();
    def.links = {body};
    const Articulation tree(def);
    double q, v;
    tree.initialState(&q, &v);
    LinkWork work;
    forwardKinematics(tree, &q, &v, &work);
    const Pose X = scalarPose(kind, body.joint.axis, 0.7);
    EXPECT_NEAR((work.X_WL.R - X.R).norm() + (work.X_WL.p - X.p).norm(), 0, 1e-15) << kind.name;
  }
}

}  // namespace joint_type_test
}  // namespace haptic::test
