#include "haptic_core/analysis/flat_wall.h"

#include <algorithm>

#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/world/held_proxy.h"

namespace haptic {

FlatWall::FlatWall(const ConvexShape& shape, const Vector3& outward)
    : shape_(shape), wall_(makeBox(Vector3::Constant(8 * shape.boundingRadius()))) {
  workspace_.reserve(wall_, shape);
  X_WS_.R = shortestTurn(outward, -Vector3::UnitZ()).toRotationMatrix();
  X_WS_.p = -(X_WS_.R * shape.centre());
  lowest_ = -supportHeight(shape, X_WS_, -Vector3::UnitZ());
  middle_ = 0.5 * (supportHeight(shape, X_WS_, Vector3::UnitZ()) - lowest_);
}

double FlatWall::volume(double depth) { return depth > 0 ? contactAt(depth).volume : 0; }

double FlatWall::stiffness(double k, double force) {
  double low = 0, high = middle_;
  for (int i = 0; i < kHalvings; ++i) {
    const double depth = 0.5 * (low + high);
    (k * contactAt(depth).volume < force ? low : high) = depth;
  }
  return k * contactAt(high).A0;
}

double FlatWall::carried(double k, double bound) {
  const double height = 2 * middle_;
  const ContactVolume sunk = contactAt(mostSunk(bound, k, shape_.volume(), height) * height);
  return k * sunk.volume * std::min(1.0, bound / (k * sunk.A0));
}

ContactVolume FlatWall::contactAt(double depth) {
  Pose X = X_WS_;
  X.p.z() += wall_.halfSize().z() - depth - lowest_;
  ContactVolume volume;
  PairCache cache;
  contactVolume(wall_, shape_, X, cache, workspace_, volume);
  return volume;
}

}  // namespace haptic
