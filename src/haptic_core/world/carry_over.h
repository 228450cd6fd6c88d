/// A running world whose bodies become more or fewer: the state of what stays is carried over to a world of another definition.
///
/// The other world is compiled, with all its storage, by whoever wants the change, in a thread of its own (NextWorld). Between two ticks
/// the running world takes it up (World::exchange): positions, velocities, what integrators remember, contacts with their friction,
/// hands, wrenches, motions and sums of energy go over, tree by tree and pair by pair, in one pass without an allocation; then the two
/// change places, and the old one goes where the other was made. What stays, and has no pair with what comes or goes, moves on bit for
/// bit as if nothing had happened; but where something that velocity Verlet steps has such a pair, all forces are looked at again.
#pragma once
#include <memory>
#include <vector>

#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic {

/// Which parts of a world are which of another.
struct CarryOver {
  const Model* from = nullptr;       ///< of the world that runs
  std::vector<int> tree;             ///< by new tree: the old one; −1: it comes
  std::vector<int> tree_now;         ///< by old tree: the new one; −1: it goes
  std::vector<int> motion;           ///< by new motion: the old one; −1: it comes
  std::vector<int> link, shape;      ///< by old link and shape: the new one; −1: it goes
  std::vector<int> coming;           ///< new trees that come
  std::vector<int> pulled;           ///< new trees on which other force elements act than before, ascending
  // Filled while the state is carried over; room at set-up.
  std::vector<char> stirred;         ///< by new tree: it lost a contact
};

/// `kept`: by articulation of the new definition, that of the old; −1: it comes. Throws SetupError: articulations out of order or with
/// other links, another step or other pointers, a hand whose link goes, loops that join what came apart.
CarryOver carryOverOf(const Model& from, const Model& to, const std::vector<int>& kept);

/// (in realtime) The old state into the new one, and what the last step told of contacts. O(bodies + contacts); what comes is looked at for
/// bodies that it starts in.
void carryOver(CarryOver& map, const State& from, const Work& old_work, Model& model, State& state, Work& work) noexcept;

}  // namespace haptic
