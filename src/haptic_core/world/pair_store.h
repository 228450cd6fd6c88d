/// The pairs of a state, each in a slot that it keeps while it lives, and lists of the slots in the order of their keys: of the pairs that
/// a step visits, and of those of islands at rest (stepping/activity.h). To let an island rest, or to wake it, moves numbers from one list
/// to the other; no pair is copied, and what looks at a state sees all of them.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "haptic_core/base/merge.h"

namespace haptic {

struct ActivePair;

/// Storage of a fixed capacity for records with a `key`.
template <class Pair>
class PairStore {
 public:
  /// Set-up: empty, with room for so many.
  void fit(int capacity) {
    slot_.resize(static_cast<std::size_t>(capacity));
    for (std::vector<int>* list : {&awake_, &resting_, &free_, &merged_}) list->reserve(slot_.size());
    clear();
  }
  /// (in realtime) Takes all away.
  void clear() noexcept {
    awake_.clear(), resting_.clear();
    free_.resize(slot_.size());
    for (std::size_t i = 0; i < free_.size(); ++i) free_[i] = static_cast<int>(free_.size() - 1 - i);  // the first is taken first
  }

  int capacity() const { return static_cast<int>(slot_.size()); }                     ///< pairs that there is room for
  int count() const { return static_cast<int>(awake_.size() + resting_.size()); }     ///< pairs
  const std::vector<int>& awake() const { return awake_; }      ///< slots of the pairs that a step visits, by key
  const std::vector<int>& resting() const { return resting_; }  ///< slots of the others, by key
  Pair* data() { return slot_.data(); }                         ///< by slot
  Pair& operator[](int slot) { return slot_[static_cast<std::size_t>(slot)]; }              ///< of a list
  const Pair& operator[](int slot) const { return slot_[static_cast<std::size_t>(slot)]; }  ///< of a list

  /// visit(slot) of all pairs, by key.
  template <class Visit>
  void each(Visit&& visit) const {
    auto a = awake_.begin(), r = resting_.begin();
    while (a != awake_.end() || r != resting_.end()) {
      const bool awake = r == resting_.end() || (a != awake_.end() && (*this)[*a].key < (*this)[*r].key);
      visit(awake ? *a++ : *r++);
    }
  }
  /// (in realtime) Slot of the pair with this key in one of the lists; −1: there is none. O(log n).
  int find(std::uint64_t key, const std::vector<int>& list) const noexcept {
    const auto found = std::lower_bound(list.begin(), list.end(), key, [this](int i, std::uint64_t k) { return (*this)[i].key < k; });
    return found != list.end() && (*this)[*found].key == key ? *found : -1;
  }
  int find(std::uint64_t key) const noexcept { return find(key, awake_); }  ///< (in realtime) of those that a step visits

  /// (in realtime) A new pair behind those that a step visits: `key` is larger than theirs. −1: there is no room.
  int append(std::uint64_t key) noexcept {
    if (free_.empty()) return -1;
    const int slot = free_.back();
    free_.pop_back();
    (*this)[slot] = Pair{};
    (*this)[slot].key = key;
    awake_.push_back(slot);
    return slot;
  }
  /// (in realtime) The list of what a step visits anew, for `keep` and `append` to fill by key; `before` gets the old one, of which what is
  /// not kept is to be dropped.
  void renew(std::vector<int>& before) noexcept {
    before.swap(awake_);
    awake_.clear();
  }
  void keep(int slot) noexcept { awake_.push_back(slot); }  ///< (in realtime) see `renew`
  void drop(int slot) noexcept { free_.push_back(slot); }   ///< (in realtime) see `renew`

  /// (in realtime) Those that a step visits and `rests(slot)` rest from here on. O(n).
  template <class Rests>
  void rest(Rests&& rests) noexcept { move(awake_, resting_, rests); }
  /// (in realtime) Those that rest and `wakes(slot)` are visited from here on. O(n).
  template <class Wakes>
  void wake(Wakes&& wakes) noexcept { move(resting_, awake_, wakes); }

 private:
  template <class Moves>
  void move(std::vector<int>& from, std::vector<int>& to, Moves&& moves) noexcept {
    merged_.clear();
    const auto stays = [&](int slot) {
      const bool moved = moves(slot);
      if (moved) merged_.push_back(slot);
      return moved;
    };
    from.erase(std::remove_if(from.begin(), from.end(), stays), from.end());
    merge(merged_, to, [this](int a, int b) { return (*this)[a].key < (*this)[b].key; });
  }

  std::vector<Pair> slot_;
  std::vector<int> awake_, resting_, free_, merged_;
};

}  // namespace haptic
