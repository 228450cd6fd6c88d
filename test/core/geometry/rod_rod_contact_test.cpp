#include "haptic_core/geometry/pairs/rod_rod_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "../../benchmark/shapes_pairs.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/volume/contact_integrals.h"
#include "haptic_core/geometry/volume/rod_integral.h"
#include "random_pairs.h"
#include "rod_oracle.h"

namespace haptic {
namespace rod_rod_contact_test {

using random_pairs::Contact;
using random_pairs::contactOf;
using Status = ContactVolume::Status;
using bench::RodKinds;
using bench::RodPose;
using bench::RodPoses;
constexpr double kEps = std::numeric_limits<double>::epsilon();

Matrix3 turn(double angle, const Vector3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

using Real = long double;
using Oracle = oracle::RodOracle<Real>;
oracle::Vec<Real> exact(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}
Vector3 rounded(const oracle::Vec<Real>& v) {
  return Vector3(v.x, v.y, v.z);
}

Oracle oracleOf(const RodPose& pair, const Vector3& hint) {
  const Oracle::Rod A{pair.radius[0], Real(pair.length[0]) / 2, pair.round[0]},
      B{pair.radius[1], Real(pair.length[1]) / 2, pair.round[1]};
  auto axis = exact(pair.X_AB.R.col(2));
  axis = axis.times(1 / std::sqrt(axis.dot(axis)));
  return Oracle(A, B, axis, exact(pair.X_AB.p), exact(hint));
}

/// Relative errors times the depth over the lesser radius, so that rounding of the pose, ε r / depth, counts
/// as ε.
void compare(const RodPose& pair, double tolerance) {
  const Contact c = contactOf(pair.rod(0), pair.rod(1), pair.X_AB);
  const ContactVolume& v = c.volume;
  const bool overlap = v.status == Status::kOverlap;
  const Oracle oracle = oracleOf(pair, overlap ? v.X_AP.p : Vector3(0.5 * pair.X_AB.p));
  const double V = oracle.volume();
  if (!(V > 0)) return;
  ASSERT_TRUE(overlap);
  if (oracle.gaveUp()) return;
  const double share = std::min(1.0, v.depth / pair.lesser()), room = tolerance / share;
  const Vector3 S = rounded(oracle.areaVector());
  const double surface = std::max(S.norm(), std::pow(V, 2.0 / 3));
  EXPECT_NEAR(v.volume, V, room * V);
  EXPECT_NEAR((v.area_vector_A - S).norm(), 0, room * surface);
  RodPair planes;
  planes.place(pair.rod(0), pair.rod(1), pair.X_AB);
  RodBreaks breaks;
  const Vector3 torque = planes.R_AE * RodIntegral(planes, breaks).torque();
  const Vector3 centroid = rounded(oracle.centroid());
  EXPECT_NEAR((torque - rounded(oracle.torque())).norm(), 0,
              room * surface * (centroid.norm() + std::cbrt(V)));
  Matrix3 second;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) second(i, j) = oracle.second(exact(v.X_AP.R.col(i)), exact(v.X_AP.R.col(j)));
  }
  EXPECT_NEAR((v.X_AP.p - centroid).norm(), 0, room * std::sqrt(second.trace() / V));
  EXPECT_NEAR((v.V2 - second.topLeftCorner<2, 2>()).norm(), 0, room * second.norm());
}

TEST(RodRodContact, CylindersAreThoseOfTheOracle) {
  RodPoses poses(RodKinds::kCylinders, 11);
  for (int i = 0; i < 60 && !HasFatalFailure(); ++i) {
    SCOPED_TRACE(i);
    compare(poses.next(), 1e-10);
  }
}

TEST(RodRodContact, RoundEndsAreThoseOfTheOracle) {
  RodPoses capsules(RodKinds::kCapsules, 12), both(RodKinds::kBoth, 13);
  for (int i = 0; i < 3 && !HasFatalFailure(); ++i) {
    SCOPED_TRACE(i);
    compare(capsules.next(), 1e-8);
    compare(both.next(), 1e-8);
  }
}

/// n is the area vector's direction, and would step where the number of sections does: by what these leave of it. Poses in which round
/// ends lie deep in a side, with singularities close beyond V: 24 sections for the whole of a high piece, and 16 for one of 0.3 radii,
/// left 4e-9 and 2e-9 of S.
TEST(RodRodContact, DeepRoundEndsHaveTheAreaVectorOfTheOracle) {
  struct Deep {
    double radius[2], length[2];
    bool round[2];
    Vector3 turning, p;
  };
  const Deep poses[] = {
      {{0.044524383211319754, 0.032348231368992876}, {0.071590717587948285, 0.094926332891169266}, {true, false},
       {4.08389717235696e-10, -5.1540562769216728e-10, 0}, {0.053172159793646069, 3.4920898235984181e-11, -0.011667807685661119}},
      {{0.044524383211319754, 0.032348231368992876}, {0.071590717587948285, 0.094926332891169266}, {true, false},
       {8.3617987130507857e-10, -4.6103364222081429e-10, 0}, {0.053172159749791351, 9.7208603142373494e-11, -0.011667807643117954}},
      {{0.025846184765886716, 0.02905036217579203}, {0.087951666742275392, 0.093929537459593371}, {false, true},
       {-6.1757294664675184e-10, 2.2196884436732324e-10, 0}, {0.049686316219894673, -5.9837777400556357e-11, -0.014918643466976725}}};
  constexpr double kQuadrature = 5e-10;
  for (const Deep& deep : poses) {
    RodPose pair;
    for (int k = 0; k < 2; ++k) pair.radius[k] = deep.radius[k], pair.length[k] = deep.length[k], pair.round[k] = deep.round[k];
    pair.X_AB = Pose(turn(deep.turning.norm(), deep.turning), deep.p);
    const Contact c = contactOf(pair.rod(0), pair.rod(1), pair.X_AB);
    const Vector3 S = rounded(oracleOf(pair, c.volume.X_AP.p).areaVector());
    EXPECT_NEAR((c.volume.area_vector_A - S).norm(), 0, kQuadrature * S.norm());
  }
}

/// Two cylinders of equal radii that cross at right angles: 16/3 r³ (Steinmetz).
TEST(RodRodContact, CrossingAxesShareSteinmetzsSolid) {
  const Rod rod(0.5, 3, Rod::Ends::kFlat);
  const Contact c = contactOf(rod, rod, Pose(turn(M_PI / 2, Vector3(1, 0, 0)), Vector3(0, 0.1, 0)));
  EXPECT_NEAR(c.volume.volume, 16.0 / 3 * 0.125,
              1e-7);  // axes that meet: four roots of the half widths coincide
}

/// Lens of two discs times the common length; and what the patch tells of it, by Simpson's rule over the
/// thickness.
TEST(RodRodContact, ParallelCylindersShareALens) {
  const double r = 0.05, length = 0.4;
  const Rod rod(r, length, Rod::Ends::kFlat), shorter(r, length - 0.1, Rod::Ends::kFlat);
  for (const double depth : {1e-7, 1e-5, 1e-3, 1e-2}) {
    const double D = 2 * r - depth, common = length - 0.1, half = std::sqrt(r * r - 0.25 * D * D),
                 angle = std::asin(half / r);
    const Contact c = contactOf(rod, shorter, Pose(Vector3(0.6 * D, 0.8 * D, 0.03)));
    ASSERT_EQ(c.volume.status, Status::kOverlap);
    // r² (2φ − sin 2φ) loses digits of small angles: the pose's own rounding.
    const double lens = depth < 1e-4 ? 2.0 / 3 * 2 * half * depth * (1 + 0.05 * half * half / r / r)
                                     : r * r * (2 * angle - std::sin(2 * angle));
    const double rounding = 20 * kEps * r / depth + (depth < 1e-4 ? 1e-6 : 1e-12);
    EXPECT_NEAR(c.volume.volume, lens * common, rounding * lens * common) << depth;
    EXPECT_NEAR((c.volume.normal() - Vector3(0.6, 0.8, 0)).norm(), 0, 1e-9);
    EXPECT_NEAR(c.volume.A0, 2 * half * common, (rounding + 1e-10) * c.volume.A0);
    EXPECT_NEAR(c.volume.depth, depth, 1e-9 * depth + 4 * kEps);
    double square = 0;
    constexpr int kSteps = 2000;
    for (int i = 0; i <= kSteps; ++i) {
      const double y = half * (2.0 * i / kSteps - 1), d = 2 * std::sqrt(r * r - y * y) - D;
      square += (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2) * d * d * common * 2 * half / (3 * kSteps);
    }
    Contact patch = contactOf(rod, shorter, Pose(Vector3(0.6 * D, 0.8 * D, 0.03)));
    // The outline has 32 lines: they cut the corners of a rectangle off.
    EXPECT_NEAR(thicknessSquared(patch.workspace, patch.volume), square, 4e-3 * square) << depth;
    const PartMoments part = momentsWhere(patch.workspace, patch.volume, Vector2(0.3, 0.7), 0);
    EXPECT_NEAR(part.volume, 0.5 * patch.volume.volume, 0.02 * patch.volume.volume) << depth;
  }
}

/// Round ends that touch are two balls.
TEST(RodRodContact, CapsulesTipsAreBalls) {
  const double r = 0.3, s = 0.2, length = 0.8;
  const Rod A(r, length, Rod::Ends::kRound), B(s, length, Rod::Ends::kRound);
  const Ball a(r), b(s);
  for (const double depth : {1e-6, 1e-3, 0.05}) {
    const Vector3 between = (r + s - depth) * Vector3(0.2, -0.3, 0.9).normalized();
    const Matrix3 R = turn(0.4, Vector3(1, 2, 0));  // B's axis leads away
    const Contact rods =
        contactOf(A, B, Pose(R, Vector3(0, 0, 0.5 * length) + between + 0.5 * length * R.col(2)));
    const Contact balls = contactOf(a, b, Pose(between));
    // The tips' distance is 6 ε off: four coordinates of about 1 m are rounded, and axes of 0.4 m are unit vectors but for ε. V goes with
    // the depth's square, A0 with the depth, V2 with its cube. The quadrature's own error is below 1e-12.
    const double rounding = 6 * kEps / depth + 1e-12;
    EXPECT_NEAR(rods.volume.volume, balls.volume.volume, 2 * rounding * balls.volume.volume) << depth;
    EXPECT_NEAR((rods.volume.normal() - balls.volume.normal()).norm(), 0, rounding) << depth;
    EXPECT_NEAR(rods.volume.A0, balls.volume.A0, rounding * balls.volume.A0) << depth;
    EXPECT_NEAR((rods.volume.V2 - balls.volume.V2).norm(), 0, 3 * rounding * balls.volume.V2.norm()) << depth;
  }
}

/// Either may come first.
TEST(RodRodContact, IsTheSameSeenFromB) {
  RodPoses poses(RodKinds::kBoth, 5);
  int compared = 0;
  for (int i = 0; i < 200; ++i) {
    const RodPose pair = poses.next();
    const Rod A = pair.rod(0), B = pair.rod(1);
    Contact one = contactOf(A, B, pair.X_AB), two = contactOf(B, A, pair.X_AB.inverse());
    if (one.volume.status != Status::kOverlap || two.volume.status != Status::kOverlap) continue;
    ++compared;
    const double room = 1e-8 / std::min(1.0, one.volume.depth / pair.lesser()), V = one.volume.volume;
    EXPECT_NEAR(V, two.volume.volume, room * V) << i;
    EXPECT_NEAR((one.volume.area_vector_A + pair.X_AB.R * two.volume.area_vector_A).norm(), 0,
                room * (one.volume.area_vector_A.norm() + std::pow(V, 2.0 / 3)))
        << i;
    // Samples lie in directions that do not depend on the order: the rule's error of 4e-3 is the same.
    const double squares = thicknessSquared(one.workspace, one.volume);
    EXPECT_NEAR(squares, thicknessSquared(two.workspace, two.volume), room * squares) << i;
  }
  EXPECT_GT(compared, 100);
}

/// Through parallel axes the planes turn by any angle; the wrench does not.
TEST(RodRodContact, PassesParallelAxesWithoutAJump) {
  for (const bool round : {false, true}) {
    const Rod A(0.05, 0.3, round ? Rod::Ends::kRound : Rod::Ends::kFlat),
        B(0.04, 0.2, round ? Rod::Ends::kRound : Rod::Ends::kFlat);
    for (const double angle : {0.0, 1e-15, 1e-14, 1e-12, 1e-9}) {
      for (const double about : {0.0, 0.5, 1.2, 2.0}) {
        const Vector3 p(0.09 - 2e-4, 0, 0.08);
        const Contact c = contactOf(A, B, Pose(turn(angle, Vector3(std::cos(about), std::sin(about), 0)), p)),
                      straight = contactOf(A, B, Pose(p));
        const double V = straight.volume.volume,
                     room = 1e-9 + 1e3 * angle;  // a lever of 0.1 m over a depth of 0.2 mm
        EXPECT_NEAR(c.volume.volume, V, room * V) << angle << " " << about;
        EXPECT_NEAR((c.volume.normal() - straight.volume.normal()).norm(), 0, room) << angle << " " << about;
        EXPECT_NEAR((c.volume.X_AP.p - straight.volume.X_AP.p).norm(), 0, 0.1 * room)
            << angle << " " << about;
      }
    }
  }
}

/// Planes along both axes of nearly parallel rods may lie in any direction. In all of them the area vector is that of parallel rods:
/// the chord times the common length. A turn by 1e-11 changes it by a lever of 0.3 m over a depth of 1 mm: 3e-9 at most.
TEST(RodRodContact, NearlyParallelCylindersHaveTheLensOfParallelOnes) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const double ra = 0.03 * (1 + 0.5 * u(random)), rb = 0.03 * (1 + 0.5 * u(random)), depth = 1e-3 * (5 + 4 * u(random));
    const Rod A(ra, 0.3, Rod::Ends::kFlat), B(rb, 0.2, Rod::Ends::kFlat);
    const double D = ra + rb - depth, along = (ra * ra - rb * rb + D * D) / (2 * D), chord = 2 * std::sqrt(ra * ra - along * along);
    const Vector3 towards = Eigen::AngleAxisd(M_PI * u(random), Vector3::UnitZ()) * Vector3::UnitX(),
                  axis = Eigen::AngleAxisd(M_PI * u(random), Vector3::UnitZ()) * Vector3::UnitX();
    const Contact c = contactOf(A, B, Pose(turn(1e-11, axis), D * towards + Vector3(0, 0, 0.04 * u(random))));
    ASSERT_EQ(c.volume.status, Status::kOverlap);
    EXPECT_NEAR((c.volume.area_vector_A - chord * 0.2 * towards).norm(), 0, 3e-9 * chord * 0.2) << i;
  }
}

/// An end that overhangs does not make the contact deeper.
TEST(RodRodContact, DepthIsThatOfTheSides) {
  const Rod A(0.05, 0.3, Rod::Ends::kFlat), B(0.04, 0.3, Rod::Ends::kFlat);
  for (const double depth : {1e-6, 1e-4, 1e-2}) {
    EXPECT_NEAR(contactOf(A, B, Pose(Vector3(0.09 - depth, 0, 0.25))).volume.depth, depth, 40 * kEps * 0.3 + 1e-12 * depth);
  }
}

TEST(RodRodContact, SeparatedHasAProof) {
  RodPoses poses(RodKinds::kBoth, 6);
  for (int i = 0; i < 100; ++i) {
    RodPose pair = poses.next();
    pair.X_AB.p *= 1.0 + 2.0 * pair.lesser() / pair.X_AB.p.norm();
    const Contact c = contactOf(pair.rod(0), pair.rod(1), pair.X_AB);
    const Oracle oracle = oracleOf(pair, 0.5 * pair.X_AB.p);
    EXPECT_EQ(c.volume.status == Status::kOverlap, oracle.volume() > 0) << i;
  }
}

}  // namespace rod_rod_contact_test
}  // namespace haptic
