// Boxes that come and go: every one that overlaps is found, by comparison with all that are there.
#include "haptic_core/geometry/search/box_slots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace haptic {
namespace box_slots_test {

using Box = ConvexShape::Box;

TEST(BoxSlots, FindsWhatComparisonFinds) {
  std::mt19937 random(3);
  const auto number = [&] { return 2.0 * random() / random.max() - 1; };
  const auto point = [&] { return Vector3(number(), number(), 0.1 * number()); };
  for (const int count : {0, 1, 2, 5, 100, 1000}) {
    std::vector<Vector3> places;
    for (int i = 0; i < count; ++i) places.push_back(i % 7 == 3 ? places[0] : point());
    BoxSlots slots(places);
    std::vector<Box> boxes(places.size());
    std::vector<char> there(places.size(), 0);
    std::size_t hits = 0;
    for (int round = 0; round < 2000; ++round) {
      for (int k = 0; count > 0 && k < 5; ++k) {
        const int i = static_cast<int>(random() % places.size());
        there[i] = random() % 3 > 0;
        const Vector3 middle = random() % 5 > 0 ? places[i] : point(), half = 0.05 * point().cwiseAbs();  // one in five went far
        boxes[i] = {middle - half, middle + half};
        there[i] ? slots.put(i, boxes[i]) : slots.clear(i);
      }
      const Vector3 middle = 1.2 * point(), half = Vector3::Constant(round % 3 * 0.1);
      Box box{middle - half, middle + half};
      if (round % 100 == 0) box = {Vector3::Constant(-INFINITY), Vector3::Constant(INFINITY)};
      std::vector<int> found, expected;
      slots.eachOverlap(box, [&](int i) { found.push_back(i); });
      for (int i = 0; i < count; ++i) {
        if (there[i] && BoxTree::overlap(boxes[i], box)) expected.push_back(i);
      }
      std::sort(found.begin(), found.end());
      hits += found.size();
      ASSERT_EQ(found, expected) << count << " " << round;
    }
    EXPECT_TRUE(count < 100 || hits > 1000);
  }
}

}  // namespace box_slots_test
}  // namespace haptic
