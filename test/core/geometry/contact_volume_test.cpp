#include "haptic_core/geometry/volume/contact_volume.h"

#include <gtest/gtest.h>

#include <random>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "hard_cases.h"

namespace haptic {
namespace contact_volume_test {

ContactVolume contact(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB) {
  ContactWorkspace workspace;
  workspace.reserve(A, B);
  PairCache cache;
  ContactVolume out;
  contactVolume(A, B, X_AB, cache, workspace, out);
  return out;
}

TEST(ContactVolume, OfAlignedBoxesIsTheClosedForm) {
  const ConvexPolyhedron floor = makeBox(Vector3(0.2, 0.2, 0.1)), box = makeBox(Vector3(0.08, 0.07, 0.1));
  const double dx = 0.02, dy = -0.03, depth = 1e-3, area = 0.08 * 0.07;
  const ContactVolume v = contact(floor, box, Pose(Vector3(dx, dy, 0.1 - depth)));
  ASSERT_EQ(v.status, ContactVolume::Status::kOverlap);
  // Coordinates are rounded to 1e-17 m: volume to a few times that times the area, and so on for the moments.
  EXPECT_NEAR(v.volume, area * depth, 1e-16 * area);
  EXPECT_NEAR(v.A0, area, 1e-17);
  EXPECT_NEAR((v.normal() - Vector3::UnitZ()).norm(), 0, 1e-15);
  EXPECT_NEAR((v.X_AP.p - Vector3(dx, dy, 0.05 - depth / 2)).norm(), 0, 1e-14);
  EXPECT_NEAR(v.A1.norm(), 0, 1e-16);
  EXPECT_NEAR(v.A2(0, 0), area * 0.08 * 0.08 / 12, 1e-18);
  EXPECT_NEAR(v.A2(1, 1), area * 0.07 * 0.07 / 12, 1e-18);
  EXPECT_NEAR(v.V2(0, 0), area * depth * 0.08 * 0.08 / 12, 1e-19);
  EXPECT_NEAR(v.V2(1, 1), area * depth * 0.07 * 0.07 / 12, 1e-19);
  EXPECT_NEAR(v.depth, depth, 1e-16);
}

TEST(ContactVolume, ShrinksAtTheRateOfTheAreaVector) {
  const ConvexPolyhedron a = makeBox(Vector3(0.1, 0.12, 0.14)), b = makeSphere(0.05, 1);
  const Quaternion q(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()));
  const Pose X(q, Vector3(0.03, 0.02, 0.09));
  const ContactVolume v = contact(a, b, X);
  ASSERT_EQ(v.status, ContactVolume::Status::kOverlap);
  const double step = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 d = step * Vector3::Unit(axis);
    const double rate =
        (contact(a, b, Pose(q, X.p + d)).volume - contact(a, b, Pose(q, X.p - d)).volume) / (2 * step);
    // Central difference: the volume is a cubic, error ≤ step² of its third derivative (order 1).
    EXPECT_NEAR(rate, -v.area_vector_A[axis], 1e-10);
  }
  EXPECT_NEAR(v.A0, v.normal().dot(v.area_vector_A), 1e-15);
}

using Status = ContactVolume::Status;

/// Random pairs of three shapes near each other; some deep, some separated.
struct RandomPairs {
  RandomPairs() {
    std::vector<Vector3> points;
    for (int i = 0; i < 40; ++i) points.push_back(0.05 * direction());
    shapes = {makeBox(Vector3(0.1, 0.08, 0.06)), ConvexPolyhedron::hull(points), makeCylinder(0.04, 0.1, 12)};
    for (const auto& a : shapes)
      for (const auto& b : shapes) workspace.reserve(a, b);
  }
  Vector3 direction() { return Vector3(normal(random), normal(random), normal(random)).normalized(); }
  Pose pose(double nearest, double farthest) {
    const Quaternion q(normal(random), normal(random), normal(random), normal(random));
    return Pose(q.normalized(),
                std::uniform_real_distribution<double>(nearest, farthest)(random) * direction());
  }
  template <class Visit>
  void each(int count, Visit&& visit) {
    for (int i = 0; i < count; ++i)
      visit(shapes[random() % shapes.size()], shapes[random() % shapes.size()], pose(0.0, 0.1));
  }
  std::mt19937 random{3};
  std::normal_distribution<double> normal;
  std::vector<ConvexPolyhedron> shapes;
  ContactWorkspace workspace;
};

/// Position error of a volume: its error over the area it acts on. Roundings of 0.1 m coordinates.
constexpr double kPosition = 2e-15;

TEST(ContactVolume, IsTheSameByCuttingAndByClipping) {
  RandomPairs pairs;
  int overlaps = 0;
  pairs.each(3000, [&](const ConvexPolyhedron& a, const ConvexPolyhedron& b, const Pose& X) {
    PairCache cache;
    ContactVolume v, w;
    contactVolume(a, b, X, cache, pairs.workspace, v);
    contactVolumeByCutting(a, b, X, cache, pairs.workspace, w);
    ASSERT_EQ(v.status, w.status);
    if (v.status != Status::kOverlap) return;
    ++overlaps;
    const double area = 0.03;  // surface of the largest body
    EXPECT_NEAR(v.volume, w.volume, kPosition * area);
    EXPECT_NEAR((v.area_vector_A - w.area_vector_A).norm(), 0, kPosition);
    if (v.flags || v.area_vector_A.norm() < 1e-6) return;
    EXPECT_NEAR(v.A0, w.A0, kPosition);
    EXPECT_NEAR((v.normal() - w.normal()).norm(), 0, kPosition / v.area_vector_A.norm());
    EXPECT_NEAR((v.X_AP.p - w.X_AP.p).norm() * v.volume, 0, 0.1 * kPosition * area);
  });
  EXPECT_GT(overlaps, 1000);
}

TEST(ContactVolume, IsThatOfExtendedArithmetic) {
  RandomPairs pairs;
  pairs.each(300, [&](const ConvexPolyhedron& a, const ConvexPolyhedron& b, const Pose& X) {
    const double exact = static_cast<double>(oracle::PolygonVolume<__float128>::volume(a, b, Pose(), X));
    const ContactVolume v = contact(a, b, X);
    EXPECT_EQ(v.status == Status::kOverlap, exact > 0);
    EXPECT_NEAR(v.status == Status::kOverlap ? v.volume : 0, exact, kPosition * 0.03);
  });
}

TEST(ContactVolume, DoesNotCareWhichBodyIsFirst) {
  RandomPairs pairs;
  pairs.each(1000, [&](const ConvexPolyhedron& a, const ConvexPolyhedron& b, const Pose& X) {
    const ContactVolume v = contact(a, b, X), w = contact(b, a, X.inverse());
    ASSERT_EQ(v.status, w.status);
    if (v.status != Status::kOverlap) return;
    EXPECT_NEAR(v.volume, w.volume, kPosition * 0.03);
    // S_B = -S_A, seen from the other body.
    EXPECT_NEAR((X.R * w.area_vector_A + v.area_vector_A).norm(), 0, kPosition);
  });
}

TEST(ContactVolume, ScalesWithItsBodies) {
  RandomPairs pairs;
  for (const double scale : {1e-3, 1e3}) {
    std::vector<ConvexPolyhedron> scaled;
    for (const auto& shape : pairs.shapes) {
      std::vector<Vector3> points = shape.vertices();
      for (Vector3& p : points) p *= scale;
      scaled.push_back(ConvexPolyhedron::hull(points));
    }
    for (int i = 0; i < 300; ++i) {
      const int a = i % 3, b = i / 3 % 3;
      const Pose X = pairs.pose(0.0, 0.09);
      const ContactVolume v = contact(pairs.shapes[a], pairs.shapes[b], X);
      const ContactVolume w = contact(scaled[a], scaled[b], Pose(X.R, scale * X.p));
      EXPECT_NEAR(v.volume, w.volume / (scale * scale * scale), kPosition * 0.03);
    }
  }
}

TEST(ContactVolume, GrowsWithDepth) {
  RandomPairs pairs;
  for (int i = 0; i < 200; ++i) {
    const auto &a = pairs.shapes[i % 3], &b = pairs.shapes[i / 3 % 3];
    const Pose X = pairs.pose(0.08, 0.1);
    double last = 0;
    for (double s = 1.2; s > 0.6; s -= 0.01) {
      const ContactVolume v = contact(a, b, Pose(X.R, s * X.p));
      const double volume = v.status == Status::kOverlap ? v.volume : 0;
      // Approaching centres need not grow the volume of any two bodies, but it cannot shrink where S opposes.
      if (v.status == Status::kOverlap && v.area_vector_A.dot(X.p) > 1e-6)
        EXPECT_GT(volume, last - kPosition * 0.03);
      last = volume;
    }
  }
}

TEST(ContactVolume, DoesNotDependOnHowFacesAreTriangulated) {
  RandomPairs pairs;
  for (const auto& shape : pairs.shapes) {
    std::vector<std::vector<int>> loops;
    for (const auto& t : shape.triangles().triangles) loops.push_back({t[0], t[1], t[2]});
    const ConvexPolyhedron split(shape.vertices(), loops);
    pairs.workspace.reserve(split, shape);
    for (int i = 0; i < 300; ++i) {
      const Pose X = pairs.pose(0.0, 0.1);
      const ContactVolume v = contact(pairs.shapes[i % 3], shape, X),
                          w = contact(pairs.shapes[i % 3], split, X);
      ASSERT_EQ(v.status, w.status);
      if (v.status != Status::kOverlap) continue;
      EXPECT_NEAR(v.volume, w.volume, kPosition * 0.03);
      EXPECT_NEAR((v.area_vector_A - w.area_vector_A).norm(), 0, kPosition);
    }
  }
}

TEST(ContactVolume, IsRightInEveryHardCase) {
  oracle::HardCases cases(1);
  int count = 0, false_empty = 0, wrong = 0, failed = 0;
  cases.each([&](const oracle::HardCase& c) {
    const ContactVolume v = contact(*c.a, *c.b, c.X_AB);
    const oracle::Verdict verdict = oracle::judge(c, v);
    ++count;
    false_empty += verdict.false_empty;
    wrong += verdict.wrong;
    failed += verdict.failed;
    if (verdict.false_empty || verdict.wrong || verdict.failed)
      ADD_FAILURE() << c.kind << ": shapes of " << c.a->boundingRadius() << " and " << c.b->boundingRadius()
                    << " m, exact " << verdict.exact << ", error " << verdict.error << ", allowed "
                    << verdict.allowed;
  });
  EXPECT_EQ(false_empty + wrong + failed, 0);
  EXPECT_GT(count, 3000);
}

TEST(ContactVolume, KeepsTheLastNormalWhereTheAreaVectorVanishes) {
  const ConvexPolyhedron plate = makeBox(Vector3(0.1, 0.1, 0.001)), rod = makeBox(Vector3(0.01, 0.01, 0.1));
  ContactWorkspace workspace;
  workspace.reserve(plate, rod);
  PairCache cache;
  ContactVolume v;
  contactVolume(plate, rod, Pose(Vector3(0, 0, 0.05)), cache, workspace, v);
  ASSERT_EQ(v.status, Status::kOverlap);
  EXPECT_FALSE(v.flags & ContactVolume::kNormalFromHistory);
  contactVolume(plate, rod, Pose(Vector3(0, 0, 0.03)), cache, workspace, v);
  EXPECT_TRUE(v.flags & ContactVolume::kNormalFromHistory);
  EXPECT_NEAR((v.normal() - Vector3::UnitZ()).norm(), 0, 1e-12);
  EXPECT_NEAR(v.volume, 0.01 * 0.01 * 0.001, 1e-18);
}

TEST(ContactVolume, KeepsTheSeparatedNormalByTheHistoryRule) {
  const ConvexPolyhedron box = makeBox(Vector3(0.1, 0.1, 0.1));
  ContactWorkspace workspace;
  workspace.reserve(box, box);
  PairCache cache;
  ContactVolume v;
  contactVolume(box, box, Pose(Vector3(0, 0, 0.11)), cache, workspace, v, {NormalRule::kHistory, {}, Vector3::Zero()});
  ASSERT_EQ(v.status, Status::kSeparated);
  // Pushed sideways until the area vector lies flat: the separated normal stays.
  const Pose X(Vector3(0.095, 0, 0.09));
  contactVolume(box, box, X, cache, workspace, v, {NormalRule::kHistory, {}, Vector3::Zero()});
  ASSERT_EQ(v.status, Status::kOverlap);
  EXPECT_NEAR((v.normal() - Vector3::UnitZ()).norm(), 0, 1e-12);
  PairCache fresh;
  contactVolume(box, box, X, fresh, workspace, v);
  EXPECT_GT(v.normal().x(), 0.8);
}

TEST(ContactVolume, PushesAndSaysSoWithoutRoom) {
  const ConvexPolyhedron small = makeBox(Vector3(0.1, 0.1, 0.1)), round = makeSphere(0.05, 2);
  ContactWorkspace workspace;
  workspace.reserve(small, small);
  PairCache cache;
  ContactVolume v;
  contactVolume(small, round, Pose(Vector3(0, 0, 0.095)), cache, workspace, v);
  EXPECT_EQ(v.status, Status::kOverlap);
  EXPECT_TRUE(v.flags & ContactVolume::kCapacityExceeded);
  EXPECT_GT(v.volume, 0);
  EXPECT_GT(v.normal().z(), 0.9);
}

}  // namespace contact_volume_test
}  // namespace haptic
