/// What contacts did in the last step that visited them: the one list that hands, sensors, the check for a runaway and the world's callers
/// read. By the slots of their pairs (pair_store.h), so that those of islands that no step visits stay as they were.
#pragma once
#include <algorithm>
#include <iterator>
#include <vector>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// One touching pair of links, as the last step left it. Wrench on B, about P, in W.
struct ContactReport {
  int link_a = -1, link_b = -1;           ///< world link indices
  Pose X_WP;                              ///< patch frame: centroid, z = normal from A to B
  Wrench F_BP_W;                          ///< mean over the step, as its scheme applied it [N·m], [N]
  double normal_force = 0;                ///< [N]
  double volume = 0, area = 0, depth = 0; ///< [m³], [m²], [m]
  bool sticking = false;                  ///< friction holds it below its limit
  unsigned flags = 0;                     ///< of the ContactVolume
  int shape_a = -1, shape_b = -1;         ///< the model's shape indices
  double event = 1;                       ///< share of the step after which it touched, slid or stuck; 1: it did nothing of the kind
};

/// Storage of one for each pair of a state.
class ContactReports {
 public:
  /// Set-up: none, with room for so many pairs.
  explicit ContactReports(int pairs) : of_(static_cast<std::size_t>(pairs)) {
    for (std::vector<int>* list : {&visited_, &resting_}) list->reserve(of_.size());
  }
  /// (in realtime) There is none.
  void clear() noexcept {
    std::fill(of_.begin(), of_.end(), ContactReport{});
    visited_.clear(), resting_.clear();
  }

  /// (in realtime) A step looks at the pair: it touches where `tell` says so after this.
  void open(int slot) noexcept { at(slot).link_a = -1; }
  void tell(int slot, const ContactReport& contact) noexcept { at(slot) = contact; }  ///< (in realtime) it touches
  bool touches(int slot) const noexcept { return of_[static_cast<std::size_t>(slot)].link_a >= 0; }  ///< the pair does
  const ContactReport& operator[](int slot) const noexcept { return of_[static_cast<std::size_t>(slot)]; }  ///< of a pair that touches

  /// (in realtime) At the end of a step, of the slots that it visits; where what it visits has changed, of the others.
  void list(const std::vector<int>& visited) noexcept { take(visited, visited_); }
  /// (in realtime) See `list`.
  void listResting(const std::vector<int>& resting) noexcept { take(resting, resting_); }
  const std::vector<int>& resting() const { return resting_; }  ///< slots of those listed that no step visits
  int count() const { return static_cast<int>(visited_.size() + resting_.size()); }  ///< of those listed
  /// i < count(): by the keys of the pairs, those of islands that no step visits last.
  const ContactReport& listed(int i) const {
    const auto slot = static_cast<std::size_t>(i);
    return (*this)[slot < visited_.size() ? visited_[slot] : resting_[slot - visited_.size()]];
  }

 private:
  ContactReport& at(int slot) noexcept { return of_[static_cast<std::size_t>(slot)]; }
  void take(const std::vector<int>& slots, std::vector<int>& list) noexcept {
    list.clear();
    std::copy_if(slots.begin(), slots.end(), std::back_inserter(list), [this](int slot) { return touches(slot); });
  }

  std::vector<ContactReport> of_;       ///< by slot; link_a −1: it does not touch
  std::vector<int> visited_, resting_;  ///< slots of those that touch
};

}  // namespace haptic
