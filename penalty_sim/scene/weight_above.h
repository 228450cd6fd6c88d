/// What stands above each link at the start, as an upper bound of what it carries.
#pragma once
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

/// What a link carries, and on what it stands.
struct LinkLoad {
  double weight = 0;    ///< its own (carriedWeight), and of all bodies above it, one upon the other [N]; 0: it cannot lie
  double thinnest = 0;  ///< least extent of the collisions that it stands on [m]; infinite: there are none
};

/// Of every link, by articulation and link. A body is above a link when their boxes overlap seen along gravity and it begins where the
/// link's ends, within half of the lower one's height. Bodies above those count as well; each once, as if it stood on this link alone. A
/// load on a tree that floats is carried by all its links. `extents`: of every collision, by articulation, link and collision [m].
/// Cost: O(links²), at set-up.
std::vector<std::vector<LinkLoad>> loadsOf(const WorldDef& world, const std::vector<std::vector<std::vector<double>>>& extents);

}  // namespace haptic
