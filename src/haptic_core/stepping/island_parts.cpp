#include "haptic_core/stepping/island_parts.h"

namespace haptic {

IslandParts::IslandParts(std::size_t trees, std::size_t contacts) : joined_(trees) {
  for (auto* x : {&part_of_tree_, &trees_}) x->resize(trees);
  for (auto* x : {&first_tree_, &first_contact_}) x->resize(trees + 1);
  contacts_.resize(contacts);
}

void IslandParts::find(const Island& island, const TreePair* contacts, int contact_count, bool together) noexcept {
  for (int n = 0; n < island.tree_count; ++n) {
    joined_.separate(island.trees[n]);
    if (together) joined_.merge(island.trees[0], island.trees[n]);
  }
  for (int i = 0; i < contact_count; ++i) {
    if (contacts[i].a >= 0 && contacts[i].b >= 0) joined_.merge(contacts[i].a, contacts[i].b);
  }
  count_ = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const int t = island.trees[n], top = joined_.root(t);
    if (top == t) {  // the lowest of its part
      first_tree_[count_] = first_contact_[count_] = 0;
      part_of_tree_[t] = count_++;
    }
    part_of_tree_[t] = part_of_tree_[top];
    ++first_tree_[part_of_tree_[t]];
  }
  const auto partOf = [&](const TreePair& trees) { return part_of_tree_[trees.a >= 0 ? trees.a : trees.b]; };
  for (int i = 0; i < contact_count; ++i) ++first_contact_[partOf(contacts[i])];
  // Counts become ends, and these, filled from the back, beginnings.
  for (int p = 1; p < count_; ++p) {
    first_tree_[p] += first_tree_[p - 1];
    first_contact_[p] += first_contact_[p - 1];
  }
  first_tree_[count_] = island.tree_count;
  first_contact_[count_] = contact_count;
  for (int n = island.tree_count; n-- > 0;) trees_[--first_tree_[part_of_tree_[island.trees[n]]]] = island.trees[n];
  for (int i = contact_count; i-- > 0;) contacts_[--first_contact_[partOf(contacts[i])]] = i;
}

IslandPart IslandParts::part(int p) const noexcept {
  return {trees_.data() + first_tree_[p], contacts_.data() + first_contact_[p], first_tree_[p + 1] - first_tree_[p],
          first_contact_[p + 1] - first_contact_[p]};
}

}  // namespace haptic
