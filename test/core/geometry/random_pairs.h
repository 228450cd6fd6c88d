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

/// The hull of so many points of a sphere of radius `size` [m].
inline ConvexPolyhedron stone(int corners, double size, int seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;  // one for all points: it draws them in pairs
  std::vector<Vector3> points;
  for (int i = 0; i < corners; ++i) points.push_back(size * Vector3(normal(random), normal(random), normal(random)).normalized());
  return ConvexPolyhedron::hull(points);
}

}  // namespace haptic::random_pairs
