/// The lists that a step visits: all that may move, less the islands that are left out (stepping/activity.h). All lists ascend.
#pragma once
#include <vector>

#include "haptic_core/world/model.h"

namespace haptic {

/// What a tree does.
enum class Phase : unsigned char {
  kMoves,  ///< every step visits it
  kRests,  ///< it stands until something comes near
  kWaits   ///< it stands still until its turn (stepping/own_rate.h), in boxes as wide as it may come until then
};

/// Lists that a step visits; in the general pipeline everything.
struct Visits {
  std::vector<int> trees;    ///< kinematics, motion, energies: of the model's `updated_trees`
  std::vector<int> shapes;   ///< poses and boxes: of the model's `updated_shapes`
  std::vector<int> moving;   ///< boxes that are swept, as indices in the model's `moving_shapes`
  std::vector<Phase> phase;  ///< by tree

  explicit Visits(const Model& model)
      : trees(model.updated_trees), shapes(model.updated_shapes), phase(model.trees.size(), Phase::kMoves) {
    for (std::size_t i = 0; i < model.moving_shapes.size(); ++i) moving.push_back(static_cast<int>(i));
  }  ///< set-up: all
  /// A tree of the two is left out.
  bool leaveOut(int tree_a, int tree_b) const noexcept { return phase[tree_a] != Phase::kMoves || phase[tree_b] != Phase::kMoves; }
};

}  // namespace haptic
