/// How stiff the surfaces are that no file gives a stiffness.
#pragma once
#include "scene/robot_tree.h"

namespace haptic {

/// Once the scene is complete: a scene's material for all surfaces, else what each body's size and weight and each hand ask for
/// (haptic_core/analysis/chosen_stiffness.h), with the reason in the listing of `check`. Does nothing where the scene gives
/// a stiffness for all.
void chooseStiffness(LoadContext& context);

}  // namespace haptic
