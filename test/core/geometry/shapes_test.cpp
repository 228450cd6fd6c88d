#include "haptic_core/geometry/shapes/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/rod.h"

namespace haptic {
namespace shapes_test {

TEST(Shapes, BoxHasTheMassPropertiesOfABox) {
  const Vector3 s(0.1, 0.2, 0.3);
  const MassProperties m = makeBox(s).massProperties(1000);
  const double mass = 1000 * s.prod();
  EXPECT_NEAR(m.mass, mass, 1e-14 * mass);
  EXPECT_NEAR(m.com.norm(), 0, 1e-16);
  const Vector3 squares = s.cwiseAbs2();
  const Matrix3 expected = (mass / 12 * (Vector3::Constant(squares.sum()) - squares)).asDiagonal();
  EXPECT_NEAR((m.I_com - expected).norm(), 0, 1e-14 * expected.norm());
}

/// The net is written down (rod.cpp); the hull of its corners is a second way to the same polyhedron, and the capsule's volume is its own.
TEST(Shapes, ACapsulesPolyhedronIsTheHullOfItsCorners) {
  for (const double length : {1e-4, 0.1, 3.0}) {
    const Rod capsule(0.05, length, Rod::Ends::kRound);
    const ConvexPolyhedron& net = capsule.hull();
    const ConvexPolyhedron hull = ConvexPolyhedron::hull(net.vertices());
    EXPECT_EQ(net.faceCount(), hull.faceCount()) << length;
    EXPECT_EQ(net.edgeCount(), hull.edgeCount()) << length;
    EXPECT_EQ(net.vertices().size(), hull.vertices().size()) << length;
    EXPECT_NEAR(net.volume(), hull.volume(), 1e-14 * hull.volume()) << length;
    EXPECT_NEAR(net.surface(), hull.surface(), 1e-13 * hull.surface()) << length;
    EXPECT_NEAR(net.volume(), capsule.volume(), 1e-13 * capsule.volume()) << length;
  }
}

TEST(Shapes, TessellationsStateTheirVolumeError) {
  for (const int segments : {3, 16, 32, 64}) {
    TessellationReport report;
    const double exact = M_PI * 0.05 * 0.05 * 0.2;
    const ConvexPolyhedron inscribed =
        makeCylinder(0.05, 0.2, segments, RoundFit::kInscribed, "cylinder", &report);
    EXPECT_NEAR(report.volume_error, 1 - inscribed.volume() / exact, 1e-14);
    EXPECT_NEAR(report.surface_error, 0.05 * (1 - std::cos(M_PI / segments)), 1e-16);
    const ConvexPolyhedron equal =
        makeCylinder(0.05, 0.2, segments, RoundFit::kEqualVolume, "cylinder", &report);
    EXPECT_NEAR(equal.volume(), exact, 1e-14 * exact);
    EXPECT_NEAR(report.volume_error, 0, 1e-14);
  }
  for (int s = 0; s <= 4; ++s) {
    TessellationReport report;
    const double exact = 4 * M_PI / 3 * 0.05 * 0.05 * 0.05;
    const ConvexPolyhedron inscribed = makeSphere(0.05, s, RoundFit::kInscribed, "sphere", &report);
    EXPECT_NEAR(report.volume_error, 1 - inscribed.volume() / exact, 1e-13);
    EXPECT_LE(report.volume_error, 0.56 * std::pow(4.0, -s));  // as the header states
    EXPECT_EQ(inscribed.vertexCount(), 10 * static_cast<int>(std::pow(4, s)) + 2);
    for (const Vector3& v : inscribed.vertices()) EXPECT_NEAR(v.norm(), 0.05, 1e-16);
    EXPECT_NEAR(makeSphere(0.05, s, RoundFit::kEqualVolume).volume(), exact, 1e-13 * exact);
  }
}

TEST(Shapes, RefuseSizesThatAreNone) {
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(makeBox(Vector3(1, bad, 1)), SetupError);
    EXPECT_THROW(makeCylinder(bad, 1), SetupError);
    EXPECT_THROW(makeCylinder(1, bad), SetupError);
    EXPECT_THROW(makeSphere(bad), SetupError);
  }
  EXPECT_THROW(makeCylinder(1, 1, 2), SetupError);
  EXPECT_THROW(makeSphere(1, 7), SetupError);
}

}  // namespace shapes_test
}  // namespace haptic
