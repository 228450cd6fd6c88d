// The store of pairs against lists that are sorted anew: whatever rests and wakes, each pair is in one list, in the order of the keys.
#include "haptic_core/world/pair_store.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace haptic {
namespace pair_store_test {

struct Record {
  std::uint64_t key = 0;
  int value = 0;  ///< of its own, which has to stay with the key
};

void expectLists(const PairStore<Record>& store, const std::map<std::uint64_t, std::pair<int, bool>>& known) {
  std::vector<std::uint64_t> awake, resting, all;
  for (const auto& [key, is] : known) (is.second ? resting : awake).push_back(key);
  const auto keys = [&](const std::vector<int>& list) {
    std::vector<std::uint64_t> found;
    for (const int slot : list) {
      EXPECT_EQ(store[slot].value, known.at(store[slot].key).first);
      found.push_back(store[slot].key);
    }
    return found;
  };
  ASSERT_EQ(keys(store.awake()), awake);
  ASSERT_EQ(keys(store.resting()), resting);
  store.each([&](int slot) { all.push_back(store[slot].key); });
  ASSERT_TRUE(std::is_sorted(all.begin(), all.end()));
  ASSERT_EQ(all.size(), known.size());
  ASSERT_EQ(store.count(), static_cast<int>(known.size()));
}

TEST(PairStore, KeepsEachPairInOneListByKey) {
  constexpr int kCapacity = 40;
  PairStore<Record> store;
  store.fit(kCapacity);
  std::mt19937 random(62);
  std::map<std::uint64_t, std::pair<int, bool>> known;  // by key: its value; whether it rests
  std::vector<int> before;
  before.reserve(kCapacity);
  int next = 0, refused = 0;
  for (int round = 0; round < 2000; ++round) {
    // As a search does: of the pairs awake some are kept, others come and go.
    std::map<std::uint64_t, bool> found;  // by key: it is new
    for (const auto& [key, is] : known) {
      if (!is.second && random() % 4 != 0) found[key] = false;
    }
    for (int i = 0; i < 6; ++i) {
      const std::uint64_t key = 1 + random() % 60;
      if (known.count(key) == 0) found[key] = true;
    }
    store.renew(before);
    std::size_t at = 0;
    for (const auto& [key, is_new] : found) {
      for (; at < before.size() && store[before[at]].key < key; ++at) {
        known.erase(store[before[at]].key);
        store.drop(before[at]);
      }
      if (!is_new) {
        store.keep(before[at++]);
      } else if (const int slot = store.append(key); slot >= 0) {
        store[slot].value = next;
        known[key] = {next++, false};
      } else {
        ++refused;
      }
    }
    for (; at < before.size(); ++at) {
      known.erase(store[before[at]].key);
      store.drop(before[at]);
    }
    ASSERT_NO_FATAL_FAILURE(expectLists(store, known)) << round;
    const unsigned residue = random() % 3;
    const auto chosen = [&](int slot) { return store[slot].key % 3 == residue; };
    const bool rests = random() % 2 == 0;
    rests ? store.rest(chosen) : store.wake(chosen);
    for (auto& [key, is] : known) {
      if (key % 3 == residue) is.second = rests;
    }
    ASSERT_NO_FATAL_FAILURE(expectLists(store, known)) << round;
    for (const auto& [key, is] : known) ASSERT_EQ(store.find(key) >= 0, !is.second);
  }
  EXPECT_GT(refused, 0) << "the store was never full";
}

}  // namespace pair_store_test
}  // namespace haptic
