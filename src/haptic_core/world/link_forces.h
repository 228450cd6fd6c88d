/// Force elements of a world (dynamics/link_force.h): their links and their springs' energy, which counts as potential.
///
/// An element belongs to the island of the trees that it joins. It has no state: its force follows from poses and velocities. Steps
/// book what it takes with the weights of their stages (stepping/step_books.h).
#pragma once
#include <vector>

#include "haptic_core/dynamics/link_force.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic {

/// Power that an element's dampers take, and that leads supply to it.
struct ForcePower {
  double taken = 0, supplied = 0;  ///< [W]
};

/// Trees in a row.
struct TreeRange {
  const int* first = nullptr;        ///< world tree indices
  int count = 0;                     ///< of these
  const int* begin() const { return first; }        ///< the first
  const int* end() const { return first + count; }  ///< one past the last
};

/// (in realtime) The element here and now; `link`: by world index, placed.
LinkForce forceNow(const Model& model, const ModelForce& force, const LinkWork* link) noexcept;

/// (in realtime) Visits the elements that act on these trees, as (index, element), each once. `moves(tree)`: the tree is moved by forces.
template <class Trees, class Moves, class Visit>
void eachForce(const Model& model, const Trees& trees, Moves&& moves, Visit&& visit) noexcept {
  if (model.forces.empty()) return;
  for (const int t : trees) {
    if (!moves(t)) continue;
    for (int i = model.first_tree_force[t]; i < model.first_tree_force[t + 1]; ++i) {
      const ModelForce& force = model.forces[model.tree_forces[i]];
      const bool others = force.tree_b != t && force.tree_b >= 0 && moves(force.tree_b);  // it is visited with B's tree
      if (!others) visit(model.tree_forces[i], force);
    }
  }
}

/// (in realtime) An element acts on a link of the tree.
inline bool hasForces(const Model& model, int tree) noexcept {
  return !model.forces.empty() && model.first_tree_force[tree] < model.first_tree_force[tree + 1];
}

/// (in realtime) Both ends of all elements on these trees, ascending, are on them or never move.
bool forcesStayWithin(const Model& model, const TreeRange& trees) noexcept;
/// (in realtime) Energy of the springs that count with a tree [J]; each counts once.
double springsOf(const Model& model, int tree, const HandWork& hands, const Placement& placement) noexcept;

}  // namespace haptic
