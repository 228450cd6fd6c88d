/// The god object: its search against distances, its force against closed forms, and that nothing passes it
/// by.
#include "../../comparators/god_object.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace god_object_test {

using bench::GodObject;
using bench::GodObjectSettings;
using bench::TriangleTree;

constexpr double kSkin = 2e-9;  ///< [m] that the proxy stays off surfaces, on each of two walls
constexpr double kK = 1000;     ///< [N/m]

/// A plate whose upper face is the plane z = 0.
TriangleMesh plate(double thickness = 0.1) {
  TriangleMesh mesh = makeBox({1, 1, thickness}).triangles();
  for (Vector3& v : mesh.vertices) v.z() -= thickness / 2;
  return mesh;
}

GodObject over(const TriangleMesh& mesh, const GodObjectSettings& settings, const Vector3& start) {
  GodObject god(settings, start);
  god.addMesh(mesh, Pose());
  return god;
}

/// Leads the hand along a line, in ticks; the last force.
Vector3 lead(GodObject& god, const Vector3& from, const Vector3& to, int ticks) {
  Vector3 F = Vector3::Zero();
  for (int i = 0; i <= ticks; ++i) F = god.tick(from + (to - from) * i / ticks);
  return F;
}

/// A ball that is swept against a convex mesh ends at its radius from it, and was farther before.
TEST(GodObject, FirstTouchIsWhereTheDistanceIsTheRadius) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto direction = [&] {
    return Vector3(uniform(random), uniform(random), uniform(random)).normalized();
  };
  const TriangleMesh meshes[] = {makeBox({0.1, 0.2, 0.05}).triangles(), makeSphere(0.1, 2).triangles(),
                                 makeCylinder(0.05, 0.2, 9).triangles()};
  int touched = 0, missed = 0;
  for (const TriangleMesh& mesh : meshes) {
    const TriangleTree tree(mesh);
    for (int i = 0; i < 400; ++i) {
      const Vector3 from = 0.5 * direction(), to = from + 0.8 * (0.15 * direction() - from).normalized();
      const double radius = i % 2 ? 0.01 : 0.05;
      const auto gap = [&](double s) {
        const Vector3 c = from + s * (to - from);
        return (tree.nearestPoint(c) - c).norm() - radius;
      };
      TriangleTree::Touch touch;
      const bool found = tree.firstTouch(from, to, radius, touch);
      for (double s = 0; s < touch.share; s += 1e-2) EXPECT_GT(gap(s), 0) << i;
      found ? ++touched : ++missed;
      if (!found) continue;
      EXPECT_NEAR(gap(touch.share), 0, 1e-14);
      const Vector3 c = from + touch.share * (to - from);
      EXPECT_LT((touch.normal - (c - tree.nearestPoint(c)).normalized()).norm(), 1e-10);
    }
  }
  EXPECT_GT(touched, 300);
  EXPECT_GT(missed, 100);
}

TEST(GodObject, APlanePushesBackByKTimesTheDepth) {
  for (const double radius : {0.0, 0.005}) {
    GodObject god = over(plate(), {kK, radius}, {0.01, 0.02, 0.05});
    EXPECT_EQ(god.tick({0.01, 0.02, radius + 1e-6}), Vector3::Zero());
    const Vector3 F = lead(god, {0.01, 0.02, 0.04}, {0.03, -0.02, radius - 0.007}, 50);
    EXPECT_LT((F - Vector3(0, 0, 7)).norm(), kK * kSkin);
    EXPECT_EQ(god.constraints(), 1);
    EXPECT_LT((god.forceOn(0) + F).norm(), kK * kSkin);
  }
}

/// Along a convex mesh the proxy is the point nearest to the hand of all that are a radius away.
TEST(GodObject, AConvexMeshPushesAlongTheShortestWayOut) {
  for (const TriangleMesh& mesh :
       {makeSphere(0.05, 3).triangles(), makeBox({0.06, 0.06, 0.06}).triangles()}) {
    const TriangleTree tree(mesh);
    const double radius = 0.01, outside = 0.006, dt = 1e-3;
    GodObject god = over(mesh, {kK, radius}, {0, 0, 0.1});
    double worst = 0, turn = 0;
    Vector3 before = Vector3::UnitZ();
    // Once around at 6 mm from the place of no force, over corners and edges, by a millimetre a tick.
    for (int i = 0; i < 6000; ++i) {
      const double a = 2 * M_PI * i * dt;
      const Vector3 out(std::sin(a), 0.3 * std::sin(3 * a), std::cos(a)), p = tree.nearestPoint(0.2 * out);
      const Vector3 h = p + outside * (0.2 * out - p).normalized();
      const Vector3 F = god.tick(h), away = (h - tree.nearestPoint(h)).normalized();
      worst = std::max(worst, (F - kK * (radius - outside) * away).norm()),
      turn = std::max(turn, (away - before).norm());
      before = away;
    }
    // It goes along one tangent plane a tick: where the normal turns by δ a tick about an edge, the proxy
    // turns by outside/radius of the rest, and stays behind by δ radius/outside.
    EXPECT_LT(worst, kK * (radius - outside) * turn * radius / outside);
    EXPECT_GT(worst, 0);
  }
}

/// Walls at right angles clamp the hand axis by axis; in a groove of two inclined walls the proxy is at its
/// bottom.
TEST(GodObject, TwoAndThreePlanesStopItWhereTheyMeet) {
  GodObject god({kK, 0.004}, {0.05, 0.06, 0.07});
  const TriangleMesh cube = makeBox({1, 1, 1}).triangles();
  for (int axis = 0; axis < 3; ++axis) god.addMesh(cube, Pose(Vector3(-0.5 * Vector3::Unit(axis))));
  const Vector3 two = lead(god, {0.05, 0.06, 0.07}, {-0.003, -0.002, 0.03}, 100);
  EXPECT_LT((two - kK * Vector3(0.007, 0.006, 0)).norm(), 2 * kK * kSkin);
  EXPECT_EQ(god.constraints(), 2);
  const Vector3 three = lead(god, {-0.003, -0.002, 0.03}, {-0.003, -0.002, -0.001}, 100);
  EXPECT_LT((three - kK * Vector3(0.007, 0.006, 0.005)).norm(), 3 * kK * kSkin);
  EXPECT_EQ(god.constraints(), 3);

  const double half =
      M_PI / 6;  // the walls stand 60 degrees apart; a ball rests at r / sin(half) over the bottom
  GodObject groove({kK, 0.004}, {0, 0, 0.1});
  for (const int side : {-1, 1}) {
    const Matrix3 R = rotationAbout(Vector3::UnitY(), side * half);
    groove.addMesh(cube, Pose(R, R * Vector3(side * 0.5, 0, 0)));
  }
  const Vector3 F = lead(groove, {0, 0, 0.1}, {0, 0.01, -0.002}, 100);
  EXPECT_LT((F - kK * Vector3(0, 0, 0.004 / std::sin(half) + 0.002)).norm(), 2 * kK * kSkin / std::sin(half));
}

/// In pits of three random walls it ends at the point nearest to the hand, which projections by turns
/// (Dykstra, 1983) find as well.
TEST(GodObject, ThreeInclinedPlanesLeaveTheNearestPoint) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const TriangleMesh cube = makeBox({1, 1, 1}).triangles();
  int corners = 0;
  for (int pit = 0; pit < 200; ++pit) {
    GodObject god({kK, 0}, {0, 0, 0.1});
    Vector3 n[3], h = 0.02 * Vector3(uniform(random), uniform(random), uniform(random) - 0.5);
    double independent = 1;
    for (int i = 0; i < 3; ++i) {
      n[i] = Vector3(uniform(random), uniform(random), 0.1 + 0.5 * std::abs(uniform(random))).normalized();
      for (int j = 0; j < i; ++j) independent = std::min(independent, n[i].cross(n[j]).norm());
      const Matrix3 R = shortestTurn(Vector3::UnitZ(), n[i]).toRotationMatrix();
      god.addMesh(cube, Pose(R, -0.5 * n[i]));
    }
    independent = std::min(independent, std::abs(n[0].dot(n[1].cross(n[2]))));
    if (independent < 0.2) continue;  // nearly parallel walls: the projections would take too many turns
    lead(god, {0, 0, 0.1}, h, 200);
    for (int i = 0; i < 50; ++i) god.tick(h);
    Vector3 x = h, correction[3] = {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
    for (int turn = 0; turn < 3000; ++turn) {
      const int i = turn % 3;
      const Vector3 y = x + correction[i];
      x = y - std::min(0.0, n[i].dot(y)) * n[i];
      correction[i] = y - x;
    }
    EXPECT_LT((god.proxy() - x).norm(), 3 * kSkin / independent) << pit;
    corners += god.constraints() == 3;
  }
  EXPECT_GT(corners, 10);
}

/// Pressed down on a slope it stays while the slope is less than μ0, and slides by the cone of μ beyond.
TEST(GodObject, FrictionHoldsOnASlopeAndSlidesByItsCone) {
  const double mu_static = 0.6, mu = 0.5, depth = 0.008;
  for (const double tangent : {0.55, 0.65, 0.9}) {
    const double angle = std::atan(tangent);
    const Pose slope(rotationAbout(Vector3::UnitY(), angle), Vector3::Zero());  // falls along +x
    GodObject god({kK, 0, mu_static, mu}, {0, 0, 0.01});
    god.addMesh(plate(), slope);
    const Vector3 F = lead(god, {0, 0, 0.01}, {0, 0, -depth}, 200), n = slope.R.col(2),
                  uphill = -slope.R.col(0);
    const double pressed = kK * depth * std::cos(angle),
                 along = tangent < mu_static ? kK * depth * std::sin(angle) : mu * pressed;
    // The tick that touches first goes on to the surface along the hand's way: of the 0.09 mm of a tick
    // nothing is lost.
    EXPECT_LT((F - pressed * n - along * uphill).norm(), 4 * kK * kSkin) << tangent;
    // Once it slides μ rules, though the hand holds still.
    EXPECT_LT((god.tick({0, 0, -depth}) - F).norm(), 4 * kK * kSkin) << tangent;
  }
}

TEST(GodObject, NoDepthAndNoSpeedLeadsThroughAThinPlate) {
  for (const double radius : {0.0, 0.005}) {
    for (const int ticks : {1, 1000}) {
      GodObject god = over(plate(1e-5), {kK, radius}, {0, 0, 0.5});
      const Vector3 F = lead(god, {0, 0, 0.5}, {0, 0, -0.5}, ticks);
      EXPECT_NEAR(F.z(), kK * (0.5 + radius), kK * kSkin);
    }
  }
}

/// A plate that sweeps over the hand at 5 m/s takes the proxy along on its front; one that turns under a
/// stuck proxy carries it.
TEST(GodObject, WhatMovesTakesItAlong) {
  GodObject god({kK, 0.001}, Vector3::Zero());
  const TriangleMesh thin = plate(1e-3);
  const Matrix3 R = rotationAbout(Vector3::UnitY(), M_PI / 2);  // its upper face looks along +x
  const int swept = god.addMesh(thin, Pose(R, Vector3(-0.1, 0, 0)));
  Vector3 F = Vector3::Zero();
  for (int i = 1; i <= 40; ++i) {
    god.moveMesh(swept, Pose(R, Vector3(-0.1 + 5e-3 * i, 0, 0)));
    F = god.tick(Vector3::Zero());
  }
  EXPECT_NEAR(F.x(), kK * 0.101, kK * kSkin);

  GodObject stuck({kK, 0, 0.9, 0.9}, {0.1, 0, 0.01});
  const int table = stuck.addMesh(plate(), Pose());
  lead(stuck, {0.1, 0, 0.01}, {0.1, 0, -0.02}, 100);
  for (int i = 1; i <= 100; ++i) {
    stuck.moveMesh(table, Pose(rotationAbout(Vector3::UnitZ(), 1e-3 * i), Vector3::Zero()));
    stuck.tick({0.1, 0, -0.02});
  }
  EXPECT_LT((stuck.proxy() - Vector3(0.1 * std::cos(0.1), 0.1 * std::sin(0.1), 0)).norm(), 100 * kSkin);
}

}  // namespace god_object_test
}  // namespace haptic
