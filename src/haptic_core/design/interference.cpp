#include "haptic_core/design/interference.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "haptic_core/spidar/device_check.h"

namespace haptic {
namespace {

constexpr double kOnePoint = 1e-4;  // exits or knots nearer than this are one [m]
constexpr int kDivisions = 20000;   // of cells for one pair

Vector3 knotOf(const DeviceDef& def, int i) { return def.dof == 3 ? Vector3(Vector3::Zero()) : def.strings[i].p_GK; }

/// Most that the distance changes between the centre of the cell and any pose in it.
double change(const DeviceDef& def, const PoseCell& cell, int first, int second) {
  const double phi = cell.half.tail<3>().norm(), shift = cell.half.head<3>().norm(), lever = knotOf(def, first).norm();
  if (second >= 0) return shift + phi * (lever + knotOf(def, second).norm());
  const Vector3 v = def.strings[first].p_BE - cell.pose().X_BG * knotOf(def, first);
  const double s = shift + lever * phi, room = v.norm() - s;
  return room > 0 ? lever * (s / room + phi) : lever * 2;
}

struct Bounded {
  double bound;
  PoseCell cell;
  bool operator<(const Bounded& o) const { return bound > o.bound; }  // a queue's top is its greatest
};

Nearest nearest(const DeviceDef& def, const std::vector<PoseCell>& cells, int first, int second, double tolerance) {
  Nearest n;
  n.first = first;
  n.second = second;
  n.found = 1e9;
  std::vector<Bounded> all;
  const auto look = [&](const PoseCell& cell) {
    const double value = stringDistance(def, cell.centre, first, second);
    if (value < n.found) {
      n.found = value;
      n.at = cell.centre;
    }
    return value - change(def, cell, first, second);
  };
  for (const PoseCell& cell : cells) all.push_back({look(cell), cell});
  std::priority_queue<Bounded> queue(std::less<Bounded>(), std::move(all));
  for (int i = 0; i < kDivisions && n.found - queue.top().bound > tolerance; ++i) {
    PoseCell part = queue.top().cell;
    queue.pop();
    int j = 0;
    Vector6 weight;
    weight << Vector3::Ones(), Vector3::Constant(std::max(1e-3, knotOf(def, first).norm()));
    part.half.cwiseProduct(weight).maxCoeff(&j);
    part.half[j] *= 0.5;
    const double centre = part.centre[j];
    for (const double sign : {-1.0, 1.0}) {
      part.centre[j] = centre + sign * part.half[j];
      queue.push({look(part), part});
    }
  }
  n.at_least = std::min(n.found, queue.top().bound);
  return n;
}

}  // namespace

double stringDistance(const DeviceDef& def, const Vector6& at, int first, int second) {
  const GripPose x = PoseCell{}.pose(at);
  const Vector3 arm = x.X_BG.R * knotOf(def, first), knot = x.X_BG.p + arm;
  if (second < 0) return (def.strings[first].p_BE - knot).normalized().dot(arm);
  return segmentDistance(def.strings[first].p_BE, knot, def.strings[second].p_BE, x.X_BG * knotOf(def, second));
}

std::vector<Nearest> nearestOver(const DeviceDef& def, const std::vector<PoseCell>& cells, double tolerance) {
  std::vector<Nearest> found;
  if (cells.empty()) return found;
  for (int a = 0; a < static_cast<int>(def.strings.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(def.strings.size()); ++b)
      if ((def.strings[a].p_BE - def.strings[b].p_BE).norm() > kOnePoint && (knotOf(def, a) - knotOf(def, b)).norm() > kOnePoint)
        found.push_back(nearest(def, cells, a, b, tolerance));
    if (knotOf(def, a).norm() > kOnePoint) found.push_back(nearest(def, cells, a, -1, tolerance));
  }
  std::sort(found.begin(), found.end(), [](const Nearest& a, const Nearest& b) { return a.at_least < b.at_least; });
  return found;
}

}  // namespace haptic
