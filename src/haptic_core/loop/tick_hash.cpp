#include "haptic_core/loop/tick_hash.h"

#include <algorithm>

#include "haptic_core/base/word_hash.h"
#include "haptic_core/loop/hand.h"

namespace haptic {
namespace {

constexpr int kMaxLinkParts = TickHash::kMaxParts - kMaxHands;

std::uint64_t add(std::uint64_t hash, const Wrench& F) noexcept {
  hash = hashWords(hash, F.torque.data(), 3 * sizeof(double));
  return hashWords(hash, F.force.data(), 3 * sizeof(double));
}

std::uint32_t fold(std::uint64_t hash) noexcept { return static_cast<std::uint32_t>(hash ^ (hash >> 32)); }

}  // namespace

bool TickHash::operator==(const TickHash& other) const noexcept {
  return world == other.world && parts == other.parts &&
         std::equal(part.begin(), part.begin() + parts, other.part.begin());
}

void hashTick(HapticLoop& loop, TickHash& hash) noexcept {
  const World& world = loop.world();
  hash.world = world.hash();
  const int links = world.linkCount(), slots = std::min(links, kMaxLinkParts);
  hash.parts = slots + loop.handCount();
  for (int i = 0; i < links; ++i) {
    const Pose X_WL = world.linkPose(i);
    std::uint64_t h = hashWords(kHashStart, X_WL.R.data(), 9 * sizeof(double));
    h = hashWords(h, X_WL.p.data(), 3 * sizeof(double));
    std::uint32_t& part = hash.part[std::min(i, slots - 1)];
    part = i < slots ? fold(h) : part * 31 + fold(h);
  }
  for (int i = 0; i < loop.handCount(); ++i) {
    const HandReport& hand = loop.hand(i).report();
    std::uint64_t h = add(add(kHashStart, hand.F_asked_B), hand.F_achieved_B);
    h = hashWords(h, hand.tension.data(), static_cast<std::size_t>(hand.tension.size()) * sizeof(double));
    h = hashWords(h, &hand.port_energy, sizeof(double));
    hash.part[slots + i] = fold(h);
  }
}

}  // namespace haptic
