/// Robots as loaded against KDL.
#pragma once
#include "haptic_core/world/definition.h"

namespace haptic::bench {

/// Whether KDL has the joints of the tree: fixed, revolute and prismatic ones.
bool kdlKnows(const ArticulationDef& tree);

/// Largest difference over 10 random positions of: link poses, against the reach of the tree; the mass matrix and the forces of gravity,
/// each against its largest number.
double differenceFromKdl(const ArticulationDef& tree);

}  // namespace haptic::bench
