/// Random poses and solids, and the contact of a pair with memory of its own.
#pragma once
#include <random>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic::random_pairs {

struct Contact {
  ContactVolume volume;
  ContactWorkspace workspace;
};

inline Contact contactOf(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
  Contact c;
  c.workspace.reserve(A, B);
  PairCache cache;
  contactVolume(A, B, X_AB, cache, c.workspace, c.volume);
  return c;
}

inline Vector3 randomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vector3(normal(random), normal(random), normal(random)).normalized();
}

inline Matrix3 randomTurn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized().toRotationMatrix();
}

/// Each coordinate of the origin within `reach` [m].
inline Pose randomPose(std::mt19937& random, double reach) {
  const Matrix3 R = randomTurn(random);
  std::uniform_real_distribution<double> place(-reach, reach);
  return {R, Vector3(place(random), place(random), place(random))};
}

/// How far S is from being the gradient of V, over |S|: moving B by δ changes V by -S·δ.
inline double gradientError(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB) {
  constexpr double kStep = 1e-6;  // [m]
  const Contact c = contactOf(A, B, X_AB);
  Vector3 error;
  for (int axis = 0; axis < 3; ++axis) {
    const auto volumeAt = [&](double s) { return contactOf(A, B, Pose(X_AB.R, X_AB.p + s * Vector3::Unit(axis))).volume.volume; };
    error[axis] = (volumeAt(kStep) - volumeAt(-kStep)) / (2 * kStep) + c.volume.area_vector_A[axis];
  }
  return error.norm() / c.volume.area_vector_A.norm();
}

/// The hull of so many points of a sphere of radius `size` [m].
inline ConvexPolyhedron stone(int corners, double size, int seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;  // one for all points: it draws them in pairs
  std::vector<Vector3> points;
  for (int i = 0; i < corners; ++i) points.push_back(size * Vector3(normal(random), normal(random), normal(random)).normalized());
  return ConvexPolyhedron::hull(points);
}

}  // namespace haptic::random_pairs
