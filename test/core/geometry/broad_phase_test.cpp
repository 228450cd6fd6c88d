#include "haptic_core/geometry/search/broad_phase.h"

#include <gtest/gtest.h>

#include <random>

#include "haptic_core/base/error.h"

namespace haptic {
namespace broad_phase_test {

using Box = ConvexPolyhedron::Box;

std::vector<BroadPhase::Pair> everyPair(const BroadPhase& phase, const std::vector<Box>& boxes) {
  std::vector<BroadPhase::Pair> pairs;
  for (int a = 0; a < phase.boxCount(); ++a)
    for (int b = a + 1; b < phase.boxCount(); ++b)
      if (phase.allowed(a, b) && (boxes[a].lower.array() <= boxes[b].upper.array()).all() &&
          (boxes[b].lower.array() <= boxes[a].upper.array()).all())
        pairs.push_back({a, b});
  return pairs;
}

TEST(BroadPhase, FindsWhatComparingAllPairsFinds) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1, 1), size(0.01, 0.3);
  const int count = 150;
  std::vector<std::pair<int, int>> never = {{3, 4}, {10, 2}};
  for (int i = 0; i < 10; ++i)
    for (int j = i + 1; j < 10; ++j) never.push_back({i, j});
  BroadPhase phase(count, never);
  std::vector<Box> boxes(count);
  for (int step = 0; step < 50; ++step) {
    const Vector3 shape = step < 25 ? Vector3(3, 1, 1) : Vector3(1, 1, 5);  // the axis changes on the way
    for (Box& box : boxes) {
      if (step % 10 == 0)
        box.lower = shape.cwiseProduct(Vector3(place(random), place(random), place(random)));
      else
        box.lower += 0.02 * Vector3(place(random), place(random), place(random));
      box.upper = box.lower + Vector3(size(random), size(random), size(random));
    }
    ASSERT_TRUE(phase.update(boxes.data()));
    const std::vector<BroadPhase::Pair> found(phase.pairs().begin(), phase.pairs().end());
    EXPECT_EQ(found, everyPair(phase, boxes));
    EXPECT_FALSE(found.empty());
  }
}

TEST(BroadPhase, SaysWhenPairsWereDropped) {
  BroadPhase phase(4, {}, 2);
  const std::vector<Box> boxes(4, Box{Vector3::Zero(), Vector3::Ones()});
  EXPECT_FALSE(phase.update(boxes.data()));
  EXPECT_EQ(phase.pairs().size(), 2);
}

TEST(BroadPhase, RefusesAPairOfNoBox) {
  EXPECT_THROW(BroadPhase(2, {{0, 2}}), SetupError);
}

}  // namespace broad_phase_test
}  // namespace haptic
