/// Pairs of shapes for the benchmark of contacts: boxes of 0.1 m, hulls of 100 points on a sphere of 5 cm.
#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"

namespace haptic::bench {

struct Pair {
  const ConvexPolyhedron *a, *b;
  Pose X_AB;
  PairCache cache;
  Vector3 interior = Vector3::Zero();
};

class Scenes {
 public:
  explicit Scenes(unsigned seed) : random_(seed), box_(makeBox(Vector3(0.1, 0.1, 0.1))) {
    for (int h = 0; h < 16; ++h) {
      std::vector<Vector3> points;
      for (int i = 0; i < 100; ++i) points.push_back(0.05 * direction());
      hulls_.push_back(ConvexPolyhedron::hull(points));
    }
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3 direction() { return Vector3(normal_(random_), normal_(random_), normal_(random_)).normalized(); }
  Matrix3 rotation() {
    return Quaternion(normal_(random_), normal_(random_), normal_(random_), normal_(random_))
        .normalized()
        .toRotationMatrix();
  }

  std::vector<Pair> boxes(double yaw, double depth) {
    std::vector<Pair> pairs;
    const Matrix3 R = Eigen::AngleAxisd(yaw, Vector3::UnitZ()).toRotationMatrix();
    for (int i = 0; i < 8; ++i)
      pairs.push_back(
          {&box_, &box_, Pose(R, Vector3(uniform(-5e-3, 5e-3), uniform(-5e-3, 5e-3), 0.1 - depth)), {}, {}});
    return pairs;
  }

  /// B pushed along a random direction until `depth` beyond first contact with A's lowest support plane.
  Pair at(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double depth) {
    const Vector3 u = direction();
    Pose X(rotation(), Vector3::Zero());
    const double top = u.dot(a.vertices()[a.support(u)]);
    const double bottom = u.dot(X.R * b.vertices()[b.support(-(X.R.transpose() * u))]);
    X.p = (top - bottom - depth) * u;
    return {&a, &b, X, {}, {}};
  }
  /// The vertices farthest towards each other brought together, `depth` past one another along a random
  /// direction, and in half of the cases moved aside: nearly always an overlap, down to any depth.
  Pair interlocked(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double depth) {
    const Vector3 u = direction();
    Pose X(rotation(), Vector3::Zero());
    const Vector3 top = a.vertices()[a.support(u)], bottom = b.vertices()[b.support(-(X.R.transpose() * u))];
    const Vector3 aside =
        uniform(0, 1) < 0.5 ? Vector3(uniform(0, 0.05) * u.cross(direction())) : Vector3::Zero();
    X.p = top - X.R * bottom - depth * u + aside;
    return {&a, &b, X, {}, {}};
  }
  std::vector<Pair> hulls(double depth) {
    std::vector<Pair> pairs;
    for (int i = 0; i < 256; ++i) pairs.push_back(at(hulls_[i % 16], hulls_[(i + 1 + i / 16) % 16], depth));
    return pairs;
  }
  std::vector<Pair> deepHulls() {
    std::vector<Pair> pairs;
    for (int i = 0; i < 256; ++i) {
      Pair pair{&hulls_[i % 16], &hulls_[(i + 1 + i / 16) % 16], Pose(rotation(), Vector3::Zero()), {}, {}};
      pair.X_AB.p = uniform(0, 0.5) * 0.1 * direction();
      pairs.push_back(pair);
    }
    return pairs;
  }
  const ConvexPolyhedron& box() const { return box_; }
  const ConvexPolyhedron& hull(int i) const { return hulls_[i % 16]; }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  ConvexPolyhedron box_;
  std::vector<ConvexPolyhedron> hulls_;
};

}  // namespace haptic::bench
