#include "haptic_core/geometry/pairs/table.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "random_pairs.h"

namespace haptic {
namespace table_test {

using random_pairs::Contact;
using random_pairs::contactOf;
using random_pairs::randomDirection;
using random_pairs::randomTurn;
using Status = ContactVolume::Status;

/// One shape of each kind, and those that a kind treats apart.
struct TableOfPairs : testing::Test {
  std::vector<std::shared_ptr<const ConvexShape>> shapes{std::make_shared<HalfSpace>(),
                                                         std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.4, 0.3, 0.5))),
                                                         std::make_shared<ConvexPolyhedron>(random_pairs::stone(30, 0.3, 4)),
                                                         std::make_shared<Ball>(0.3),
                                                         std::make_shared<Rod>(0.2, 0.5, Rod::Ends::kFlat),
                                                         std::make_shared<Rod>(0.2, 0.5, Rod::Ends::kRound),
                                                         std::make_shared<Ellipsoid>(Vector3(0.3, 0.2, 0.25)),
                                                         std::make_shared<Cone>(0.3, 0.1, 0.4)};
  std::mt19937 random{8};

  /// B turned at random, with a point of its surface 0.1 m below one of A's.
  Pose meeting(const ConvexShape& A, const ConvexShape& B) {
    const Matrix3 R = randomTurn(random);
    const Vector3 way = A.bounded() ? randomDirection(random) : Vector3(Vector3::UnitZ());
    const Vector3 a = A.core(way) + A.rounding() * way, b = R * B.core(R.transpose() * -way) - B.rounding() * way;
    return {R, a - b - 0.1 * way};
  }
  template <class Visit>
  void eachPair(Visit visit) {
    for (const auto& A : shapes)
      for (const auto& B : shapes)
        for (int i = 0; i < 5 && (A->bounded() || B->bounded()); ++i) {
          SCOPED_TRACE(A->name() + " and " + B->name());
          visit(*A, *B, A->bounded() && !B->bounded() ? meeting(*B, *A).inverse() : meeting(*A, *B));
        }
  }
};

TEST_F(TableOfPairs, HasEveryPairOnce) {
  for (int i = 0; i < kShapeKinds; ++i)
    for (int j = 0; j < kShapeKinds; ++j) {
      const PairEntry& entry = pairEntry(static_cast<ShapeKind>(i), static_cast<ShapeKind>(j));
      EXPECT_EQ(entry.contact != nullptr, i <= j);
      EXPECT_EQ(entry.distance != nullptr, i <= j);
      EXPECT_EQ(entry.room != nullptr, i <= j);
    }
}

/// Whichever of the two comes first, V is the same and S has the opposite sign: 1e-11 from sums in other orders over 1e-1 m.
TEST_F(TableOfPairs, TurnsPairs) {
  eachPair([](const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
    const Contact one = contactOf(A, B, X_AB), other = contactOf(B, A, X_AB.inverse());
    ASSERT_EQ(one.volume.status, Status::kOverlap);
    ASSERT_EQ(other.volume.status, Status::kOverlap);
    const double V = one.volume.volume, S = one.volume.area_vector_A.norm();
    // Of two alike the one that comes second is tessellated.
    const double off = &A == &B ? A.tessellationError() : 0;
    EXPECT_NEAR(other.volume.volume, V, 1e-9 * V + 2 * off * S);
    EXPECT_NEAR((X_AB.R * other.volume.area_vector_A + one.volume.area_vector_A).norm(), 0, 1e-8 * S + 2 * off / one.volume.depth * S);
    EXPECT_NEAR((X_AB * other.volume.X_AP.p - one.volume.X_AP.p).norm(), 0, 1e-9 + 2 * off);
    ClosestPoints near, back;
    closestPoints(A, B, Pose(X_AB.R, X_AB.p + 2 * one.volume.normal()), Vector3::UnitZ(), near);
    closestPoints(B, A, Pose(X_AB.R, X_AB.p + 2 * one.volume.normal()).inverse(), Vector3::UnitZ(), back);
    ASSERT_TRUE(near.separated && back.separated);
    EXPECT_NEAR(near.distance, back.distance, 1e-9);
    EXPECT_NEAR((X_AB.R * back.direction + near.direction).norm(), 0, 1e-6);
  });
}

/// A normal that the caller prescribes is the contact's, whatever the cache remembers; V is what it is.
TEST_F(TableOfPairs, TakesAPrescribedNormal) {
  eachPair([this](const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
    if (!A.bounded() || !B.bounded()) return;  // that plane's normal is prescribed already
    Contact c = contactOf(A, B, X_AB);
    const double V = c.volume.volume;
    ContactRequest request;
    request.normal = (c.volume.normal() + 0.3 * randomDirection(random)).normalized();
    PairCache cache;
    cache.normal = randomDirection(random);
    contactVolume(A, B, X_AB, cache, c.workspace, c.volume, request);
    ASSERT_EQ(c.volume.status, Status::kOverlap);
    EXPECT_EQ((c.volume.normal() - request.normal).norm(), 0);
    EXPECT_NEAR(c.volume.volume, V, 1e-12 * V);
    EXPECT_EQ(c.volume.flags & ContactVolume::kNormalFromHistory, 0u);
  });
}

/// Room that was made for a list of shapes at once is enough for each pair in it.
TEST_F(TableOfPairs, MakesRoomForAll) {
  std::vector<const ConvexShape*> all;
  for (const auto& shape : shapes) all.push_back(shape.get());
  ContactWorkspace workspace;
  workspace.reserve(all);
  eachPair([&](const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
    PairCache cache;
    ContactVolume v;
    contactVolume(A, B, X_AB, cache, workspace, v);
    ASSERT_EQ(v.status, Status::kOverlap);
    EXPECT_EQ(v.flags & ContactVolume::kCapacityExceeded, 0u);
  });
}

}  // namespace table_test
}  // namespace haptic
