// Oracles: closed forms, and points sampled on both strings at random poses of the cells.
#include "haptic_core/design/interference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptic {
namespace interference_test {

DeviceDef device(const std::string& name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

// Two strings of a cross, along x at z = 0 and along y at z = 4 mm.
TEST(Interference, TwoStringsOfACross) {
  DeviceDef def = device("spidar_g6x3r");
  def.strings.resize(2);
  def.strings[0].p_BE = {0.1, 0, 0};
  def.strings[0].p_GK = {-0.02, 0, 0};
  def.strings[1].p_BE = {0, 0.1, 0.004};
  def.strings[1].p_GK = {0, -0.02, 0.004};
  EXPECT_NEAR(stringDistance(def, Vector6::Zero(), 0, 1), 0.004, 1e-15);
  EXPECT_NEAR(stringDistance(def, Vector6::Zero(), 0, -1), -0.02, 1e-15) << "the string runs through the grip";
  PoseCell cell;
  cell.half.head<3>().setConstant(0.001);
  const std::vector<Nearest> found = nearestOver(def, {cell}, 2e-4);
  for (const Nearest& n : found)
    if (n.second == 1) {
      EXPECT_LE(n.found - n.at_least, 2e-4);
      EXPECT_GT(n.at_least, 0.0015);
      EXPECT_LT(n.found, 0.004);
    }
}

/// Compares one pair's bound with random poses of the cell.
void expectBound(const DeviceDef& def, const PoseCell& cell, const Nearest& n, std::mt19937_64& random) {
  const auto uniform = [&](double size) { return std::uniform_real_distribution<double>(-size, size)(random); };
  EXPECT_EQ(stringDistance(def, n.at, n.first, n.second), n.found);
  EXPECT_TRUE(cell.contains(n.at));
  for (int i = 0; i < 1000; ++i) {
    Vector6 at;
    for (int j = 0; j < 6; ++j) at[j] = uniform(cell.half[j]);
    const double distance = stringDistance(def, at, n.first, n.second);
    EXPECT_GE(distance, n.at_least - 1e-12) << n.first << " " << n.second;
    if (n.second < 0) continue;
    const GripPose x = cell.pose(at);
    const StringDef &a = def.strings[n.first], &b = def.strings[n.second];
    const double s = 0.5 + uniform(0.5), t = 0.5 + uniform(0.5);
    const Vector3 p = a.p_BE + s * (x.X_BG * a.p_GK - a.p_BE), q = b.p_BE + t * (x.X_BG * b.p_GK - b.p_BE);
    EXPECT_GE((p - q).norm(), distance - 1e-12);
  }
}

TEST(Interference, NoPoseFallsBelowTheBoundAndOneAttainsIt) {
  std::mt19937_64 random(3);
  const DeviceDef def = device("spidar_g6x3r");
  PoseCell moved, turned;
  moved.half.head<3>().setConstant(0.01);
  turned.half.tail<3>().setConstant(0.1);
  constexpr double kTolerance = 1e-3;
  for (const PoseCell& cell : {moved, turned})
    for (const Nearest& n : nearestOver(def, {cell}, kTolerance)) {
      expectBound(def, cell, n, random);
      EXPECT_LE(n.found - n.at_least, kTolerance) << n.first << " " << n.second;
    }
}

}  // namespace interference_test
}  // namespace haptic
