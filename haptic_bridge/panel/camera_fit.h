/// The camera that holds some points and nothing more.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// Of a camera that orbits a focus, as rviz has it: yaw about z and pitch above the horizon of the direction towards the camera.
struct CameraFit {
  double yaw = 0, pitch = 0;        ///< [rad]
  double distance = 1;              ///< from the focus [m]
  Vector3 focus = Vector3::Zero();  ///< in W [m]

  Vector3 back() const { return {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch)}; }
  Vector3 right() const { return {-std::sin(yaw), std::cos(yaw), 0}; }
  Vector3 up() const { return back().cross(right()); }
  /// Tangents of the angles to the right of and above the camera's axis at which it sees a point.
  Eigen::Vector2d seen(const Vector3& p_W) const {
    const Vector3 p = p_W - focus;
    const double depth = distance - p.dot(back());
    return {p.dot(right()) / depth, p.dot(up()) / depth};
  }
};

/// `half_height`: tangent of half the vertical field of view; `aspect`: width over height of the picture. The focus is shifted until the
/// points leave as much free at the left as at the right, and above as below.
inline CameraFit fitCamera(const std::vector<Vector3>& points, double yaw, double pitch, double half_height, double aspect) {
  constexpr double kMargin = 1.1;  // of the distance: nothing touches the window's edge
  constexpr int kRounds = 20;      // the shift shrinks at least by half in each
  CameraFit camera;
  camera.yaw = yaw, camera.pitch = pitch;
  if (points.empty()) return camera;
  Vector3 low = points[0], high = points[0];
  for (const Vector3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  camera.focus = (low + high) / 2;
  for (int round = 0; round < kRounds; ++round) {
    double distance = 1e-3;
    for (const Vector3& point : points) {
      const Vector3 p = point - camera.focus;
      const double x = std::fabs(p.dot(camera.right())) / (half_height * aspect), y = std::fabs(p.dot(camera.up())) / half_height;
      distance = std::max(distance, std::max(x, y) + p.dot(camera.back()));
    }
    camera.distance = distance;
    Eigen::Vector2d least = camera.seen(points[0]), most = least;
    for (const Vector3& point : points) least = least.cwiseMin(camera.seen(point)), most = most.cwiseMax(camera.seen(point));
    const Eigen::Vector2d middle = distance * (least + most) / 2;
    camera.focus += middle.x() * camera.right() + middle.y() * camera.up();
  }
  camera.distance *= kMargin;
  return camera;
}

}  // namespace haptic
