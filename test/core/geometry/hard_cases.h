/// Contacts that break algorithms: exactly aligned, coplanar, nearly parallel, thin, tiny, huge, contained.
#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "exact_volume.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic::oracle {

/// The rotations that map a cube to itself, entries exactly 0 and ±1.
inline std::vector<Matrix3> cubeRotations() {
  std::vector<Matrix3> rotations;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int signs = 0; signs < 4; ++signs) {
        if (x == y) continue;
        Matrix3 R = Matrix3::Zero();
        R(x, 0) = signs & 1 ? 1 : -1;
        R(y, 1) = signs & 2 ? 1 : -1;
        R.col(2) = R.col(0).cross(R.col(1));
        rotations.push_back(R);
      }
  return rotations;
}

struct HardCase {
  const ConvexPolyhedron *a, *b;
  Pose X_AB;
  const char* kind;
};

/// Shapes and poses; about 5000 cases per round, another set for every seed.
class HardCases {
 public:
  explicit HardCases(unsigned seed) : random_(seed) {
    const auto box = [](double x, double y, double z) { return makeBox(Vector3(x, y, z)); };
    shapes_ = {box(0.1, 0.1, 0.1),
               box(0.1, 0.1, 0.1),
               box(0.2, 0.2, 0.1),
               box(0.1, 0.1, 5e-4),
               box(0.001, 0.001, 0.1),
               box(1e-5, 0.1, 0.1),
               box(1e-6, 1e-6, 1e-6),
               box(100, 100, 100),
               makeCylinder(0.05, 0.1, 16),
               makeSphere(0.05, 1),
               ConvexPolyhedron({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}},
                                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})};
  }

  template <class Visit>
  void each(Visit&& visit) {
    const std::vector<Matrix3> rotations = cubeRotations();
    for (const auto& a : shapes_)
      for (const auto& b : shapes_)
        for (const double depth : {1e-12, 1e-9, 1e-6, 1e-3, 0.3}) {
          const Matrix3& turn = rotations[random_() % rotations.size()];
          const double size = std::min(height(a, Matrix3::Identity()), height(b, turn));
          const double sink = depth == 0.3 ? 0.3 * size : std::min(depth * 10 * size, 0.5 * size);
          const Vector3 on_top(0, 0, top(a, Matrix3::Identity()) - bottom(b, turn) - sink);
          visit({&a, &b, Pose(turn, on_top), "faces aligned, centred"});
          const Vector3 flush((upper(a, Matrix3::Identity(), 0) - upper(b, turn, 0)), 0, on_top.z());
          visit({&a, &b, Pose(turn, flush), "faces aligned, sides coplanar"});
          visit({&a, &b, Pose(turn, on_top + Vector3(0.3 * size, -0.2 * size, 0)), "faces aligned, shifted"});
          const double tilt = std::pow(10.0, -3 - 12 * uniform());
          const Matrix3 tilted = Eigen::AngleAxisd(tilt, axis()).toRotationMatrix() * turn;
          visit({&a, &b, Pose(tilted, on_top + Vector3(0.1 * size, 0, 0)), "nearly parallel"});
          const Matrix3 edge = Eigen::AngleAxisd(M_PI / 4, Vector3::UnitX()).toRotationMatrix();
          visit({&a, &b, Pose(edge, Vector3(0, 0, top(a, Matrix3::Identity()) - bottom(b, edge) - sink)),
                 "edge on face"});
          const Matrix3 corner =
              shortestTurn(Vector3::Ones().normalized(), -Vector3::UnitZ()).toRotationMatrix();
          visit({&a, &b, Pose(corner, Vector3(0, 0, top(a, Matrix3::Identity()) - bottom(b, corner) - sink)),
                 "vertex on face"});
        }
    for (const auto& a : shapes_) {
      visit({&a, &a, Pose(), "coincident"});
      for (const Matrix3& turn : rotations)
        visit({&a, &shapes_[0], Pose(turn, Vector3::Zero()), "concentric"});
      visit({&a, &shapes_[7], Pose(), "contained"});
    }
    for (int i = 0; i < 200; ++i) {
      const Matrix3 R = Eigen::AngleAxisd(0.7 * uniform(), axis()).toRotationMatrix();
      visit({&shapes_[3], &shapes_[4], Pose(R, 0.01 * axis()), "rod through plate"});
      visit({&shapes_[4], &shapes_[4],
             Pose(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()).toRotationMatrix() * R, 2e-4 * axis()),
             "crossing bars"});
    }
  }

  /// Error that roundings of the coordinates may cause: c·area, c = 2e-15 m per 0.1 m of coordinates, and the
  /// area that of the smaller body's surroundings.
  static double allowedError(const HardCase& c) {
    const double ra = c.a->boundingRadius() + c.a->centre().norm(),
                 rb = c.b->boundingRadius() + c.b->centre().norm();
    const double coordinates = std::min(ra, rb) + c.X_AB.p.norm(), reach = std::min(ra, rb);
    return 2e-15 * coordinates / 0.1 * 4 * reach * reach;
  }

 private:
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  Vector3 axis() {
    std::normal_distribution<double> normal;
    return Vector3(normal(random_), normal(random_), normal(random_)).normalized();
  }
  static double upper(const ConvexPolyhedron& s, const Matrix3& R, int axis) {
    double value = -INFINITY;
    for (const Vector3& v : s.vertices()) value = std::max(value, R.row(axis).dot(v));
    return value;
  }
  static double top(const ConvexPolyhedron& s, const Matrix3& R) { return upper(s, R, 2); }
  static double bottom(const ConvexPolyhedron& s, const Matrix3& R) { return -upper(s, -R, 2); }
  static double height(const ConvexPolyhedron& s, const Matrix3& R) { return top(s, R) - bottom(s, R); }

  std::mt19937 random_;
  std::vector<ConvexPolyhedron> shapes_;
};

struct Verdict {
  double exact = 0, error = 0, allowed = 0;
  bool false_empty = false, wrong = false, failed = false;
};

/// Compares a result with the exact volume.
inline Verdict judge(const HardCase& c, const ContactVolume& v) {
  Verdict verdict;
  // Coincident bodies: every face on its twin, where no finite precision can cut; the volume is the body's
  // own.
  const bool coincident = c.a == c.b && c.X_AB.R == Matrix3::Identity() && c.X_AB.p.isZero(0);
  verdict.exact = coincident
                      ? c.a->volume()
                      : static_cast<double>(PolygonVolume<__float128>::volume(*c.a, *c.b, Pose(), c.X_AB));
  verdict.allowed = HardCases::allowedError(c);
  const bool overlap = v.status == ContactVolume::Status::kOverlap;
  verdict.error = (overlap ? v.volume : 0.0) - verdict.exact;
  verdict.false_empty = !overlap && verdict.exact > verdict.allowed;
  verdict.wrong = std::abs(verdict.error) > verdict.allowed;
  const bool defined =
      v.status == ContactVolume::Status::kSeparated ||
      (v.X_AP.p.allFinite() && v.X_AP.R.allFinite() && std::isfinite(v.volume) && v.A2.allFinite() &&
       v.V2.allFinite() && std::abs(v.normal().norm() - 1) < 1e-9 && v.volume >= 0);
  verdict.failed = !defined || (v.flags & ContactVolume::kCapacityExceeded);
  return verdict;
}

}  // namespace haptic::oracle
