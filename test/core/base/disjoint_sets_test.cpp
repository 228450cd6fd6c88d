// Oracle: sets as lists of members, merged by renaming all of one.
#include "haptic_core/base/disjoint_sets.h"

#include <gtest/gtest.h>

#include <random>

namespace haptic {
namespace disjoint_sets_test {

/// Each number carries the root of its set.
struct NamedSets {
  std::vector<int> name;
  explicit NamedSets(int count) : name(count) { std::iota(name.begin(), name.end(), 0); }
  void merge(int from, int to) {
    for (int& each : name) {
      if (each == from) each = to;
    }
  }
};

TEST(DisjointSets, BeginWithOneNumberEach) {
  DisjointSets sets(5);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(sets.root(i), i);
}

/// From pairs in any order: the least number of a set is its root, at any time.
TEST(DisjointSets, KeepTheLowerRoot) {
  std::mt19937 random(1);
  for (const int count : {1, 2, 7, 100}) {
    DisjointSets sets(count);
    NamedSets oracle(count);
    for (int step = 0; step < 2 * count; ++step) {
      const int x = random() % count, y = random() % count, a = oracle.name[x], b = oracle.name[y];
      sets.merge(x, y);
      oracle.merge(std::max(a, b), std::min(a, b));
      if (step % 5) continue;  // searches shorten the ways, so not after every union
      for (int i = 0; i < count; ++i) ASSERT_EQ(sets.root(i), oracle.name[i]) << count << ' ' << step;
    }
    for (int i = 0; i < count; ++i) EXPECT_EQ(sets.root(i), oracle.name[i]);
  }
}

TEST(DisjointSets, KeepTheRootThatIsAskedFor) {
  std::mt19937 random(2);
  constexpr int kCount = 60;
  DisjointSets sets(kCount);
  NamedSets oracle(kCount);
  for (int step = 0; step < 2 * kCount; ++step) {
    const int x = random() % kCount, y = random() % kCount;
    sets.mergeInto(x, y);
    oracle.merge(oracle.name[y], oracle.name[x]);
  }
  for (int i = 0; i < kCount; ++i) EXPECT_EQ(sets.root(i), oracle.name[i]);
}

/// Members of some sets start again, the others stay merged.
TEST(DisjointSets, TakeMembersOutOfSets) {
  DisjointSets sets(6);
  for (const int x : {1, 2}) sets.merge(0, x);
  for (const int x : {4, 5}) sets.merge(3, x);
  for (const int x : {0, 1, 2}) sets.separate(x);
  for (const int x : {0, 1, 2}) EXPECT_EQ(sets.root(x), x);
  for (const int x : {3, 4, 5}) EXPECT_EQ(sets.root(x), 3);
  sets.merge(2, 5);
  EXPECT_EQ(sets.root(4), 2);
  sets.separate();
  for (int i = 0; i < 6; ++i) EXPECT_EQ(sets.root(i), i);
}

/// From the far end of the longest way, which every search shortens.
TEST(DisjointSets, SearchAChain) {
  constexpr int kCount = 100000;
  DisjointSets sets(kCount);
  for (int i = kCount; i-- > 1;) sets.mergeInto(i - 1, i);
  for (int i = kCount; i-- > 0;) ASSERT_EQ(sets.root(i), 0);
}

}  // namespace disjoint_sets_test
}  // namespace haptic
