// Observers observe: whether energies are booked changes no bit of the motion.
#include <gtest/gtest.h>

#include <cstring>

#include "../scenes/heap.h"
#include "../scenes/shipped_scenes.h"
#include "haptic_core/world/state.h"

namespace haptic {
namespace observers_test {

bool sameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// First of `steps` steps after which the motion with the ledger is not that without; `steps`: none.
int firstDifference(const SceneDef& scene, int steps) {
  SceneDef with = scene, without = scene;
  with.world.settings.energy_ledger = true;
  without.world.settings.energy_ledger = false;
  World booked(with.world), unbooked(without.world);
  for (int i = 0; i < steps; ++i) {
    followPaths(with, booked);
    followPaths(without, unbooked);
    booked.step();
    unbooked.step();
    const State &a = booked.state(), &b = unbooked.state();
    if (!sameBits(a.q, b.q) || !sameBits(a.v, b.v)) return i;
  }
  return steps;
}

TEST(Observers, TheLedgerChangesNoBitOfShippedScenes) {
  constexpr int kSteps = 400;
  const auto all = scenes::shippedScenes(HAPTIC_SCENES);
  ASSERT_GT(all.size(), 20u);
  for (const scenes::ShippedScene& scene : all) {
    EXPECT_EQ(firstDifference(scene.def, kSteps), kSteps) << scene.name;
  }
}

TEST(Observers, TheLedgerChangesNoBitOfHeaps) {
  constexpr int kSteps = 600;
  for (const double k : {1e7, 1e8, 1e10}) {
    scenes::HeapParameters p;
    p.stiffness = k;
    SceneDef scene;
    scene.world = scenes::heap(p, WorldSettings{});
    EXPECT_EQ(firstDifference(scene, kSteps), kSteps) << "k " << k;
  }
}

}  // namespace observers_test
}  // namespace haptic
