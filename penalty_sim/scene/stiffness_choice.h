/// How stiff the surfaces are that no file gives a stiffness.
#pragma once
#include "scene/robot_tree.h"

namespace haptic {

/// Once the scene is complete: a scene's material for all surfaces, else what each body's size and weight and each hand ask for
/// (haptic_core/analysis/chosen_stiffness.h), and what stands on it: a bound at first (weight_above.h), then the depths at which the
/// scene comes to rest (resting_depths.h), until none is more than 1 % of the least extent of its two collisions. A depth beyond it, with
/// a k of 1e12 N/m³ at most, is a warning; the deepest is a note. The listing of `check` has the reasons. Does nothing where the scene
/// gives a stiffness for all.
void chooseStiffness(LoadContext& context);

}  // namespace haptic
