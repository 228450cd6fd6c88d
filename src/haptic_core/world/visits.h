/// The lists that a step visits: all that may move, less the islands that sleep (stepping/asleep.h). All lists ascend.
#pragma once
#include <vector>

#include "haptic_core/world/model.h"

namespace haptic {

/// Lists that a step visits; in the general pipeline everything.
struct Visits {
  std::vector<int> trees;   ///< kinematics, motion, energies: of the model's `updated_trees`
  std::vector<int> shapes;  ///< poses and boxes: of the model's `updated_shapes`
  std::vector<int> moving;  ///< boxes that are swept, as indices in the model's `moving_shapes`

  explicit Visits(const Model& model) : trees(model.updated_trees), shapes(model.updated_shapes) {
    for (std::size_t i = 0; i < model.moving_shapes.size(); ++i) moving.push_back(static_cast<int>(i));
  }  ///< set-up: all
};

}  // namespace haptic
