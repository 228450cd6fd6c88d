#include "haptic_core/geometry/pairs/ellipsoid_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/pairs/internal_faces.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_integrals.h"
#include "haptic_core/geometry/volume/round_patch.h"
#include "random_pairs.h"

namespace haptic {
namespace ellipsoid_contact_test {

using random_pairs::Contact;
using random_pairs::contactOf;
using random_pairs::gradientError;
using random_pairs::randomDirection;
using random_pairs::randomTurn;
using random_pairs::stone;
using Status = ContactVolume::Status;

const Vector3 kRadii(0.3, 0.2, 0.12);

/// A sphere's tessellation of the same volume, stretched: off by some 4^-subdivision.
ConvexPolyhedron faceted(const Vector3& radii, int subdivision) {
  const ConvexPolyhedron ball = makeSphere(1, subdivision, RoundFit::kEqualVolume);
  std::vector<Vector3> corners = ball.vertices();
  for (Vector3& v : corners) v = v.cwiseProduct(radii);
  std::vector<std::vector<int>> loops(ball.faceCount());
  for (int f = 0; f < ball.faceCount(); ++f)
    for (int i = 0; i < ball.cornerCount(f); ++i) loops[f].push_back(ball.key(f, i));
  return ConvexPolyhedron(std::move(corners), loops);
}

/// A place of `shape` in `other`'s frame: by `depth` over a point of it that looks to a random side.
Pose over(const ConvexShape& other, const ConvexShape& shape, double depth, std::mt19937& random) {
  const Matrix3 R = randomTurn(random);
  const Vector3 way = other.bounded() ? randomDirection(random) : Vector3(Vector3::UnitZ());
  const Vector3 lowest = R * shape.core(R.transpose() * -way) - shape.rounding() * way;
  return {R, other.core(way) + other.rounding() * way - lowest - depth * way};
}

TEST(Ellipsoid, HasMassAndBoundsOfAnEllipsoid) {
  const Ellipsoid shape(kRadii);
  const MassProperties m = shape.massProperties(1000);
  const double V = 4 * M_PI / 3 * kRadii.prod();
  EXPECT_NEAR(m.mass, 1000 * V, 1e-12 * m.mass);
  // Of equal volume, which takes the error of second order: the error of the tessellation's inertia falls by sixteen each time.
  double before = 0;
  for (const int subdivision : {2, 3, 4}) {
    const double off = (faceted(kRadii, subdivision).massProperties(1000).I_com - m.I_com).norm() / m.I_com.norm();
    EXPECT_LT(off, 0.02);
    if (before > 0) EXPECT_NEAR(before / off, 16, 1);
    before = off;
  }
  EXPECT_NEAR(shape.tessellation()->volume(), V, 1e-12 * V);
  EXPECT_GT(shape.tessellationError(), 0);
  EXPECT_LT(shape.tessellationError(), 0.004 * kRadii.maxCoeff());
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    const Pose X(randomTurn(random), randomDirection(random));
    const ConvexShape::Box box = shape.aabb(X);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(box.upper[axis], supportHeight(shape, X, Vector3::Unit(axis)), 1e-15);
      EXPECT_NEAR(-box.lower[axis], supportHeight(shape, X, -Vector3::Unit(axis)), 1e-15);
    }
    const Vector3 n = randomDirection(random), x = shape.core(n);
    EXPECT_NEAR(x.cwiseQuotient(kRadii).norm(), 1, 1e-14);              // on the surface,
    EXPECT_NEAR(x.cwiseQuotient(kRadii).cwiseQuotient(kRadii).cross(n).norm(), 0, 1e-12);  // where n is its normal
  }
}

TEST(Ellipsoid, RefusesRadiiThatAreNone) {
  for (const double bad : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)}) {
    try {
      Ellipsoid(Vector3(1, bad, 1));
      ADD_FAILURE() << bad;
    } catch (const SetupError& refused) {
      EXPECT_NE(std::string(refused.what()).find("radius along y"), std::string::npos) << refused.what();
    }
  }
  EXPECT_THROW(Ellipsoid(Vector3::Constant(1e-150)), SetupError);
}

/// Recordings tell it from a capsule that has the same three lengths.
TEST(Ellipsoid, HasNumbersOfItsOwn) {
  struct Numbers : NumberVisitor {
    void visit(double x) override { all.push_back(x); }
    void visit(int n) override { all.push_back(n); }
    std::vector<double> all;
  } ellipsoid, capsule;
  Ellipsoid(Vector3(0.1, 0.2, 0.1)).eachNumber(ellipsoid);
  Rod(0.1, 0.4, Rod::Ends::kRound).eachNumber(capsule);
  EXPECT_NE(ellipsoid.all, capsule.all);
}

/// V = π abc t² (1 - t/3), t = depth over the reach: a unit ball's cap. The cut is an ellipse of area π abc t (2 - t)/reach, and the
/// centroid lies on the line through the centres of all such cuts.
TEST(EllipsoidContact, OnAPlaneIsACap) {
  const Ellipsoid shape(kRadii);
  const HalfSpace ground;
  const ConvexPolyhedron box = makeBox(Vector3::Constant(4));
  std::mt19937 random(3);
  for (const double share : {1e-8, 1e-5, 1e-2, 0.3, 0.9, 1.7}) {
    for (int i = 0; i < 20; ++i) {
      const Matrix3 R = randomTurn(random);
      const Vector3 n_S = R.transpose() * Vector3::UnitZ(), Dn = kRadii.cwiseProduct(n_S);
      const double reach = Dn.norm(), depth = share * reach, abc = kRadii.prod();
      const double V = M_PI * abc * share * share * (1 - share / 3), A = M_PI * abc * share * (2 - share) / reach;
      const Pose X(R, Vector3(0.05, -0.02, reach - depth));
      // Half a unit cap's centroid is 3 (2 - t)²/(4 (3 - t)) from its centre.
      const Vector3 centroid = X * (kRadii.cwiseProduct(-Dn / reach) * (0.75 * (2 - share) * (2 - share) / (3 - share)));
      const double rounding = 2e-15 / depth + 1e-13;  // places within 2 m
      for (const bool plane : {true, false}) {
        const Pose X_other = plane ? Pose() : Pose(Vector3(0, 0, -2));
        const ConvexShape& other = plane ? static_cast<const ConvexShape&>(ground) : box;
        for (const bool turned : {false, true}) {
          const Pose X_AB = X_other.inverse() * X;
          Contact c = turned ? contactOf(shape, other, X_AB.inverse()) : contactOf(other, shape, X_AB);
          const Pose X_WA = turned ? X : X_other;
          ASSERT_EQ(c.volume.status, Status::kOverlap);
          EXPECT_NEAR(c.volume.volume, V, 4 * rounding * V) << share << " " << plane;
          EXPECT_NEAR(c.volume.A0, A, 4 * rounding * A);
          EXPECT_NEAR((X_WA.R * c.volume.normal() - (turned ? -1 : 1) * Vector3::UnitZ()).norm(), 0, 4e-15);  // as orthogonal as R is
          EXPECT_NEAR((X_WA * c.volume.X_AP.p - centroid).norm(), 0, 1e-14);
          EXPECT_NEAR(c.volume.depth, depth, 1e-14);
          // ∫ d² dA is twice V's moment about the plane.
          const double square = thicknessSquared(c.workspace, c.volume);
          EXPECT_NEAR(square, 2 * V * std::abs(centroid.z()), 1e-6 * square + 8 * rounding * square);
        }
      }
    }
  }
}

/// With equal radii everything is a ball's, on faces, edges and corners: what V is, and what patches take from it.
TEST(EllipsoidContact, WithEqualRadiiIsABalls) {
  const double r = 0.2;
  const Ellipsoid round(Vector3::Constant(r));
  const Ball ball(r);
  std::mt19937 random(4);
  for (const ConvexPolyhedron& other : {makeBox(Vector3(0.5, 0.4, 0.3)), stone(30, 0.4, 5), stone(4, 0.3, 6)}) {
    for (int i = 0; i < 200; ++i) {
      const double depth = 0.9 * r * std::pow(10, -(i % 5));
      const Pose X = over(other, ball, depth, random);
      Contact ours = contactOf(other, round, X), theirs = contactOf(other, ball, X);
      ASSERT_EQ(ours.volume.status, theirs.volume.status);
      if (ours.volume.status != Status::kOverlap) continue;
      const ContactVolume &a = ours.volume, &b = theirs.volume;
      const double rounding = 1e-14 / depth + 1e-11, S = b.area_vector_A.norm();
      EXPECT_NEAR(a.volume, b.volume, rounding * b.volume) << i;
      EXPECT_NEAR((a.area_vector_A - b.area_vector_A).norm(), 0, rounding * S);
      EXPECT_NEAR((a.X_AP.p - b.X_AP.p).norm(), 0, 1e-12);
      EXPECT_NEAR((a.X_AP.R - b.X_AP.R).norm(), 0, 1e-8);
      EXPECT_NEAR((a.V2 - b.V2).norm(), 0, 1e-8 * b.V2.norm());
      EXPECT_NEAR((a.A2 - b.A2).norm(), 0, 1e-7 * b.A2.norm());
      EXPECT_NEAR(a.depth, b.depth, 1e-8 * b.depth);
      EXPECT_EQ(a.flags, b.flags);
      const double square = thicknessSquared(theirs.workspace, b);
      EXPECT_NEAR(thicknessSquared(ours.workspace, a), square, 1e-5 * square) << i;
      const PartMoments half = momentsWhere(theirs.workspace, b, Vector2(1, 0.3), 0);
      const PartMoments mine = momentsWhere(ours.workspace, a, Vector2(1, 0.3), 0);
      EXPECT_NEAR(mine.volume, half.volume, 1e-3 * b.volume) << i;
    }
  }
}

/// Against tessellations of itself: what they are off falls by four each time, which no error of ours would.
TEST(EllipsoidContact, IsTheLimitOfItsTessellations) {
  const Ellipsoid shape(kRadii);
  std::mt19937 random(5);
  const HalfSpace ground;
  const ConvexPolyhedron box = makeBox(Vector3(0.5, 0.4, 0.3)), rock = stone(20, 0.4, 7);
  for (const ConvexShape* shapes : {static_cast<const ConvexShape*>(&ground), static_cast<const ConvexShape*>(&box),
                                    static_cast<const ConvexShape*>(&rock)}) {
    const ConvexShape& other = *shapes;
    SCOPED_TRACE(other.name());
    double off[3] = {}, off_area[3] = {}, off_square[3] = {}, off_V2[3] = {}, off_A2[3] = {};
    for (int i = 0; i < 12; ++i) {
      const Pose X = over(other, shape, 0.08, random);
      Contact exact = contactOf(other, shape, X);
      ASSERT_EQ(exact.volume.status, Status::kOverlap);
      const double square = thicknessSquared(exact.workspace, exact.volume);
      for (int s = 0; s < 3; ++s) {
        Contact c = contactOf(other, faceted(kRadii, 1 + s), X);
        ASSERT_EQ(c.volume.status, Status::kOverlap);
        off[s] += std::abs(c.volume.volume / exact.volume.volume - 1) / 12;
        off_area[s] += (c.volume.area_vector_A - exact.volume.area_vector_A).norm() / exact.volume.area_vector_A.norm() / 12;
        off_V2[s] += (c.volume.V2 - exact.volume.V2).norm() / exact.volume.V2.norm() / 12;
        off_A2[s] += (c.volume.A2 - exact.volume.A2).norm() / exact.volume.A2.norm() / 12;
        off_square[s] += std::abs(thicknessSquared(c.workspace, c.volume) / square - 1) / 12;
        EXPECT_LT((c.volume.X_AP.p - exact.volume.X_AP.p).norm(), 0.04 * std::pow(4, -s));
      }
    }
    for (const double* e : {off, off_area, off_V2, off_A2}) EXPECT_GT(e[0] / e[2], 8) << e[0] << " " << e[1] << " " << e[2];
    EXPECT_GT(off_square[0] / off_square[2], 6) << off_square[0] << " " << off_square[2];
    EXPECT_LT(off[2], 0.03);
  }
}

/// Moving B by δ along any way changes V by -S δ, also over edges and with the ellipsoid as A.
TEST(EllipsoidContact, HasTheAreaVectorAsGradient) {
  const Ellipsoid shape(kRadii);
  const ConvexPolyhedron box = makeBox(Vector3(0.5, 0.4, 0.3));
  std::mt19937 random(6);
  for (int i = 0; i < 60; ++i) {
    EXPECT_LT(gradientError(box, shape, over(box, shape, 0.1, random)), 1e-7) << i;
  }
}

/// Two boxes side by side press as one does: their inner faces are covered.
TEST(EllipsoidContact, FeelsNoSeam) {
  const auto half = std::make_shared<ConvexPolyhedron>(makeBox(Vector3(1, 2, 1)));
  const ConvexPolyhedron whole = makeBox(Vector3(2, 2, 1));
  const Pose pieces[] = {Pose(Vector3(-0.5, 0, 0)), Pose(Vector3(0.5, 0, 0))};
  const std::vector<InnerFaces> inner = internalFaces({{half.get(), pieces[0]}, {half.get(), pieces[1]}}).inner;
  const Ellipsoid shape(kRadii);
  std::mt19937 random(7);
  for (int i = 0; i < 30; ++i) {
    const Matrix3 R = randomTurn(random);
    const double reach = kRadii.cwiseProduct(R.transpose() * Vector3::UnitZ()).norm();
    const Pose X(R, Vector3(0.01 * (i - 15), 0.1, 0.5 + 0.8 * reach));
    const Contact one = contactOf(whole, shape, X);
    double volume = 0;
    Vector3 area = Vector3::Zero();
    for (int piece = 0; piece < 2; ++piece) {
      Contact c;
      c.workspace.reserve(*half, shape);
      PairCache cache;
      ContactRequest request;
      request.inner.a = &inner[piece];
      contactVolume(*half, shape, pieces[piece].inverse() * X, cache, c.workspace, c.volume, request);
      if (c.volume.status != Status::kOverlap) continue;
      volume += c.volume.volume;
      area += c.volume.area_vector_A;
      EXPECT_NEAR((c.volume.normal() - Vector3::UnitZ()).norm(), 0, 1e-7) << i;
    }
    EXPECT_NEAR(volume, one.volume.volume, 1e-12 * volume);
    EXPECT_NEAR((area - one.volume.area_vector_A).norm(), 0, 1e-10 * area.norm());
  }
}

/// Without the room that `reserve` makes it still pushes apart, and says so.
TEST(EllipsoidContact, PushesWithoutRoom) {
  const ConvexPolyhedron box = makeBox(Vector3(0.5, 0.4, 0.3));
  const Ellipsoid shape(kRadii);
  ContactWorkspace empty;
  PairCache cache;
  ContactVolume out;
  contactVolume(box, shape, Pose(Vector3(0, 0, 0.15 + kRadii.z() - 0.01)), cache, empty, out);
  ASSERT_EQ(out.status, Status::kOverlap);
  EXPECT_NE(out.flags & ContactVolume::kCapacityExceeded, 0u);
  EXPECT_NEAR(out.depth, 0.01, 1e-12);
  EXPECT_NEAR((out.normal() - Vector3::UnitZ()).norm(), 0, 1e-12);
}

}  // namespace ellipsoid_contact_test
}  // namespace haptic
