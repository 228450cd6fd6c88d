// Boxes that never move: every one that overlaps is found, by comparison with all.
#include "haptic_core/geometry/search/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace haptic {
namespace box_tree_test {

using Box = ConvexShape::Box;

std::vector<int> found(const BoxTree& tree, const Box& box) {
  std::vector<int> all;
  tree.eachOverlap(box, [&](int i) { all.push_back(i); });
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<int> compared(const std::vector<Box>& boxes, const Box& box) {
  std::vector<int> all;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const bool meet = (boxes[i].lower.array() <= box.upper.array()).all() && (box.lower.array() <= boxes[i].upper.array()).all();
    if (meet) all.push_back(static_cast<int>(i));
  }
  return all;
}

TEST(BoxTree, FindsWhatComparisonFinds) {
  std::mt19937 random(3);
  const auto number = [&] { return 2.0 * random() / random.max() - 1; };
  for (const int count : {0, 1, 4, 5, 100, 3000}) {
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) {
      const Vector3 middle(number(), number(), 0.1 * number()), half = 0.05 * Vector3(number(), number(), number()).cwiseAbs();
      boxes.push_back({middle - half, middle + half});
      if (i % 50 == 7) boxes.back() = {Vector3::Constant(-INFINITY), Vector3(INFINITY, INFINITY, -0.1)};  // a half-space
      if (i % 50 == 9) boxes.back() = boxes[0];
    }
    const BoxTree tree(boxes);
    std::size_t hits = 0;
    for (int i = 0; i < 300; ++i) {
      const Vector3 middle(1.2 * number(), 1.2 * number(), 0.3 * number()), half = Vector3::Constant(i % 3 * 0.1);
      const Box box{middle - half, middle + half};
      const std::vector<int> expected = compared(boxes, box);
      hits += expected.size();
      ASSERT_EQ(found(tree, box), expected) << count << " " << i;
    }
    EXPECT_TRUE(count < 100 || hits > 100);
    Box none{Vector3::Zero(), Vector3::Ones()};
    none.lower.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(found(tree, none).empty());
  }
}

}  // namespace box_tree_test
}  // namespace haptic
