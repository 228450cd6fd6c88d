#include "scene/sound_shape.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/symmetric_matrix.h"

namespace haptic {
namespace {

constexpr double kFloatSteps = 4.0 / (1 << 23);  // of the largest coordinate: a float's step, and the roundings of what exported it

/// The box along the points' own axes.
struct OwnBox {
  Matrix3 axes;           ///< columns, in the order of `size`
  Vector3 lower, size;    ///< along the axes, shortest first [m]
};

OwnBox ownBoxOf(const std::vector<Vector3>& points) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& p : points) mean += p / points.size();
  Matrix3 spread = Matrix3::Zero();
  for (const Vector3& p : points) spread += (p - mean) * (p - mean).transpose();
  OwnBox box;
  box.axes = principalAxes(spread).axes;
  Vector3 upper = Vector3::Constant(-INFINITY);
  box.lower = -upper;
  for (const Vector3& p : points) {
    const Vector3 along = box.axes.transpose() * p;
    box.lower = box.lower.cwiseMin(along);
    upper = upper.cwiseMax(along);
  }
  box.size = upper - box.lower;
  return box;
}

double reach(const std::vector<Vector3>& points) {
  double largest = 0;
  for (const Vector3& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

double thicknessOf(const OwnBox& box) {
  const double longest = box.size.maxCoeff();
  return longest > 0 ? std::min(kSlabThickness, kSlabShare * longest) : kSlabThickness;
}

std::shared_ptr<const ConvexPolyhedron> boxAround(const OwnBox& box, const std::string& name) {
  const double least = thicknessOf(box);
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    Vector3 along;
    for (int k = 0; k < 3; ++k) {
      const double pad = std::max(0.0, 0.5 * (least - box.size[k]));
      along[k] = i >> k & 1 ? box.lower[k] + box.size[k] + pad : box.lower[k] - pad;
    }
    corners.push_back(box.axes * along);
  }
  return std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(corners, name));
}

std::string sides(const OwnBox& box) {
  std::ostringstream text;
  const Vector3 size = box.size.cwiseMax(thicknessOf(box));
  text << "a box of " << 1e3 * size[2] << " × " << 1e3 * size[1] << " × " << 1e3 * size[0] << " mm";
  return text.str();
}

/// Null: they lie on a line.
std::shared_ptr<const ConvexPolyhedron> slabAround(const std::vector<Vector3>& points, const OwnBox& box, const std::string& name) {
  const Vector3 half = 0.5 * thicknessOf(box) * box.axes.col(0);
  const double middle = box.lower[0] + 0.5 * box.size[0];
  std::vector<Vector3> corners;
  for (const Vector3& p : points) {
    const Vector3 on_plane = p + (middle - box.axes.col(0).dot(p)) * box.axes.col(0);
    corners.push_back(on_plane + half);
    corners.push_back(on_plane - half);
  }
  try {
    return std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(corners, name));
  } catch (const SetupError&) {
    return nullptr;
  }
}

}  // namespace

bool isFlat(const std::vector<Vector3>& points) { return !(ownBoxOf(points).size[0] > kFloatSteps * reach(points)); }

SoundShape soundShapeOf(const std::vector<Vector3>& points, const std::string& name) {
  const OwnBox box = ownBoxOf(points);
  if (!box.size.allFinite()) throw SetupError(name, "its coordinates overflow", "give them in metres");
  const bool line = !(box.size[1] > kFloatSteps * reach(points));
  if (!line && isFlat(points)) {
    std::ostringstream text;
    text << "a slab " << 1e3 * thicknessOf(box) << " mm thick";
    if (const auto slab = slabAround(points, box, name)) return {slab, text.str()};
  }
  if (!line && !isFlat(points)) {
    try {
      return {std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(points, name)), "its hull"};
    } catch (const SetupError&) {  // the box is the last resort
    }
  }
  return {boxAround(box, name), sides(box)};
}

}  // namespace haptic
