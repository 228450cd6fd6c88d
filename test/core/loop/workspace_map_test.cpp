// Oracles: conservation of power through the map, continuity over a clutch, finite differences.
#include "haptic_core/loop/workspace_map.h"

#include <gtest/gtest.h>

namespace haptic {
namespace workspace_map_test {

Pose turned(double angle, const Vector3& axis, const Vector3& p) {
  return Pose(Matrix3(Eigen::AngleAxisd(angle, axis.normalized())), p);
}

const WorkspaceSettings kSettings{turned(0.7, {1, 2, 3}, {0.4, -0.2, 0.1}), 3.0};

TEST(WorkspaceMap, ScalesRotatesAndShifts) {
  WorkspaceMap map(kSettings);
  map.update(turned(0.2, {0, 0, 1}, {0.01, 0, 0}), {}, false);
  const Vector3 expected = kSettings.X_WB.p + kSettings.X_WB.R * Vector3(0.03, 0, 0);
  EXPECT_LT((map.X_WP().p - expected).norm(), 1e-15);
}

TEST(WorkspaceMap, TwistIsTheDerivativeOfThePose) {
  const double h = 1e-6;
  const Twist V{Vector3(0.3, -0.5, 0.2), Vector3(0.1, 0.2, -0.3)};
  WorkspaceMap before(kSettings), after(kSettings);
  const Pose X = turned(0.4, {1, 0, 1}, {0.02, 0.01, -0.01});
  before.update(X, V, false);
  after.update(Pose(rotationFromVector(V.angular * h).toRotationMatrix() * X.R, X.p + h * V.linear), V, false);
  const Vector3 linear = (after.X_WP().p - before.X_WP().p) / h;
  const Vector3 angular =
      vectorFromRotation(Quaternion(Matrix3(after.X_WP().R * before.X_WP().R.transpose()))) / h;
  EXPECT_LT((linear - before.V_WP().linear).norm(), 1e-8);    // rounding of p over h: 1e-16 / 1e-6
  EXPECT_LT((angular - before.V_WP().angular).norm(), 1e-8);
}

TEST(WorkspaceMap, PowerDiffersByTheScaleOnly) {
  WorkspaceMap map(kSettings);
  const Twist V{Vector3(0.3, -0.1, 0.5), Vector3(0.1, 0.2, -0.3)};
  map.update(turned(0.4, {1, 0, 1}, {0.02, 0.01, -0.01}), V, false);
  const Wrench F_W{Vector3(0.1, 0.2, 0.3), Vector3(1, -2, 3)};
  EXPECT_NEAR(power(F_W, map.V_WP()), kSettings.scale * power(map.toGrip(F_W), V), 1e-14);
}

TEST(WorkspaceMap, ClutchHoldsThePointerAndReleasesWithoutAJump) {
  WorkspaceMap map(kSettings);
  map.update(turned(0.1, {0, 1, 0}, {0.01, 0, 0}), {}, false);
  const Pose held = map.X_WP();
  const Pose away = turned(0.6, {1, 1, 0}, {-0.02, 0.03, 0.01});
  map.update(away, Twist{Vector3::Zero(), Vector3(1, 0, 0)}, true);
  EXPECT_EQ(map.X_WP().p, held.p);
  EXPECT_EQ(map.V_WP().linear, Vector3::Zero());
  map.update(away, {}, false);
  EXPECT_LT((map.X_WP().p - held.p).norm() + (map.X_WP().R - held.R).norm(), 1e-15);
  const Pose moved(away.R, away.p + Vector3(0, 0, 0.001));
  map.update(moved, {}, false);
  EXPECT_LT((map.X_WP().p - held.p - kSettings.X_WB.R * Vector3(0, 0, 0.003)).norm(), 1e-15);
}

}  // namespace workspace_map_test
}  // namespace haptic
