/// The parts of an island: bodies that the patches and forces of a pass join. An island joins bodies that are near.
#pragma once
#include <vector>

#include "haptic_core/base/disjoint_sets.h"
#include "haptic_core/world/islands.h"

namespace haptic {

/// Trees, contacts and forces of a part, all ascending; arrays of IslandParts.
struct IslandPart {
  const int *trees = nullptr, *contacts = nullptr;  ///< world tree indices; indices into the contacts of the pass
  int tree_count = 0, contact_count = 0;            ///< of these
  const int* forces = nullptr;                      ///< indices into the forces of the pass
  int force_count = 0;                              ///< of these
};

/// Trees of the two links of a contact or a force; -1 for a link that the island does not move.
struct TreePair {
  int a = -1, b = -1;  ///< world tree indices
};

/// Union by patches and forces; every loop is bounded by trees and contacts.
class IslandParts {
 public:
  IslandParts(std::size_t trees, std::size_t joins);  ///< set-up: room for so many

  /// (in realtime) Parts of an island by the trees of its contacts, and after them of its forces, at least one of which is the island's.
  /// `together`: all is one.
  void find(const Island& island, const TreePair* joins, int contact_count, int force_count, bool together) noexcept;

  int count() const { return count_; }                       ///< parts
  IslandPart part(int p) const noexcept;                     ///< (in realtime) valid until the next `find`
  int of(int tree) const { return part_of_tree_[tree]; }     ///< index of the part of a tree of the island

 private:
  int count_ = 0;
  DisjointSets joined_;                                                      ///< of trees
  std::vector<int> part_of_tree_;                                            ///< by tree
  std::vector<int> trees_, joins_, first_tree_, first_join_, force_count_;   ///< grouped by part, contacts first; by part
};

}  // namespace haptic
