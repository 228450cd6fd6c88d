#include "haptic_core/stepping/island_parts.h"

namespace haptic {

IslandParts::IslandParts(std::size_t trees, std::size_t joins) : joined_(trees) {
  for (auto* x : {&part_of_tree_, &trees_}) x->resize(trees);
  for (auto* x : {&first_tree_, &first_join_, &force_count_}) x->resize(trees + 1);
  joins_.resize(joins);
}

void IslandParts::find(const Island& island, const TreePair* joins, int contact_count, int force_count, bool together) noexcept {
  const int join_count = contact_count + force_count;
  for (int n = 0; n < island.tree_count; ++n) {
    joined_.separate(island.trees[n]);
    if (together) joined_.merge(island.trees[0], island.trees[n]);
  }
  for (int i = 0; i < join_count; ++i) {
    if (joins[i].a >= 0 && joins[i].b >= 0) joined_.merge(joins[i].a, joins[i].b);
  }
  count_ = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const int t = island.trees[n], top = joined_.root(t);
    if (top == t) {  // the lowest of its part
      first_tree_[count_] = first_join_[count_] = force_count_[count_] = 0;
      part_of_tree_[t] = count_++;
    }
    part_of_tree_[t] = part_of_tree_[top];
    ++first_tree_[part_of_tree_[t]];
  }
  const auto partOf = [&](const TreePair& trees) { return part_of_tree_[trees.a >= 0 ? trees.a : trees.b]; };
  for (int i = 0; i < join_count; ++i) ++first_join_[partOf(joins[i])];
  // Counts become ends, and these, filled from the back, beginnings.
  for (int p = 1; p < count_; ++p) {
    first_tree_[p] += first_tree_[p - 1];
    first_join_[p] += first_join_[p - 1];
  }
  first_tree_[count_] = island.tree_count;
  first_join_[count_] = join_count;
  for (int n = island.tree_count; n-- > 0;) trees_[--first_tree_[part_of_tree_[island.trees[n]]]] = island.trees[n];
  for (int i = join_count; i-- > contact_count;) {
    joins_[--first_join_[partOf(joins[i])]] = i - contact_count;
    ++force_count_[partOf(joins[i])];
  }
  for (int i = contact_count; i-- > 0;) joins_[--first_join_[partOf(joins[i])]] = i;
}

IslandPart IslandParts::part(int p) const noexcept {
  IslandPart part;
  part.trees = trees_.data() + first_tree_[p];
  part.tree_count = first_tree_[p + 1] - first_tree_[p];
  part.contacts = joins_.data() + first_join_[p];
  part.contact_count = first_join_[p + 1] - first_join_[p] - force_count_[p];
  part.forces = part.contacts + part.contact_count;
  part.force_count = force_count_[p];
  return part;
}

}  // namespace haptic
