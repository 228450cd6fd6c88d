/// Ascending lists of indices.
#pragma once
#include <vector>

namespace haptic {

/// (in realtime) Adds the indices `added` to `list`; both ascend by `before(a, b)`, and `list` has room for all. O(both).
template <class Before>
void merge(const std::vector<int>& added, std::vector<int>& list, Before&& before) noexcept {
  std::size_t from = list.size(), next = added.size();
  list.resize(from + next);
  for (std::size_t to = list.size(); next > 0;) {
    list[--to] = from > 0 && before(added[next - 1], list[from - 1]) ? list[--from] : added[--next];
  }
}

}  // namespace haptic
