/// Whether a saved state can be that of a world: each of its indices points to something.
#pragma once
#include <vector>

namespace haptic {

class Model;
struct State;

/// Throws SetupError, before anything is taken over: another layout than `state` has (State::unpack), or links, shapes, vertices and
/// modes that the model does not have, pairs out of order. O(numbers), no copy. Numbers that are no indices may be anything: the step
/// judges them.
void refuseDamaged(const Model& model, const State& state, const std::vector<double>& packed);

}  // namespace haptic
