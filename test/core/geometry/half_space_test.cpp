#include "haptic_core/geometry/shapes/half_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "random_pairs.h"

namespace haptic {
namespace half_space_test {

using random_pairs::randomTurn;
using random_pairs::stone;

using Status = ContactVolume::Status;
constexpr double kEps = std::numeric_limits<double>::epsilon();

ContactVolume contactOf(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, ContactWorkspace& workspace) {
  workspace.reserve(A, B);
  PairCache cache;
  ContactVolume volume;
  contactVolume(A, B, X_AB, cache, workspace, volume);
  return volume;
}

ContactVolume contactOf(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
  ContactWorkspace workspace;
  return contactOf(A, B, X_AB, workspace);
}

std::vector<std::shared_ptr<const ConvexShape>> shapes() {
  return {std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.4, 0.3, 0.5))),
          std::make_shared<ConvexPolyhedron>(stone(40, 0.3, 3)), std::make_shared<Ball>(0.3),
          std::make_shared<Rod>(0.2, 0.5, Rod::Ends::kFlat), std::make_shared<Rod>(0.2, 0.5, Rod::Ends::kRound),
          std::make_shared<Ellipsoid>(Vector3(0.3, 0.2, 0.1))};
}

/// Lowest point at a depth, over (0.1, -0.2).
Pose sunk(const ConvexShape& shape, const Matrix3& R, double depth) {
  return {R, Vector3(0.1, -0.2, supportHeight(shape, Pose(R, Vector3::Zero()), -Vector3::UnitZ()) - depth)};
}

/// The top of a box that is wide and deep enough is the same surface.
TEST(HalfSpace, MeetsEveryShapeAsAWideBoxDoes) {
  const HalfSpace ground;
  const double size = 8;
  const ConvexPolyhedron box = makeBox(Vector3::Constant(size));
  const Pose X_box(Vector3(0, 0, -size / 2));  // of the box in the half-space's frame
  std::mt19937 random(7);
  for (const auto& shape : shapes()) {
    for (int i = 0; i < 60; ++i) {
      const double depth = shape->boundingRadius() * std::pow(10, -(i % 6));
      const Pose X = sunk(*shape, randomTurn(random), depth);
      const ContactVolume ours = contactOf(ground, *shape, X), theirs = contactOf(box, *shape, X_box.inverse() * X);
      ASSERT_EQ(ours.status, Status::kOverlap) << i;
      ASSERT_EQ(theirs.status, Status::kOverlap) << i;
      EXPECT_NEAR((ours.normal() - Vector3::UnitZ()).norm(), 0, 10 * kEps);
      // Roundings of the box's corners times the area, and of the moments themselves.
      const double rounding = 20 * kEps * size / depth + 1e-12;
      EXPECT_NEAR(ours.volume, theirs.volume, rounding * theirs.volume) << i;
      EXPECT_NEAR(ours.A0, theirs.A0, rounding * theirs.A0);
      EXPECT_NEAR((ours.area_vector_A - theirs.area_vector_A).norm(), 0, rounding * theirs.A0);
      EXPECT_NEAR((ours.X_AP.p - X_box * theirs.X_AP.p).norm(), 0, rounding * shape->boundingRadius());
      EXPECT_NEAR(ours.V2.trace(), theirs.V2.trace(), 3 * rounding * theirs.V2.trace());
      EXPECT_NEAR(ours.A2.trace(), theirs.A2.trace(), 3 * rounding * theirs.A2.trace());
      const double height = supportHeight(*shape, X, Vector3::UnitZ()) + depth;
      EXPECT_NEAR(ours.depth, std::min(depth, height), 0.02 * depth + 20 * kEps);
      // The other way round the normal is the opposite.
      const ContactVolume turned = contactOf(*shape, ground, X.inverse());
      ASSERT_EQ(turned.status, Status::kOverlap);
      EXPECT_NEAR((X.R * turned.normal() + Vector3::UnitZ()).norm(), 0, 10 * kEps);
      EXPECT_NEAR(turned.volume, ours.volume, rounding * ours.volume);
      EXPECT_NEAR((X * turned.X_AP.p - ours.X_AP.p).norm(), 0, rounding * shape->boundingRadius());
    }
  }
}

/// Two boxes side by side, whose common wall cuts the rod, share what the half-space has: two planes cut there, where one does here.
TEST(HalfSpace, HasOfARodWhatTwoBoxesHaveTogether) {
  const HalfSpace ground;
  const double size = 4;
  const ConvexPolyhedron box = makeBox(Vector3::Constant(size));
  const Pose boxes[] = {Pose(Vector3(-size / 2, 0, -size / 2)), Pose(Vector3(size / 2, 0, -size / 2))};
  std::mt19937 random(17);
  int cut = 0;
  for (const auto ends : {Rod::Ends::kFlat, Rod::Ends::kRound}) {
    const Rod rod(0.2, 0.5, ends);
    for (int i = 0; i < 400; ++i) {
      const Vector3 tilts[] = {{M_PI / 2, 0, 0}, {0, 0, 0}, {M_PI, 0, 0}, {M_PI / 2 + 1e-9, 0, 0}, {1e-7, 0, 0}};
      const Matrix3 tilt = Eigen::AngleAxisd(tilts[i % 5].x(), Vector3(1, i % 3, 0).normalized()).toRotationMatrix();
      Pose X = sunk(rod, i % 2 ? tilt : randomTurn(random), 0.3 * std::pow(10, -(i % 5)));
      X.p.x() = 1e-3 * (i % 7);
      const ContactVolume whole = contactOf(ground, rod, X);
      ASSERT_EQ(whole.status, Status::kOverlap);
      double volume = 0;
      Vector3 first = Vector3::Zero();  // about the whole's centroid
      for (const Pose& X_box : boxes) {
        const ContactVolume part = contactOf(box, rod, X_box.inverse() * X);
        if (part.status != Status::kOverlap) continue;
        ++cut;
        const Vector3 from = X_box * part.X_AP.p - whole.X_AP.p;
        volume += part.volume;
        first += part.volume * from;
      }
      const double rounding = 1e-12 + 40 * kEps * size / whole.depth, reach = 0.5;
      EXPECT_NEAR(whole.volume, volume, rounding * volume) << i;
      EXPECT_NEAR(first.norm(), 0, rounding * volume * reach) << i;
    }
  }
  EXPECT_GT(cut, 1000);
}

TEST(HalfSpace, PushesUpHoweverDeepAShapeLies) {
  const HalfSpace ground;
  std::mt19937 random(5);
  for (const auto& shape : shapes()) {
    for (const double below : {0.01, 1.0, 1e3}) {
      const Pose X = sunk(*shape, randomTurn(random), 2 * shape->boundingRadius() + below);
      for (const bool first : {true, false}) {
        PairCache cache;
        cache.normal = Vector3::UnitX();  // of before the body turned
        ContactWorkspace workspace;
        workspace.reserve(ground, *shape);
        ContactVolume c;
        first ? contactVolume(ground, *shape, X, cache, workspace, c) : contactVolume(*shape, ground, X.inverse(), cache, workspace, c);
        ASSERT_EQ(c.status, Status::kOverlap) << below;
        EXPECT_NEAR(((first ? Vector3(c.normal()) : Vector3(-(X.R * c.normal()))) - Vector3::UnitZ()).norm(), 0, 10 * kEps);
        EXPECT_NEAR(c.volume, shape->volume(), 1e-12 * c.volume);
        EXPECT_NEAR((X.inverse() * (first ? c.X_AP.p : Vector3(X * c.X_AP.p)) - shape->centre()).norm(), 0, 20 * kEps * (1 + below));
      }
    }
  }
}

TEST(HalfSpace, IsFarFromWhatIsAboveIt) {
  const HalfSpace ground;
  std::mt19937 random(9);
  for (const auto& shape : shapes()) {
    for (const double gap : {1e-9, 0.1, 1e6}) {
      const Pose X = sunk(*shape, randomTurn(random), -gap);
      const ContactVolume c = contactOf(ground, *shape, X);
      EXPECT_EQ(c.status, Status::kSeparated);
      EXPECT_NEAR(-c.depth, gap, 10 * kEps * (1 + gap));
      for (const bool first : {true, false}) {
        ClosestPoints near;
        first ? closestPoints(ground, *shape, X, Vector3::UnitX(), near)
              : closestPoints(*shape, ground, X.inverse(), Vector3::UnitX(), near);
        EXPECT_TRUE(near.separated);
        EXPECT_NEAR(near.distance, gap, 10 * kEps * (1 + gap));
        EXPECT_NEAR((near.p_B - near.p_A - near.distance * near.direction).norm(), 0, 20 * kEps * (1 + gap));
      }
    }
  }
  EXPECT_EQ(contactOf(ground, ground, Pose(Vector3(0, 0, 1))).status, Status::kSeparated);
}

TEST(HalfSpace, HasABoxThatEndsWhereItIsLevel) {
  const HalfSpace ground;
  const ConvexShape::Box level = ground.aabb(Pose(Vector3(1, 2, 3)));
  EXPECT_EQ(level.upper.z(), 3);
  EXPECT_EQ(level.lower.z(), -INFINITY);
  EXPECT_EQ(level.upper.x(), INFINITY);
  const ConvexShape::Box tilted = ground.aabb(Pose(Eigen::AngleAxisd(1e-3, Vector3::UnitX()).toRotationMatrix(), Vector3::Zero()));
  EXPECT_EQ(tilted.upper.z(), INFINITY);
  EXPECT_EQ(supportHeight(ground, Pose(Vector3(1, 2, 3)), Vector3::UnitZ()), 3);
  EXPECT_EQ(supportHeight(ground, Pose(Vector3(1, 2, 3)), Vector3::UnitX()), INFINITY);
}

}  // namespace half_space_test
}  // namespace haptic
