#include "haptic_core/geometry/volume/contact_integrals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace contact_integrals_test {

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

/// Keeps what of a polygon lies left of from → to.
std::vector<Vector2> leftOf(const std::vector<Vector2>& polygon, const Vector2& from, const Vector2& to) {
  std::vector<Vector2> kept;
  const auto height = [&](const Vector2& r) { return (to - from).y() * (r - from).x() - (to - from).x() * (r - from).y(); };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double hp = height(p), hq = height(q);
    if (hp <= 0) kept.push_back(p);
    if ((hp <= 0) != (hq <= 0)) kept.push_back(p + hp / (hp - hq) * (q - p));
  }
  return kept;
}

/// ∫ d² dA by the definition: each face above laid over each face below, and a quadrature that is exact on triangles.
double overlaid(ContactWorkspace& w, const ContactVolume& contact) {
  w.buildLoops();
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  struct Face {
    Vector3 N;
    double offset;
    std::vector<Vector2> polygon;
  };
  std::vector<Face> faces;
  for (const ContactLoop& loop : w.loops()) {
    const ContactFace& f = w.faces()[loop.face];
    Face face{R_PA * f.normal, f.offset - f.normal.dot(contact.X_AP.p), {}};
    for (int i = 0; i < loop.count; ++i) {
      face.polygon.push_back((R_PA * (w.vertices()[w.loopVertices()[loop.first + i]] - contact.X_AP.p)).head<2>());
    }
    if (face.N.z() < 0) std::reverse(face.polygon.begin(), face.polygon.end());
    faces.push_back(face);
  }
  double sum = 0;
  for (const Face& above : faces) {
    for (const Face& below : faces) {
      if (above.N.z() < 1e-9 || below.N.z() > -1e-9) continue;
      std::vector<Vector2> part = above.polygon;
      for (std::size_t i = 0; i < below.polygon.size(); ++i) {
        part = leftOf(part, below.polygon[i], below.polygon[(i + 1) % below.polygon.size()]);
      }
      const auto height = [](const Face& f, const Vector2& r) { return (f.offset - f.N.head<2>().dot(r)) / f.N.z(); };
      const auto d2 = [&](const Vector2& r) { return std::pow(height(above, r) - height(below, r), 2); };
      for (std::size_t i = 1; i + 1 < part.size(); ++i) {
        const Vector2 ab = part[i] - part[0], ac = part[i + 1] - part[0];
        const double area = 0.5 * (ab.x() * ac.y() - ab.y() * ac.x());
        sum += area / 3 * (d2((part[0] + part[i]) / 2) + d2((part[i] + part[i + 1]) / 2) + d2((part[i + 1] + part[0]) / 2));
      }
    }
  }
  return sum;
}

/// Flat contacts with slivers at their sides, edges, corners, deep ones, of boxes and of hulls.
TEST(ThicknessSquared, AgreesWithAllFacesLaidOverOneAnother) {
  const ConvexPolyhedron shapes[] = {makeBox(Vector3(0.1, 0.12, 0.14)), makeBox(Vector3(0.08, 0.1, 0.05)), makeSphere(0.05, 1),
                                     makeSphere(0.06, 2)};
  ContactWorkspace workspace;
  for (const ConvexPolyhedron& a : shapes) {
    for (const ConvexPolyhedron& b : shapes) workspace.reserve(a, b);
  }
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  int overlaps = 0;
  for (int i = 0; i < 4000; ++i) {
    const ConvexPolyhedron &a = shapes[i % 4], &b = shapes[i / 4 % 4];
    const Vector3 axis = Vector3(normal(random), normal(random), normal(random)).normalized();
    const double turn = i % 3 == 0 ? std::pow(10.0, -6 * uniform(random)) : M_PI * uniform(random);
    const Vector3 way = Vector3(normal(random), normal(random), normal(random)).normalized();
    PairCache cache;
    ContactVolume contact;
    contactVolume(a, b, Pose(Quaternion(Eigen::AngleAxisd(turn, axis)), (0.05 + 0.1 * uniform(random)) * way), cache, workspace,
                  contact);
    if (contact.status != ContactVolume::Status::kOverlap) continue;
    ++overlaps;
    const double expected = overlaid(workspace, contact);
    // kNegligible for each of at most a few crossings of slivers; steep faces cost the oracle digits.
    EXPECT_NEAR(thicknessSquared(workspace, contact), expected, 1e-8 * expected) << i;
    const PartMoments half = momentsWhere(workspace, contact, Vector2(1, 0), 0);
    contact.rise = 0.7 * contact.depth;  // in a plane of its own, as on a seam
    contact.X_AP.p += contact.rise * contact.normal();
    EXPECT_NEAR(momentsWhere(workspace, contact, Vector2(1, 0), 0).V1.x(), half.V1.x(), 1e-9 * half.V1.norm() + 1e-20) << i;
    EXPECT_NEAR(thicknessSquared(workspace, contact), expected, 1e-8 * expected) << i;
  }
  EXPECT_GT(overlaps, 1000);
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

}  // namespace contact_integrals_test
}  // namespace haptic
