/// How stiff the surfaces are that no file gives a stiffness, and those that are said to be rigid.
#pragma once
#include <functional>
#include <string>

#include "scene/robot_tree.h"

namespace haptic {

/// Once the scene is complete: a scene's material for all surfaces, else what each body's size and weight and each hand ask for
/// (haptic_core/analysis/chosen_stiffness.h), and what stands on it: a bound at first (weight_above.h), then the depths at which the
/// scene comes to rest (resting_depths.h), until none is more than 1 % of the least extent of its two collisions. A depth beyond it, with
/// a k of 1e12 N/m³ at most, is a warning; the deepest is a note. The listing of `check` has the reasons. Does nothing where the scene
/// gives a stiffness for all.
/// Rigid pairs (contact_material.h) get what the same weights and a fall ask for, and are settled likewise, to a millionth and with
/// 1e14 N/m³ at most. Settling takes a bounded, counted work; a note says where it ended before the scene was at rest. `tell` hears of it
/// each second; empty: nobody does.
void chooseStiffness(const std::function<void(const std::string&)>& tell, LoadContext& context);

/// Says of all surfaces that they are rigid, whatever they said, and gives each what it needs, without settling the scene. At set-up, of
/// scenes that a program makes and no hand touches.
void makeRigid(WorldDef& def);

}  // namespace haptic
