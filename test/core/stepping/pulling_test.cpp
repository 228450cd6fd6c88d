// Contacts press and never pull: bodies dropped at stiffnesses that a step is far from resolving.
#include <gtest/gtest.h>

#include <algorithm>

#include "../../scenes/drops.h"

namespace haptic::test {
namespace pulling_test {

using namespace scenes;

/// A Newton step whose force would have to pull is small in a stiff contact, and no solution.
TEST(Pulling, WhatIsDroppedIsNeitherPulledAtNorThrown) {
  for (int seed = 0; seed < 300; ++seed) {
    World world(drop(seed));
    double largest = 0, lowest = 0;
    for (int i = 0; i < 200; ++i) {
      world.step();
      ASSERT_TRUE(world.report().finite) << seed;
      ASSERT_EQ(world.report().flags & kRunaway, 0u) << seed << " step " << i;
      for (int c = 0; c < world.contactCount(); ++c) {
        largest = std::max(largest, world.contact(c).normal_force);
        lowest = std::min(lowest, world.contact(c).normal_force);
      }
    }
    EXPECT_GE(lowest, -1e-9 * largest) << seed;
  }
}

}  // namespace pulling_test
}  // namespace haptic::test
