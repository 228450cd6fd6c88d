/// What holds for the contact of any two bodies, whatever their shape and pose.
#include <gtest/gtest.h>

#include <random>

#include "contact_fuzz.h"
#include "dual_volume.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "hard_cases.h"

namespace haptic {
namespace contact_properties_test {

using Status = ContactVolume::Status;

/// Position error of a volume: its error over the area it acts on. Roundings of 0.1 m coordinates.
constexpr double kPosition = 2e-15;
/// Largest surface of the bodies below [m²].
constexpr double kSurface = 0.06;

struct ContactProperties : testing::Test {
  ContactProperties() {
    std::vector<Vector3> points;
    for (int i = 0; i < 40; ++i) points.push_back(0.05 * direction());
    shapes = {makeBox(Vector3(0.1, 0.1, 0.1)), ConvexPolyhedron::hull(points), makeCylinder(0.04, 0.1, 12),
              makeBox(Vector3(0.1, 0.08, 0.06))};
    for (const auto& a : shapes)
      for (const auto& b : shapes) workspace.reserve(a, b);
  }
  Vector3 direction() { return Vector3(normal(random), normal(random), normal(random)).normalized(); }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  Pose pose(double farthest) {
    const Quaternion q(normal(random), normal(random), normal(random), normal(random));
    return Pose(q.normalized(), uniform(0, farthest) * direction());
  }
  ContactVolume contact(const ConvexPolyhedron& a, const ConvexPolyhedron& b, const Pose& X_AB) {
    PairCache cache;
    ContactVolume v;
    contactVolume(a, b, X_AB, cache, workspace, v);
    return v;
  }
  static double volumeOf(const ContactVolume& v) { return v.status == Status::kOverlap ? v.volume : 0; }

  std::mt19937 random{11};
  std::normal_distribution<double> normal;
  std::vector<ConvexPolyhedron> shapes;
  ContactWorkspace workspace;
};

/// A box, a hull, a cylinder and a capsule, level, overhang the edge of a table in any pose: the depth is the one below the table's top.
TEST(OverhangDepth, IsMeasuredFromTheSupportingFace) {
  std::mt19937 random(12);
  std::normal_distribution<double> normal;
  const ConvexPolyhedron table = makeBox(Vector3(1, 1, 0.2)), cube = makeBox(Vector3(0.1, 0.1, 0.1)), prism = makeCylinder(0.05, 0.1, 12);
  const Rod puck(0.05, 0.1, Rod::Ends::kFlat), lying(0.05, 0.1, Rod::Ends::kFlat), capsule(0.05, 0.1, Rod::Ends::kRound);
  const Ball ball(0.05);
  const Matrix3 level = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()).toRotationMatrix();
  struct Case {
    const ConvexShape* shape;
    Matrix3 R;
    double most;  // the shape's middle may lie so far beyond the edge
  };
  for (const Case& c : {Case{&cube, Matrix3::Identity(), 0.01}, Case{&prism, Matrix3::Identity(), 0.01},
                        Case{&puck, Matrix3::Identity(), 0.01}, Case{&lying, level, 0.01}, Case{&capsule, level, 0.01},
                        Case{&ball, Matrix3::Identity(), 0}}) {
    for (const double depth : {1e-6, 1e-4, 1e-2}) {
      for (const double over : {-0.004, 0.0, 0.01}) {
        if (over > c.most) continue;
        const Pose X_TS(c.R, Vector3(0.5 + over, 0.1, 0.15 - depth));
        const Pose X_WT(Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized(), Vector3(0.2, -0.1, 0.3));
        for (const bool table_first : {true, false}) {
          ContactWorkspace workspace;
          workspace.reserve(table, *c.shape);
          PairCache cache;
          ContactVolume v;
          const Pose X_WS = X_WT * X_TS;
          if (table_first)
            contactVolume(table, *c.shape, relativePose(X_WT, X_WS), cache, workspace, v);
          else
            contactVolume(*c.shape, table, relativePose(X_WS, X_WT), cache, workspace, v);
          ASSERT_EQ(v.status, Status::kOverlap);
          EXPECT_NEAR(v.depth, depth, 2 * kPosition) << depth << " " << over << " " << c.shape->name();
        }
      }
    }
  }
}

TEST_F(ContactProperties, VolumeIsThatOfTheSeedsDualTransform) {
  int compared = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto &a = shapes[i % 4], &b = shapes[i / 4 % 4];
    const Pose X = pose(0.09);
    const ContactVolume v = contact(a, b, X);
    if (v.status != Status::kOverlap || v.depth < 1e-3) continue;
    // The dual points lie 1/distance away, distance of the centroid from the nearest face of V: roundings of
    // 1e-16 grow to 1e-16 m / distance, and again so in the vertices.
    EXPECT_NEAR(oracle::qhullDualVolume(a, b, X, v.X_AP.p), v.volume, 1e-9 * v.volume);
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

TEST_F(ContactProperties, DoNotChangeUnderRigidMotion) {
  for (int i = 0; i < 500; ++i) {
    const auto &a = shapes[i % 4], &b = shapes[i / 4 % 4];
    const Pose X = pose(0.1), X_WA = pose(0.2), X_WB = X_WA * X;
    const ContactVolume v = contact(a, b, X), w = contact(a, b, relativePose(X_WA, X_WB));
    ASSERT_EQ(v.status, w.status);
    EXPECT_NEAR(volumeOf(v), volumeOf(w), 2 * kPosition * kSurface);
    if (v.status != Status::kOverlap) continue;
    EXPECT_NEAR((v.area_vector_A - w.area_vector_A).norm(), 0, 2 * kPosition);
  }
}

/// Turning a cube onto itself relabels its faces and vertices and moves nothing.
TEST_F(ContactProperties, AreBlindToTheTwentyFourRotationsOfACube) {
  const ConvexPolyhedron& cube = shapes[0];
  for (int i = 0; i < 20; ++i) {
    const Pose X = i < 5 ? Pose(Vector3(0.01 * i, -0.02, 0.1 - 1e-3)) : pose(0.1);
    for (const ConvexPolyhedron& other : shapes) {
      const ContactVolume first = contact(cube, other, X), second = contact(other, cube, X);
      for (const Matrix3& turn : oracle::cubeRotations()) {
        const ContactVolume as_a = contact(cube, other, Pose(turn.transpose() * X.R, turn.transpose() * X.p));
        const ContactVolume as_b = contact(other, cube, Pose(X.R * turn, X.p));
        ASSERT_EQ(as_a.status, first.status);
        ASSERT_EQ(as_b.status, second.status);
        EXPECT_NEAR(volumeOf(as_a), volumeOf(first), kPosition * kSurface);
        EXPECT_NEAR(volumeOf(as_b), volumeOf(second), kPosition * kSurface);
        EXPECT_NEAR((turn * as_a.area_vector_A - first.area_vector_A).norm(), 0, kPosition);
        EXPECT_NEAR((as_b.area_vector_A - second.area_vector_A).norm(), 0, kPosition);
      }
    }
  }
}

TEST_F(ContactProperties, GradientOfTheVolumeIsTheAreaVector) {
  const double step = 1e-7;
  int overlapping = 0;
  for (int i = 0; i < 400; ++i) {
    const auto &a = shapes[i % 4], &b = shapes[i / 4 % 4];
    const Pose X = pose(0.1);
    const ContactVolume v = contact(a, b, X);
    if (v.status != Status::kOverlap) continue;
    ++overlapping;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 d = step * Vector3::Unit(axis);
      const double rate =
          (volumeOf(contact(a, b, Pose(X.R, X.p + d))) - volumeOf(contact(a, b, Pose(X.R, X.p - d)))) /
          (2 * step);
      // S changes at most at the length of the seam, below 1 m, times the step; plus roundings over the step.
      EXPECT_NEAR(rate, -v.area_vector_A[axis], step * 1.0 + kPosition * kSurface / step);
    }
  }
  EXPECT_GT(overlapping, 200);
}

/// V as a polyhedron: closed, its faces marked by owner, its volume and area vector those reported.
TEST_F(ContactProperties, FacesOfVCloseAndCarryTheirOwner) {
  int overlapping = 0;
  for (int i = 0; i < 400; ++i) {
    const auto &a = shapes[i % 4], &b = shapes[i / 4 % 4];
    const Pose X = pose(0.1);
    const ContactVolume v = contact(a, b, X);
    if (v.status != Status::kOverlap) continue;
    ++overlapping;
    workspace.buildLoops();
    Vector3 S_A = Vector3::Zero(), S_B = Vector3::Zero();
    double volume = 0;
    for (int l = 0; l < static_cast<int>(workspace.loops().size()); ++l) {
      const ContactLoop& loop = workspace.loops()[l];
      const ContactFace& face = workspace.faces()[loop.face];
      const bool of_a = face.owner == Owner::kA;
      const Vector3 n = of_a ? a.faces()[face.index].normal : Vector3(X.R * b.faces()[face.index].normal);
      EXPECT_NEAR(n.dot(face.normal), 1, 1e-14);  // rotations of unit length to rounding
      const auto corner = [&](int k) -> const Vector3& {
        return workspace.vertices()[workspace.loopVertices()[loop.first + k]];
      };
      for (int k = 1; k + 1 < loop.count; ++k) {
        const Vector3 area = 0.5 * (corner(k) - corner(0)).cross(corner(k + 1) - corner(0));
        (of_a ? S_A : S_B) += area;
        volume += area.dot(corner(0) - v.X_AP.p) / 3;
      }
    }
    EXPECT_NEAR((S_A + S_B).norm(), 0, kPosition);
    EXPECT_NEAR((S_A - v.area_vector_A).norm(), 0, kPosition);
    EXPECT_NEAR(volume, v.volume, kPosition * kSurface);
  }
  EXPECT_GT(overlapping, 200);
}

/// The force V·n (per unit stiffness) along a path changes no faster than geometry allows: V by the area
/// swept, n by the change of S, which is at most the seam's length times the displacement. A jump anywhere
/// fails.
TEST_F(ContactProperties, ForceIsContinuousAlongRandomPaths) {
  const int steps = 4000;
  int checked = 0, touches = 0;
  for (int path = 0; path < 24; ++path) {
    const auto &a = shapes[path % 4], &b = shapes[path / 4 % 4];
    const Vector3 from = 0.17 * direction(), to = -0.17 * direction() + 0.05 * direction();
    const Matrix3 R = pose(0).R;
    const Vector3 axis = direction();
    PairCache cache;
    ContactVolume last;
    Vector3 last_force = Vector3::Zero();
    for (int i = 0; i <= steps; ++i) {
      const double s = static_cast<double>(i) / steps;
      const Pose X(Eigen::AngleAxisd(2 * s, axis).toRotationMatrix() * R, from + s * (to - from));
      ContactVolume v;
      contactVolume(a, b, X, cache, workspace, v);
      const Vector3 force = volumeOf(v) * v.normal();
      const bool overlap = v.status == Status::kOverlap;
      const bool by_history = (v.flags | last.flags) & ContactVolume::kNormalFromHistory;
      // No point of B moves farther in a step: its centre, and 0.1 m at 2 rad a path.
      const double moved = (to - from).norm() / steps + 0.1 * 2.0 / steps;
      const double slenderness = overlap ? v.volume / v.area_vector_A.norm() : 0;
      if (i > 0 && !by_history && slenderness < 0.05) {
        ++checked;
        touches += overlap != (last.status == Status::kOverlap);
        const double seam = 1.0;  // longer than any seam of these bodies [m]
        EXPECT_LE((force - last_force).norm(), moved * (kSurface / 2 + 2 * slenderness * seam))
            << "path " << path;
      }
      last = v;
      last_force = force;
    }
  }
  EXPECT_GT(checked, 20000);
  EXPECT_GT(touches, 20);
}

/// The fuzz target on random bytes; test/fuzz runs it coverage-guided.
TEST_F(ContactProperties, HoldForAnyBytes) {
  std::uint8_t bytes[40];
  for (int i = 0; i < 20000; ++i) {
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 24);
    const char* violated = fuzz::contactViolation(bytes, sizeof bytes);
    ASSERT_EQ(violated, nullptr) << violated << " at input " << i;
  }
}

}  // namespace contact_properties_test
}  // namespace haptic
