#include "haptic_core/geometry/shapes/support_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "ccd_oracle.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/pairs/time_of_impact.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "random_pairs.h"

namespace haptic {
namespace support_shape_test {

using random_pairs::Contact;
using random_pairs::contactOf;
using random_pairs::gradientError;
using random_pairs::randomDirection;
using random_pairs::randomTurn;
using Status = ContactVolume::Status;

/// A kind that says its support function and nothing else: all within `round` of a box.
class RoundedBox : public SupportShape {
 public:
  RoundedBox(const Vector3& half, double round) : SupportShape("rounded box"), half_(half), round_(round) { tessellate(); }
  void eachNumber(NumberVisitor& visitor) const override { visitor.visit(half_.x()), visitor.visit(round_); }
  Vector3 core(const Vector3& d) const override {
    return {d.x() < 0 ? -half_.x() : half_.x(), d.y() < 0 ? -half_.y() : half_.y(), d.z() < 0 ? -half_.z() : half_.z()};
  }
  double rounding() const override { return round_; }
  /// Steiner's formula.
  double exactVolume() const {
    const Vector3 s = 2 * half_;
    const double r = round_;
    return s.prod() + 2 * r * (s.x() * s.y() + s.y() * s.z() + s.z() * s.x()) + M_PI * r * r * s.sum() + 4 * M_PI / 3 * r * r * r;
  }

 private:
  Vector3 half_;
  double round_;
};

struct AnySupport : testing::Test {
  std::vector<std::shared_ptr<const SupportShape>> kinds{std::make_shared<RoundedBox>(Vector3(0.2, 0.15, 0.1), 0.08),
                                                         std::make_shared<Cone>(0.3, 0.12, 0.4), std::make_shared<Cone>(0.3, 0, 0.4)};
  std::vector<std::shared_ptr<const ConvexShape>> others{std::make_shared<HalfSpace>(),
                                                         std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.4, 0.3, 0.5))),
                                                         std::make_shared<Ball>(0.3),
                                                         std::make_shared<Rod>(0.2, 0.5, Rod::Ends::kFlat),
                                                         std::make_shared<Rod>(0.2, 0.5, Rod::Ends::kRound),
                                                         std::make_shared<Ellipsoid>(Vector3(0.3, 0.2, 0.25))};
  std::mt19937 random{9};

  AnySupport() { others.insert(others.end(), kinds.begin(), kinds.end()); }

  /// B's lowest point along a random way, `depth` below A's highest; that way in A.
  Pose place(const ConvexShape& A, const ConvexShape& B, double depth, Vector3& way) {
    const Matrix3 R = randomTurn(random);
    way = A.bounded() ? randomDirection(random) : Vector3(Vector3::UnitZ());
    const Vector3 a = A.core(way) + A.rounding() * way, b = R * B.core(R.transpose() * -way) - B.rounding() * way;
    return {R, a - b - depth * way};
  }
  template <class Visit>
  void eachPair(Visit visit) {
    for (const auto& A : others)
      for (const auto& B : kinds) {
        SCOPED_TRACE(A->name() + " and " + B->name());
        visit(*A, *B);
      }
  }
};

TEST_F(AnySupport, HasMassAndBoundsWithinTheStatedError) {
  const RoundedBox box(Vector3(0.2, 0.15, 0.1), 0.08);
  EXPECT_GT(box.tessellationError(), 0);
  EXPECT_LT(box.tessellationError(), 0.02 * 0.08);
  EXPECT_LT(box.volume(), box.exactVolume());  // inscribed
  EXPECT_NEAR(box.volume(), box.exactVolume(), box.tessellationError() * box.surface());
  for (const auto& shape : kinds) {
    // What no sample of the true surface leaves: the stated distance is one.
    for (int i = 0; i < 2000; ++i) {
      const Vector3 n = randomDirection(random);
      const double truly = n.dot(shape->core(n)) + shape->rounding();
      const double made = n.dot(shape->tessellation()->core(n));
      EXPECT_LE(std::abs(truly - made), 1.05 * shape->tessellationError()) << shape->name();
      EXPECT_LE((shape->core(n) + shape->rounding() * n - shape->centre()).norm(), shape->boundingRadius());
    }
    const Pose X(randomTurn(random), Vector3(0.1, 2, 3));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(shape->aabb(X).upper[axis], supportHeight(*shape, X, Vector3::Unit(axis)), 1e-15);
      EXPECT_NEAR(-shape->aabb(X).lower[axis], supportHeight(*shape, X, -Vector3::Unit(axis)), 1e-15);
    }
  }
}

/// Closed forms: its own stand-in has the volume and the centre to rounding and the inertia to that of 64 sides, 4e-4.
TEST(Cone, HasTheMassPropertiesOfACone) {
  for (const double top : {0.0, 0.1, 0.3, 0.5}) {
    const Cone cone(0.3, top, 0.4);
    const MassProperties exact = cone.massProperties(1000), made = cone.tessellation()->massProperties(1000);
    EXPECT_NEAR(made.mass, exact.mass, 1e-12 * exact.mass);
    EXPECT_NEAR((made.com - exact.com).norm(), 0, 1e-14);
    EXPECT_NEAR((made.I_com - exact.I_com).norm(), 0, 2e-3 * exact.I_com.norm());
    EXPECT_NEAR(exact.mass, 1000 * M_PI * 0.4 / 3 * (0.09 + 0.3 * top + top * top), 1e-12 * exact.mass);
    EXPECT_LT(cone.tessellationError(), 9e-4 * std::max(0.3, top));
  }
  // As long and thick all over it is a cylinder.
  const MassProperties cylinder = Rod(0.3, 0.4, Rod::Ends::kFlat).massProperties(1000), cone = Cone(0.3, 0.3, 0.4).massProperties(1000);
  EXPECT_NEAR((cone.I_com - cylinder.I_com).norm(), 0, 1e-12 * cylinder.I_com.norm());
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(Cone(bad, 0.1, 1), SetupError);
    EXPECT_THROW(Cone(1, 0.1, bad), SetupError);
  }
  EXPECT_THROW(Cone(1, -0.1, 1), SetupError);
}

/// On its bottom or its top: discs of the true area.
TEST(Cone, StandsOnTheTrueArea) {
  const Cone cone(0.3, 0.12, 0.4);
  const HalfSpace ground;
  for (const bool upright : {true, false}) {
    const Matrix3 R = upright ? Matrix3(Matrix3::Identity()) : Matrix3(Eigen::AngleAxisd(M_PI, Vector3::UnitX()));
    const double depth = 1e-6, r = upright ? 0.3 : 0.12, widens = upright ? -0.45 : 0.45;
    const Contact c = contactOf(ground, cone, Pose(R, Vector3(0, 0, 0.2 - depth)));
    ASSERT_EQ(c.volume.status, Status::kOverlap);
    const double area = M_PI * (r + widens * depth) * (r + widens * depth);
    EXPECT_NEAR(c.volume.A0, area, 1e-12 * area);
    EXPECT_NEAR(c.volume.volume, M_PI * depth * r * (r + widens * depth), 1e-9 * c.volume.volume);
    EXPECT_NEAR(c.volume.depth, depth, 1e-15);
  }
}

/// libccd's MPR on the true shapes and the table agree on what touches, wherever that is clearer than the tessellations' error, and on
/// which way is out.
TEST_F(AnySupport, MeetsEveryKindAsLibccdSays) {
  int overlaps = 0;
  eachPair([&](const ConvexShape& A, const ConvexShape& B) {
    const double off = A.tessellationError() + B.tessellationError() + 1e-6;
    for (int i = 0; i < 40; ++i) {
      Vector3 way;
      const double depth = (i % 2 ? 1 : -1) * (2 * off + 0.05 * (i / 40.0));
      const Pose X = place(A, B, depth, way);
      const Contact c = contactOf(A, B, X);
      if (depth < 0) EXPECT_EQ(c.volume.status, Status::kSeparated) << i;
      Vector3 direction;
      double found = depth;  // on a half-space: each point of it below the plane
      const bool meets = A.bounded() ? oracle::ccdPenetration(A, B, X, direction, found) : depth > 0;
      EXPECT_TRUE(depth > 0 || !meets) << i;
      if (meets && found < 2 * off) continue;
      EXPECT_EQ(c.volume.status == Status::kOverlap, meets) << i;
      overlaps += meets;
      if (!meets || !A.bounded() || found < 0.02) continue;
      // Neither way is the shortest: MPR's is the one along which it looked.
      EXPECT_GT(direction.dot(c.volume.normal()), 0.3) << i;
    }
  });
  EXPECT_GT(overlaps, 300);
}

/// V grows with the depth as S says, but for what the tessellations are off.
TEST_F(AnySupport, HasTheAreaVectorAsGradient) {
  eachPair([this](const ConvexShape& A, const ConvexShape& B) {
    for (int i = 0; i < 5; ++i) {
      Vector3 way;
      const Pose X = place(A, B, 0.05, way);
      ASSERT_EQ(contactOf(A, B, X).volume.status, Status::kOverlap);
      EXPECT_LT(gradientError(A, B, X), 1e-4) << i;
    }
  });
}

/// Distance and time of impact are the true shapes': no tessellation's error is in them.
TEST_F(AnySupport, IsAsFarAndArrivesWhenTheTrueShapeDoes) {
  eachPair([this](const ConvexShape& A, const ConvexShape& B) {
    for (int i = 0; i < 10; ++i) {
      Vector3 way;
      const Pose X = place(A, B, -0.1, way);
      ClosestPoints closest;
      closestPoints(A, B, X, way, closest);
      ASSERT_TRUE(closest.separated);
      EXPECT_NEAR(closest.distance, 0.1, 1e-7);
      EXPECT_NEAR(closest.direction.dot(way), 1, 1e-5);
      const double clearance = 1e-5, speed = 2;
      Vector3 direction = way;
      const ShapeMotion still{Pose(), Vector3::Zero(), Twist(), 0};
      ShapeMotion moving{X, X.p, Twist(), 0};
      moving.V_W.linear = -speed * way;
      const double t = timeOfImpact(A, still, B, moving, 1, clearance, direction);
      EXPECT_LE(t, (0.1 - 0.4 * clearance) / speed);
      EXPECT_GE(t, (0.1 - 1.1 * clearance) / speed);
    }
  });
}

}  // namespace support_shape_test
}  // namespace haptic
