#include "haptic_core/base/word_hash.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace haptic {
namespace word_hash_test {

constexpr int kWords = 12;
using Words = std::array<std::uint64_t, kWords>;

std::uint64_t hashOf(const Words& words) { return hashWords(kHashStart, words.data(), sizeof words); }

Words someWords(std::mt19937_64& random) {
  Words words;
  for (std::uint64_t& word : words) word = random();
  return words;
}

int bitsOf(std::uint64_t word) {
  int count = 0;
  for (; word; word &= word - 1) ++count;
  return count;
}

/// A changed bit of a word changes the hash, and half of the hash's bits once the words after it have been taken.
TEST(WordHash, EveryBitOfEveryWordCounts) {
  std::mt19937_64 random(1);
  long changed = 0;
  int early = 0;
  for (int round = 0; round < 20; ++round) {
    const Words words = someWords(random);
    for (int word = 0; word < kWords; ++word) {
      for (int bit = 0; bit < 64; ++bit) {
        Words other = words;
        other[static_cast<std::size_t>(word)] ^= std::uint64_t{1} << bit;
        const std::uint64_t difference = hashOf(words) ^ hashOf(other);
        ASSERT_NE(difference, 0u) << word << " " << bit;
        if (word >= kWords - 3) continue;
        ++early;
        changed += bitsOf(difference);
      }
    }
  }
  // Coins: 64 of them, thrown `early` times, have this mean and deviation of the mean.
  EXPECT_NEAR(static_cast<double>(changed) / early, 32, 6 * 4 / std::sqrt(static_cast<double>(early)));
}

/// Words in another order, and one more zero, have other hashes.
TEST(WordHash, OrderAndLengthCount) {
  std::mt19937_64 random(2);
  for (int round = 0; round < 1000; ++round) {
    const Words words = someWords(random);
    Words other = words;
    std::swap(other[round % kWords], other[(round + 1) % kWords]);
    EXPECT_NE(hashOf(words), hashOf(other));
    const std::uint64_t zero = 0;
    EXPECT_NE(hashWords(hashOf(words), &zero, sizeof zero), hashOf(words));
  }
}

/// A list that is hashed in parts has the hash of the whole.
TEST(WordHash, PartsContinueTheWhole) {
  std::mt19937_64 random(3);
  const Words words = someWords(random);
  for (std::size_t cut = 0; cut <= kWords; ++cut) {
    const std::uint64_t first = hashWords(kHashStart, words.data(), cut * sizeof words[0]);
    EXPECT_EQ(hashWords(first, words.data() + cut, (kWords - cut) * sizeof words[0]), hashOf(words));
  }
}

}  // namespace word_hash_test
}  // namespace haptic
