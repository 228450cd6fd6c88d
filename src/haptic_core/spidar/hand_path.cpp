#include "haptic_core/spidar/hand_path.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace {

GripPose poseOf(const Vector3& p, const Vector3& rotation, double opening) {
  GripPose x;
  x.X_BG = Pose(rotationFromVector(rotation), p);
  x.opening = opening;
  return x;
}

/// Millimetres and degrees per key, for tables that can be read.
HandKey key(double time, double x, double y, double z, double rx = 0, double ry = 0, double rz = 0) {
  constexpr double kDegree = M_PI / 180;
  return {time, Vector3(x, y, z) * 1e-3, Vector3(rx, ry, rz) * kDegree, 0};
}

/// Press down, slide forward and back, rise, come from behind and push forward; 10 s. A relaxed hand presses with some
/// 3 N on a surface 8 mm below home: less than any of the devices presents.
std::vector<HandKey> touchCube(double start) {
  return {key(start + 0.5, 0, 0, 0),   key(start + 1.5, 0, 0, -12),   key(start + 2.5, 0, 0, -14, 0, 3, 0),
          key(start + 3.5, 8, 0, -14), key(start + 4.5, -8, 4, -13),  key(start + 5.3, -12, 0, 5),
          key(start + 6.3, -28, 0, 0), key(start + 7.0, -28, 0, -24), key(start + 8.2, 0, 0, -24, 0, 0, 8),
          key(start + 8.6, -12, 0, -20), key(start + 9.2, -12, 0, 4), key(start + 10, 0, 0, 0)};
}

/// 20 s of sines of seven incommensurate periods, ±30 mm and ±0.4 rad, sampled at 20 Hz.
std::vector<HandKey> wave() {
  std::vector<HandKey> keys;
  for (int i = 0; i <= 400; ++i) {
    const double t = 0.05 * i, envelope = std::min(1.0, std::min(t, 20 - t));
    const auto sine = [&](double hz) { return envelope * elementary::sin(2 * M_PI * hz * t); };
    keys.push_back({t, 0.03 * Vector3(sine(0.31), sine(0.43), sine(0.23)),
                    0.4 * Vector3(sine(0.37), sine(0.29), sine(0.53)), 0.005 * sine(0.47)});
  }
  return keys;
}

}  // namespace

GripPose HandPath::at(double time) const noexcept {
  if (keys.empty()) return {};
  const auto after =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const HandKey& k) { return t < k.time; });
  if (after == keys.begin()) return poseOf(keys.front().p_BG, keys.front().rotation, keys.front().opening);
  if (after == keys.end()) return poseOf(keys.back().p_BG, keys.back().rotation, keys.back().opening);
  const HandKey &a = *(after - 1), &b = *after;
  const double s = (time - a.time) / (b.time - a.time);
  const double blend = s * s * s * (10 + s * (-15 + 6 * s));
  return poseOf(a.p_BG + blend * (b.p_BG - a.p_BG), a.rotation + blend * (b.rotation - a.rotation),
                a.opening + blend * (b.opening - a.opening));
}

HandPath handPath(const std::string& name) {
  if (name == "rest") return {};
  if (name == "press") return {{key(0.5, 0, 0, 0), key(1.5, 0, 0, -26)}};
  if (name == "wave") return {wave()};
  if (name == "touch_cube") {
    HandPath path;
    for (int round = 0; round < 6; ++round)
      for (const HandKey& k : touchCube(10.0 * round)) path.keys.push_back(k);
    return path;
  }
  throw SetupError("hand path '" + name + "'", "is unknown", "choose rest, press, touch_cube or wave");
}

}  // namespace haptic
