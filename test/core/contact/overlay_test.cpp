/// The overlay of two faces of many corners, where a damper pulls over a part of the patch. Oracle: a disc's segment.
#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"

namespace haptic {
namespace overlay_test {

/// p = k d - b ω y over a disc, positive below the line y0 = k d/(b ω): ∫ b ω (y0 - y) over that part.
TEST(Overlay, HasRoomForAllCornersOfRoundFaces) {
  constexpr double kDepth = 1e-3, k = 1e6, b = 2e3, y0 = 0.0125, kTurn = k * kDepth / (b * y0);
  const ConvexPolyhedron floor = makeBox(Vector3(1, 1, 0.2));
  for (const int sides : {64, 256, 1024}) {
    const ConvexPolyhedron prism = makeCylinder(0.05, 0.1, sides);
    ContactWorkspace workspace;
    workspace.reserve(floor, prism);
    ContactVolume volume;
    PairCache cache;
    const Pose X_AB(Vector3(0, 0, 0.15 - kDepth));
    contactVolume(floor, prism, X_AB, cache, workspace, volume);
    PairLaw law;
    law.pressure = PressureLaw::kLinear;
    law.material = combine({}, {}, ContactMaterial{});
    law.material.stiffness = k;
    law.material.damping = b;
    law.reduced_mass = 1;
    const Twist V{volume.X_AP.R.transpose() * Vector3(kTurn, 0, 0), Vector3::Zero()};
    const LocatedForce force = locatedForce(volume, X_AB, workspace, V, FrictionMemory{}, law, Advance{});
    EXPECT_TRUE(force.clipped);
    EXPECT_FALSE(force.incomplete) << sides;
    const double R = std::sqrt(volume.A0 / M_PI), half = std::acos(-y0 / R);
    const double area = R * R * (half - std::sin(half) * std::cos(half)), first = -2.0 / 3 * std::pow(R * std::sin(half), 3);
    const double expected = b * kTurn * (y0 * area - first);
    // A polygon of the disc's area has its second moment, which decides here, off by (2π/n)²/6 or less.
    EXPECT_NEAR(force.normal_force, expected, 7.0 / (sides * sides) * expected) << sides;
  }
}

}  // namespace overlay_test
}  // namespace haptic
