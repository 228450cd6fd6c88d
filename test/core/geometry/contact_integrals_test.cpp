#include "haptic_core/geometry/contact_integrals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "haptic_core/geometry/shapes.h"

namespace haptic {
namespace {

/// Contact of a sphere-like body in a box, in a general pose.
struct ContactIntegrals : testing::Test {
  ContactIntegrals() {
    workspace.reserve(a, b);
    contactVolume(a, b, X, cache, workspace, contact);
  }
  ConvexPolyhedron a = makeBox(Vector3(0.1, 0.12, 0.14)), b = makeSphere(0.05, 1);
  Pose X{Quaternion(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized())), Vector3(0.03, 0.02, 0.09)};
  ContactWorkspace workspace;
  PairCache cache;
  ContactVolume contact;
};

TEST_F(ContactIntegrals, OfBothSidesOfALineSumToTheWhole) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const Vector2 a(normal(random), normal(random));
    const double b = 0.01 * normal(random);
    const PartMoments below = momentsWhere(workspace, contact, a, b),
                      above = momentsWhere(workspace, contact, -a, -b);
    const double size = 0.05;
    // Sums of a hundred terms of the whole's size: 1e-14 of it.
    EXPECT_NEAR(below.volume + above.volume, contact.volume, 1e-14 * contact.volume);
    EXPECT_NEAR((below.V1 + above.V1).norm(), 0, 1e-14 * contact.volume * size);
    EXPECT_NEAR((below.V2 + above.V2 - contact.V2).norm(), 0, 1e-14 * contact.volume * size * size);
    EXPECT_NEAR(below.A0 + above.A0, contact.A0, 1e-14 * contact.A0);
    EXPECT_NEAR((below.A1 + above.A1 - contact.A1).norm(), 0, 1e-14 * contact.A0 * size);
    EXPECT_NEAR((below.A2 + above.A2 - contact.A2).norm(), 0, 1e-14 * contact.A0 * size * size);
    EXPECT_GE(below.volume, 0);
    // Centroids lie on their sides.
    if (below.volume > 0) EXPECT_LE(a.dot(below.V1), b * below.volume * (1 + 1e-9) + 1e-15);
  }
}

TEST_F(ContactIntegrals, OfSquaredThicknessAgreeWithSampledColumns) {
  // Midpoint rule on columns through the planes of V; its error falls like the cell, here below 1 %.
  const int cells = 400;
  double radius = 0, sum = 0, volume = 0;
  for (const Vector3& x : workspace.vertices()) radius = std::max(radius, (x - contact.X_AP.p).norm());
  const double cell = 2 * radius / cells;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const Vector3 r((i + 0.5) * cell - radius, (j + 0.5) * cell - radius, 0);
      double low = -INFINITY, high = INFINITY;
      for (const ContactFace& f : workspace.faces()) {
        const Vector3 N = contact.X_AP.R.transpose() * f.normal;
        const double z = (f.offset - f.normal.dot(contact.X_AP * r)) / N.z();
        if (N.z() > 0)
          high = std::min(high, z);
        else
          low = std::max(low, z);
      }
      if (high > low) {
        sum += (high - low) * (high - low) * cell * cell;
        volume += (high - low) * cell * cell;
      }
    }
  EXPECT_NEAR(volume, contact.volume, 1e-3 * contact.volume);
  EXPECT_NEAR(thicknessSquared(workspace, contact), sum, 1e-3 * sum);
}

TEST(ThicknessSquared, OfBoxesIsVolumeTimesDepth) {
  const ConvexPolyhedron floor = makeBox(Vector3(1, 1, 0.1)), box = makeBox(Vector3(0.1, 0.1, 0.1));
  ContactWorkspace workspace;
  workspace.reserve(floor, box);
  PairCache cache;
  ContactVolume contact;
  contactVolume(floor, box, Pose(Vector3(0.2, 0.1, 0.1 - 1e-4)), cache, workspace, contact);
  EXPECT_NEAR(thicknessSquared(workspace, contact), 1e-2 * 1e-8, 1e-2 * 1e-8 * 1e-11);
}

}  // namespace
}  // namespace haptic
