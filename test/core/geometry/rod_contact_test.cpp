#include "haptic_core/geometry/pairs/rod_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "../../fuzz/contact_fuzz.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_integrals.h"
#include "random_pairs.h"

namespace haptic {
namespace rod_contact_test {

using random_pairs::Contact;
using random_pairs::contactOf;
using random_pairs::randomPose;
using random_pairs::stone;
using Status = ContactVolume::Status;
constexpr double kEps = std::numeric_limits<double>::epsilon();

Matrix3 turn(double angle, const Vector3& axis) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

/// Half of a convex polyhedron, on one side of a plane through `p`.
ConvexPolyhedron half(const ConvexPolyhedron& shape, const Vector3& p, const Vector3& n) {
  std::vector<Vector3> points;
  for (const Vector3& v : shape.vertices()) {
    if (n.dot(v - p) < 0) points.push_back(v);
  }
  for (const auto& edge : shape.edges()) {
    const Vector3 &a = shape.vertices()[edge.from], &b = shape.vertices()[edge.to];
    const double ha = n.dot(a - p), hb = n.dot(b - p);
    if (ha * hb < 0) points.push_back(a + ha / (ha - hb) * (b - a));
  }
  return ConvexPolyhedron::hull(points);
}

/// Area of a circle's segment of height d.
double segment(double R, double d) {
  const double half = std::acos(1 - d / R);
  return R * R * (half - std::sin(half) * std::cos(half));
}

const double kRadius = 0.3, kLength = 0.8;

TEST(Rod, HasTheMassOfItsSolid) {
  for (const auto ends : {Rod::Ends::kFlat, Rod::Ends::kRound}) {
    const Rod rod(kRadius, kLength, ends);
    const MassProperties exact = massProperties(rod.hull().triangles(), 1), ours = rod.massProperties(1);
    EXPECT_NEAR(ours.mass, exact.mass, 1e-12);  // the drawn hull has the same volume
    EXPECT_NEAR((ours.I_com - exact.I_com).norm(), 0, 0.01 * exact.I_com.norm());
    const Pose X(turn(0.7, Vector3(1, 2, 3)), Vector3(1, 2, 3));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(rod.aabb(X).upper[axis], supportHeight(rod, X, Vector3::Unit(axis)), 4 * kEps * 4);
      EXPECT_NEAR(rod.aabb(X).lower[axis], -supportHeight(rod, X, -Vector3::Unit(axis)), 4 * kEps * 4);
    }
  }
}

TEST(RodContact, LyingOnAFaceIsASegmentTimesItsLength) {
  const ConvexPolyhedron box = makeBox(Vector3(4, 4, 4));
  const Rod cylinder(kRadius, kLength, Rod::Ends::kFlat), capsule(kRadius, kLength, Rod::Ends::kRound);
  for (double depth : {1e-9, 1e-6, 1e-3, 0.1, 0.29, 0.45}) {
    const Pose X(turn(M_PI / 2, Vector3::UnitY()), Vector3(0.1, -0.2, 2 + kRadius - depth));
    const Contact c = contactOf(box, cylinder, X), p = contactOf(box, capsule, X);
    ASSERT_EQ(c.volume.status, Status::kOverlap) << depth;
    ASSERT_EQ(p.volume.status, Status::kOverlap) << depth;
    const double rounding = 8 * kEps * 2.3 / depth + 40 * kEps;
    const double tube = kLength * (depth < 1e-3 ? 4.0 / 3 * depth * std::sqrt(2 * kRadius * depth) *
                                                      (1 - 3.0 / 20 * depth / kRadius)
                                                : segment(kRadius, depth));
    const double V = tube + M_PI * depth * depth * (kRadius - depth / 3);
    const double series = depth < 1e-3 ? depth * depth : 1e-12;  // of the segment's, and acos's rounding
    EXPECT_NEAR(c.volume.volume, tube, (2 * rounding + series) * tube) << depth;
    EXPECT_NEAR(p.volume.volume, V, (2 * rounding + series) * V) << depth;
    const double width = 2 * std::sqrt(depth * (2 * kRadius - depth));
    EXPECT_NEAR(c.volume.A0, width * kLength, rounding * width * kLength);
    EXPECT_NEAR(p.volume.A0, width * kLength + M_PI * width * width / 4, rounding * width);
    EXPECT_NEAR(c.volume.A2.trace(), width * kLength * (width * width + kLength * kLength) / 12,
                2 * rounding * c.volume.A2.trace());
    for (const Contact* one : {&c, &p}) {
      EXPECT_NEAR((one->volume.normal() - Vector3::UnitZ()).norm(), 0, 4 * kEps);
      EXPECT_NEAR(one->volume.depth, depth, 0.02 * depth);
      EXPECT_GE(one->volume.depth, depth - 10 * kEps);
      // A turn by π/2 is rounded, by which one end is deeper than the other.
      EXPECT_NEAR(one->volume.X_AP.p.x(), 0.1, 1e-9 + kEps * kLength * kLength / (8 * depth));
    }
  }
}

TEST(RodContact, StandingOnItsEndIsADisc) {
  const ConvexPolyhedron box = makeBox(Vector3(4, 4, 4));
  const Rod cylinder(kRadius, kLength, Rod::Ends::kFlat);
  for (const double tilt : {0.0, 1e-15, 1e-9, 1e-5}) {
    for (const double depth : {1e-6, 1e-3, 0.1}) {
      if (tilt * kRadius > 0.5 * depth) continue;
      for (const bool box_first : {true, false}) {
        const Pose X(turn(tilt, Vector3(1, 2, 0)), Vector3(0.1, -0.2, 2 + 0.5 * kLength - depth));
        const Contact c = box_first ? contactOf(box, cylinder, X) : contactOf(cylinder, box, X.inverse());
        ASSERT_EQ(c.volume.status, Status::kOverlap);
        // The axis goes by (L/2 (1 - cos)) deeper less; the disc's area on the plane is πR²/cos.
        const double mean = depth - kLength / 2 * (1 - std::cos(tilt)), V = M_PI * kRadius * kRadius * mean / std::cos(tilt);
        const double rounding = 10 * kEps * 2.4 / depth + 40 * kEps + tilt * tilt;
        EXPECT_NEAR(c.volume.volume, V, rounding * V) << tilt << " " << depth;
        EXPECT_NEAR(c.volume.A0, M_PI * kRadius * kRadius, (40 * kEps + tilt * tilt) * c.volume.A0);
        const Matrix2 A2 = c.volume.A2 - c.volume.A1 * c.volume.A1.transpose() / c.volume.A0;  // about the disc's middle
        EXPECT_NEAR(A2(0, 0), M_PI * std::pow(kRadius, 4) / 4, (40 * kEps + 2 * tilt * tilt) * A2(0, 0));
        EXPECT_NEAR(c.volume.depth, depth + tilt * kRadius, 0.01 * depth);
      }
    }
  }
}

/// What a polyhedron cut in two has in common with a rod adds up, wherever the cut runs: faces, edges and corners.
TEST(RodContact, AddsUpOverTheHalvesOfAPolyhedron) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const std::vector<ConvexPolyhedron> shapes = {makeBox(Vector3(1, 1.2, 0.8)), makeBox(Vector3(2, 2, 0.05)), stone(60, 0.5, 1),
                                                stone(4, 0.7, 2)};
  int overlaps = 0;
  for (const ConvexPolyhedron& shape : shapes) {
    for (const auto ends : {Rod::Ends::kFlat, Rod::Ends::kRound}) {
      for (int i = 0; i < 150; ++i) {
        const double R = std::vector<double>{0.05, 0.3, 1.5}[random() % 3], L = std::vector<double>{0.1, 0.8, 3}[random() % 3];
        const Rod rod(R, L, ends);
        const Pose X = randomPose(random, 0.5 + 0.5 * R);
        const Vector3 p = 0.1 * Vector3(u(random), u(random), u(random)), n = Vector3(u(random), u(random), u(random)).normalized();
        const auto volume = [&](const ConvexPolyhedron& part) { return contactOf(part, rod, X).volume; };
        const ContactVolume whole = volume(shape), below = volume(half(shape, p, n)), above = volume(half(shape, p, -n));
        const auto V = [](const ContactVolume& c) { return c.status == Status::kOverlap ? c.volume : 0; };
        const double surface = std::min(shape.volume(), rod.volume()) / 0.05;
        EXPECT_NEAR(V(whole), V(below) + V(above), 40 * kEps * surface) << X.R << "\n" << X.p.transpose() << " R " << R << " L " << L;
        if (!(V(whole) > 1e-4 * std::min(shape.volume(), rod.volume()))) continue;
        ++overlaps;
        Vector3 first = Vector3::Zero();
        for (const ContactVolume* c : {&below, &above}) first += V(*c) * c->X_AP.p;
        EXPECT_NEAR((first - whole.volume * whole.X_AP.p).norm(), 0, 100 * kEps * surface);
      }
    }
  }
  EXPECT_GT(overlaps, 300);
}

/// The area vector, which the faces' parts give, is the volume's gradient, which faces and the round parts give; and the wrench
/// that it makes about the origin is that of turning.
TEST(RodContact, AreaVectorIsTheGradientOfTheVolume) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  const std::vector<ConvexPolyhedron> shapes = {makeBox(Vector3(1, 1.2, 0.8)), stone(60, 0.5, 1)};
  for (const ConvexPolyhedron& shape : shapes) {
    for (const auto ends : {Rod::Ends::kFlat, Rod::Ends::kRound}) {
      const Rod rod(0.2, 0.9, ends);
      for (int i = 0; i < 100; ++i) {
        const Pose X = randomPose(random, 0.6);
        const Contact c = contactOf(shape, rod, X);
        if (c.volume.status != Status::kOverlap || c.volume.volume < 1e-3) continue;
        const double step = 1e-4;
        const auto at = [&](double s, const Vector3& way) { return contactOf(shape, rod, Pose(X.R, X.p + s * way)).volume.volume; };
        for (int axis = 0; axis < 3; ++axis) {
          const Vector3 way = Vector3::Unit(axis);
          const double d1 = (at(step, way) - at(-step, way)) / (2 * step), d2 = (at(2 * step, way) - at(-2 * step, way)) / (4 * step);
          EXPECT_NEAR((4 * d1 - d2) / 3, -c.volume.area_vector_A[axis], 1e-6) << i;
        }
        // A0: how fast the area vector's length follows is what stiffness is; here its definition.
        EXPECT_NEAR(c.volume.A0, c.volume.normal().dot(c.volume.area_vector_A), 1e-13);
      }
    }
  }
}

/// Against finely cut polyhedra: all moments to their error, and which body comes first.
TEST(RodContact, MomentsAreThoseOfAFinePolyhedron) {
  std::mt19937 random(3);
  const ConvexPolyhedron box = makeBox(Vector3(1, 1.2, 0.8)), fine = makeCylinder(0.4, 0.9, 720, RoundFit::kEqualVolume);
  const Rod rod(0.4, 0.9, Rod::Ends::kFlat);
  int compared = 0;
  for (int i = 0; i < 80; ++i) {
    Pose X = randomPose(random, 0.8);
    const bool box_first = i % 2 == 0;
    if (!box_first) X = X.inverse();
    Contact c = box_first ? contactOf(box, rod, X) : contactOf(rod, box, X);
    Contact f = box_first ? contactOf(box, fine, X) : contactOf(fine, box, X);
    ASSERT_EQ(c.volume.status == Status::kOverlap, f.volume.status == Status::kOverlap);
    if (c.volume.status != Status::kOverlap || c.volume.volume < 0.01 || c.volume.A0 < 0.1) continue;
    ++compared;
    // Surfaces 0.4 m (2π/720)²/8 = 4e-6 m apart at most.
    EXPECT_NEAR(c.volume.volume, f.volume.volume, 1e-5);
    EXPECT_NEAR((c.volume.normal() - f.volume.normal()).norm(), 0, 3e-5);
    EXPECT_NEAR((c.volume.X_AP.p - f.volume.X_AP.p).norm(), 0, 1e-5);
    EXPECT_NEAR((c.volume.V2 - f.volume.V2).norm(), 0, 5e-6);
    EXPECT_NEAR(c.volume.A0, f.volume.A0, 3e-5);
    EXPECT_NEAR((c.volume.A1 - f.volume.A1).norm(), 0, 3e-5);
    EXPECT_NEAR((c.volume.A2 - f.volume.A2).norm(), 0, 3e-5);
    EXPECT_GE(c.volume.depth, f.volume.depth - 1e-4);
    EXPECT_LE(c.volume.depth, 1.05 * f.volume.depth + 1e-4);
    if (c.volume.volume > 0.1) continue;  // deep, V folds over and an ellipse stands in
    const double exact = thicknessSquared(f.workspace, f.volume);
    // A rim that crosses the patch bends the thickness between the samples.
    EXPECT_NEAR(thicknessSquared(c.workspace, c.volume), exact, 1e-2 * exact);
  }
  EXPECT_GT(compared, 20);
}

/// ∫ d² and half patches of a lying cylinder: d = √(R² - y²) - h over its length.
TEST(RodContact, PatchIntegratesTheThickness) {
  const double depth = 0.05, h = kRadius - depth, w = std::sqrt(depth * (2 * kRadius - depth));
  const ConvexPolyhedron box = makeBox(Vector3(4, 4, 4));
  const Rod cylinder(kRadius, kLength, Rod::Ends::kFlat);
  const auto integral = [&](auto weight) {
    const int n = 100000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double y = (i + 0.5) / n * w;
      sum += w / n * weight(y, std::sqrt(kRadius * kRadius - y * y) - h);
    }
    return sum;
  };
  for (const bool box_first : {true, false}) {
    const Pose X(turn(M_PI / 2, Vector3::UnitY()), Vector3(0.1, -0.2, 2 + h));
    Contact c = box_first ? contactOf(box, cylinder, X) : contactOf(cylinder, box, X.inverse());
    const double square = 2 * kLength * integral([](double, double d) { return d * d; });
    EXPECT_NEAR(thicknessSquared(c.workspace, c.volume), square, 1e-9 * square);
    const Vector3 along_A = box_first ? Vector3(Vector3::UnitY()) : Vector3(X.R.transpose() * Vector3::UnitY());
    const Vector3 along_P = c.volume.X_AP.R.transpose() * along_A;
    const PartMoments part = momentsWhere(c.workspace, c.volume, -along_P.head<2>(), 0);
    const double exact = kLength * integral([](double y, double d) { return y * d; });
    EXPECT_NEAR(part.V1.dot(along_P.head<2>()), exact, 1e-2 * exact);
  }
}

TEST(RodContact, WithinAndAroundAPolyhedron) {
  const Rod capsule(0.1, 0.3, Rod::Ends::kRound), cylinder(0.1, 0.3, Rod::Ends::kFlat);
  const ConvexPolyhedron box = makeBox(Vector3(2, 2, 2)), pin = makeBox(Vector3(0.02, 0.02, 0.04));
  const Pose X(turn(0.4, Vector3(1, 2, 3)), Vector3(0.1, 0.2, 0.3));
  for (const Rod* rod : {&capsule, &cylinder}) {
    const Contact within = contactOf(box, *rod, X), around = contactOf(*rod, pin, Pose(X.R, Vector3(0.01, 0, 0.02)));
    EXPECT_NEAR(within.volume.volume, rod->volume(), 40 * kEps * rod->volume());
    EXPECT_NEAR((within.volume.X_AP.p - X.p).norm(), 0, 40 * kEps);
    EXPECT_NEAR(around.volume.volume, pin.volume(), 1e-12 * pin.volume());
    EXPECT_TRUE(within.volume.flags & ContactVolume::kNormalFromHistory);
  }
}

/// Across all changes of case the volume goes by its gradient: no jump, no gap, at places where faces, edges, corners, ends and
/// tangents are met.
TEST(RodContact, DoesNotJumpWhereTheCaseChanges) {
  const ConvexPolyhedron box = makeBox(Vector3(1, 1.2, 0.8));
  const double R = 0.2, L = 0.6, step = 1e-9 * R;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  const Matrix3 turns[] = {Matrix3::Identity(), turn(M_PI / 2, Vector3::UnitY()), turn(M_PI / 4, Vector3::UnitY()),
                           turn(M_PI / 2, Vector3(1, 1, 0)), turn(0.3, Vector3(1, 2, 3))};
  const double half = 0.5 * L;
  const Vector3 places[] = {{0, 0, 0.4 + half - 1e-3}, {0.5, 0, 0.4 + half - 1e-3}, {0.5, 0.6, 0.4}, {0, 0, 0.4 + R - 1e-3},
                            {0.5, 0, 0.4 + R - 1e-3}, {0.5, 0, 0.4}, {0.5 + half, 0.6, 0.4}, {0.3, 0.6, 0.4 + R - 1e-2},
                            {0.5 + R - 1e-3, 0.6 + R - 1e-3, 0}, {0.2, 0.1, 0.5}};
  for (const auto ends : {Rod::Ends::kFlat, Rod::Ends::kRound}) {
    const Rod rod(R, L, ends);
    ContactWorkspace workspace;
    workspace.reserve(box, rod);
    for (int i = 0; i < 5000; ++i) {
      const Vector3 at = places[i % 10] + 2 * step * Vector3(u(random), u(random), u(random));
      const Vector3 move = step * Vector3(u(random), u(random), u(random));
      const Matrix3 about = turns[(i / 10) % 5] * turn(1e-9 * u(random), Vector3(u(random), u(random), u(random)));
      ContactVolume before, after;
      PairCache cache;
      contactVolume(box, rod, Pose(about, at), cache, workspace, before);
      if (before.status != Status::kOverlap || before.volume < 1e-9) continue;
      contactVolume(box, rod, Pose(about, at + move), cache, workspace, after);
      const double change = after.volume - before.volume, rate = -before.area_vector_A.dot(move);
      // Rounding of the places over the surface, and for faces that meet flush the area that comes and goes at once.
      const double flush = step * L * L;
      EXPECT_NEAR(change, rate, 40 * kEps * L * L + 1e-13 * before.volume + flush) << at.transpose() << "\n" << about << "\n" << i;
      EXPECT_NEAR((after.X_AP.p - before.X_AP.p).norm(), 0, 1e3 * step) << at.transpose() << "\n" << about;
    }
  }
}

/// Poses where geometry degenerates, tangent, flush and aligned to 1e-17: between the prisms inside and around a cylinder, the same
/// with the bodies in the other order, and never nothing where the prism inside has something.
TEST(RodContact, LiesBetweenPrismsInDegeneratePoses) {
  constexpr int kSides = 64;
  const double R = 0.05, L = 0.1;
  const Rod cylinder(R, L, Rod::Ends::kFlat);
  const ConvexPolyhedron inside = makeCylinder(R, L, kSides), around = makeCylinder(R / std::cos(M_PI / kSides), L, kSides);
  ContactWorkspace workspace;
  for (const ConvexPolyhedron& shape : fuzz::shapes()) {
    for (const ConvexShape* other : {static_cast<const ConvexShape*>(&cylinder), static_cast<const ConvexShape*>(&inside),
                                     static_cast<const ConvexShape*>(&around)}) {
      workspace.reserve(shape, *other);
    }
  }
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    std::uint8_t bytes[64];
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    fuzz::ByteSource source(bytes, sizeof bytes);
    const ConvexPolyhedron& shape = fuzz::shapes()[source.byte() % fuzz::shapes().size()];
    Eigen::Vector4d q;
    for (int k = 0; k < 4; ++k) q[k] = source.number();
    if (!(q.norm() > 1e-3)) continue;
    q.normalize();
    const Pose X(Quaternion(q[0], q[1], q[2], q[3]), 0.1 * Vector3(source.number(), source.number(), source.number()));
    ContactVolume ours, swapped, least, most;
    PairCache caches[4];
    contactVolume(shape, cylinder, X, caches[0], workspace, ours);
    contactVolume(cylinder, shape, X.inverse(), caches[1], workspace, swapped);
    contactVolume(shape, inside, X, caches[2], workspace, least);
    contactVolume(shape, around, X, caches[3], workspace, most);
    const double rounding = 6e-15 * 0.16;  // of 0.3 m coordinates over the largest surface here
    EXPECT_STREQ(fuzz::undefinedIn(ours, std::min(shape.volume(), cylinder.volume())), nullptr) << i;
    EXPECT_GE(fuzz::volumeOf(ours), fuzz::volumeOf(least) - rounding) << i;
    EXPECT_LE(fuzz::volumeOf(ours), fuzz::volumeOf(most) + rounding) << i;
    EXPECT_NEAR(fuzz::volumeOf(ours), fuzz::volumeOf(swapped), rounding) << i;
    EXPECT_FALSE(fuzz::volumeOf(ours) == 0 && fuzz::volumeOf(least) > 1e-18) << i;
  }
}

TEST(ShapeDistance, OfRodsIsAProvenBound) {
  const ConvexPolyhedron box = makeBox(Vector3(1, 1, 1));
  const Rod capsule(0.25, 1, Rod::Ends::kRound), cylinder(0.25, 1, Rod::Ends::kFlat);
  ClosestPoints near;
  const Pose lying(turn(M_PI / 2, Vector3::UnitX()), Vector3(0.8, 0, 0.9));
  closestPoints(box, capsule, lying, Vector3::UnitX(), near);  // 0.5 from the edge
  EXPECT_TRUE(near.separated);
  EXPECT_NEAR(near.distance, 0.25, 1e-12);
  EXPECT_NEAR((near.direction - Vector3(0.6, 0, 0.8)).norm(), 0, 1e-7);
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    const Pose X = randomPose(random, 1.2);
    for (const Rod* rod : {&capsule, &cylinder}) {
      closestPoints(box, *rod, X, Vector3::UnitX(), near);
      const Contact c = contactOf(box, *rod, X);
      EXPECT_NE(near.separated, c.volume.status == Status::kOverlap) << X.p.transpose();
      if (!near.separated) continue;
      EXPECT_LE(near.distance, (near.p_B - near.p_A).norm() + 1e-12);
      EXPECT_GT(near.distance, 0.999 * (near.p_B - near.p_A).norm() - 1e-6);
    }
  }
}

/// A ball on a cylinder's side, rim and end, against a fine prism; the area vector is the volume's gradient.
TEST(BallRodContact, IsThatOfAFinePrism) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  const Rod rod(kRadius, kLength, Rod::Ends::kFlat), capsule(kRadius, kLength, Rod::Ends::kRound);
  const ConvexPolyhedron fine = makeCylinder(kRadius, kLength, 720, RoundFit::kEqualVolume);
  int compared = 0;
  for (const double R : {0.1, 0.4, 1.0}) {
    const Ball ball(R);
    for (int i = 0; i < 60; ++i) {
      const Vector3 p((kRadius + R) * u(random), (kRadius + R) * u(random), (0.5 * kLength + R) * u(random));
      const Contact c = contactOf(rod, ball, Pose(p)), f = contactOf(fine, ball, Pose(p));
      const Contact swapped = contactOf(ball, rod, Pose(Vector3(-p)));
      if (c.volume.status != Status::kOverlap || c.volume.volume < 1e-4) continue;
      EXPECT_NEAR(swapped.volume.volume, c.volume.volume, 40 * kEps);
      EXPECT_NEAR(c.volume.volume, f.volume.volume, 3e-8);  // surfaces 3e-6 m apart, alternating in sign
      EXPECT_NEAR((c.volume.X_AP.p - f.volume.X_AP.p).norm(), 0, 1e-7);
      EXPECT_NEAR((c.volume.area_vector_A - f.volume.area_vector_A).norm(), 0, 3e-6);
      if (!(c.volume.area_vector_A.norm() > 1e-3)) continue;  // one within the other
      ++compared;
      EXPECT_NEAR((c.volume.V2 - f.volume.V2).norm(), 0, 1e-6);
      EXPECT_NEAR(c.volume.A0, f.volume.A0, 3e-6);
      EXPECT_NEAR((c.volume.A1 - f.volume.A1).norm(), 0, 1e-6);
      EXPECT_NEAR((c.volume.A2 - f.volume.A2).norm(), 0, 1e-6);
      EXPECT_GE(c.volume.depth, f.volume.depth - 1e-4);
      for (const Rod* one : {&rod, &capsule}) {
        const double step = 1e-4;
        const auto at = [&](const Vector3& way) { return contactOf(*one, ball, Pose(Vector3(p + way))).volume.volume; };
        for (int axis = 0; axis < 3; ++axis) {
          const Vector3 way = step * Vector3::Unit(axis);
          EXPECT_NEAR((at(way) - at(-way)) / (2 * step), -contactOf(*one, ball, Pose(p)).volume.area_vector_A[axis], 3e-5);
        }
      }
    }
  }
  EXPECT_GT(compared, 50);
}

/// A ball that touches a capsule's end is on a ball.
TEST(BallRodContact, OnACapsulesEndIsTwoBalls) {
  const Rod capsule(kRadius, kLength, Rod::Ends::kRound);
  const Ball ball(0.2), end(kRadius);
  const Vector3 way = Vector3(0.3, -0.5, 0.9).normalized();
  for (const double depth : {1e-6, 1e-3, 0.05}) {
    const Vector3 from_end = (kRadius + 0.2 - depth) * way;
    const Contact c = contactOf(capsule, ball, Pose(Vector3(from_end + Vector3(0, 0, 0.5 * kLength))));
    const Contact b = contactOf(end, ball, Pose(from_end));
    const double rounding = 40 * kEps / depth + 1e-9;
    EXPECT_NEAR(c.volume.volume, b.volume.volume, 2 * rounding * b.volume.volume) << depth;
    EXPECT_NEAR((c.volume.normal() - way).norm(), 0, 2 * rounding);
    EXPECT_NEAR(c.volume.A0, b.volume.A0, 2 * rounding * b.volume.A0);
    EXPECT_NEAR((c.volume.V2 - b.volume.V2).norm(), 0, 4 * rounding * b.volume.V2.norm());
  }
}

/// Round shapes against one another: one is its stand-in, and either may come first.
/// The rule for a ball on the tube alone against the ranges' rule: that takes over where the tube ends inside V, here so near its
/// end that what lies beyond is nothing.
TEST(BallRodContact, OnTheTubeIsTheSumOfItsRanges) {
  const double R = 0.3;
  for (const double r : {0.02, 0.5, 3.0}) {
    const Ball ball(r);
    for (const double share : {1e-4, 1e-2, 0.1, 0.3, 0.6}) {
      const double D = R + r - share * std::min(R, r), reach = std::sqrt((r - D + R) * (r + D - R)), length = 2 * reach;
      const Rod longer(R, 4 * length, Rod::Ends::kFlat), shorter(R, length * (1 - 1e-4), Rod::Ends::kFlat);
      const Contact one = contactOf(longer, ball, Pose(Vector3(0.6 * D, 0.8 * D, 0.3 * length)));
      const Contact two = contactOf(shorter, ball, Pose(Vector3(0.6 * D, 0.8 * D, 0)));
      ASSERT_EQ(one.volume.status, Status::kOverlap);
      // Beyond its ends the lens would go on like the power 3/2: a share of 1e-4^(5/2) and its like.
      const double V = two.volume.volume, left = 1e-8;
      EXPECT_NEAR(one.volume.volume, V, left * V) << r << " " << share;
      EXPECT_NEAR((one.volume.V2 - two.volume.V2).norm(), 0, left * two.volume.V2.norm()) << r << " " << share;
      const Vector3 between = one.volume.X_AP.p - two.volume.X_AP.p - Vector3(0, 0, 0.3 * length);
      EXPECT_NEAR(between.norm(), 0, left * reach) << r << " " << share;
      // The arcs like 1/2, of which 1e-4^(3/2) is left.
      EXPECT_NEAR(one.volume.A0, two.volume.A0, 1e-5 * two.volume.A0) << r << " " << share;
      EXPECT_NEAR((one.volume.A2 - two.volume.A2).norm(), 0, 1e-5 * two.volume.A2.norm()) << r << " " << share;
    }
  }
}

/// Half balls on one plane against those that are cut out of a box: a hull with one more face, which crosses the rod above V.
TEST(RodContact, OnOnePlaneIsAsCutOutOfABox) {
  // A ramp: level on top at z = 0, and at its side leaning so that it passes through the rod above.
  const ConvexPolyhedron floor = makeBox(Vector3(40, 40, 10));
  std::vector<Vector3> points;
  for (const double y : {-20.0, 20.0}) points.insert(points.end(), {{0.8, y, 5}, {-20, y, 5}, {-20, y, -5}, {20, y, -5}});
  const ConvexPolyhedron ramp = ConvexPolyhedron::hull(points);
  const Rod capsule(0.5, 1.2, Rod::Ends::kRound);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u(-1, 1);
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const double lean = i % 4 == 0 ? 0 : i % 4 == 1 ? std::pow(10, -16 * std::abs(u(random))) : 1.5 * u(random);
    const Matrix3 R = turn(M_PI / 2 + lean, Vector3::UnitX()) * turn(u(random), Vector3::UnitZ());
    const double depth = 0.5 * std::pow(10, -6 * std::abs(u(random))), lowest = 0.5 + 0.6 * std::abs(R(2, 2));
    const Pose X(R, Vector3(-0.6, 0, 5 + lowest - depth));
    const Contact one = contactOf(floor, capsule, X), two = contactOf(ramp, capsule, X);
    ASSERT_EQ(one.volume.status, Status::kOverlap) << i;
    if (two.volume.status != Status::kOverlap || two.volume.area_vector_A.normalized().z() < 1 - 1e-12) continue;  // over the edge
    ++compared;
    const double rounding = 20 * kEps * (6 / depth);  // of the coordinates, over the depth
    const ContactVolume &a = one.volume, &b = two.volume;
    EXPECT_NEAR(a.volume, b.volume, rounding * b.volume) << i;
    EXPECT_NEAR((a.X_AP.p - b.X_AP.p).norm(), 0, rounding) << i;
    EXPECT_NEAR((a.V2 - b.V2).norm(), 0, rounding * b.V2.norm()) << i;
    EXPECT_NEAR(a.A0, b.A0, rounding * b.A0) << i;
    EXPECT_NEAR((a.A2 - b.A2).norm(), 0, rounding * b.A2.norm()) << i;
    EXPECT_NEAR(a.depth, b.depth, 0.03 * b.depth) << i;  // that over two planes may be larger
  }
  EXPECT_GT(compared, 500);
}

TEST(RodContact, AgainstRoundShapesTakesOneAsAPolyhedron) {
  const Rod capsule(0.1, 0.4, Rod::Ends::kRound), cylinder(0.12, 0.3, Rod::Ends::kFlat);
  const Ball ball(0.15);
  const Pose X(turn(1.2, Vector3(1, 2, 0)), Vector3(0.02, 0.01, 0.18));
  const std::vector<const ConvexShape*> shapes = {&capsule, &cylinder, &ball};
  for (const ConvexShape* A : shapes) {
    for (const ConvexShape* B : shapes) {
      const Contact c = contactOf(*A, *B, X), r = contactOf(*B, *A, X.inverse());
      ASSERT_EQ(c.volume.status, Status::kOverlap);
      EXPECT_NEAR(c.volume.volume, r.volume.volume, 0.02 * c.volume.volume);
      EXPECT_NEAR((X.R.transpose() * c.volume.normal() + r.volume.normal()).norm(), 0, 0.05);
      EXPECT_EQ(contactOf(*A, *B, Pose(X.R, Vector3(0, 0, 1.5))).volume.status, Status::kSeparated);
    }
  }
}

}  // namespace rod_contact_test
}  // namespace haptic
