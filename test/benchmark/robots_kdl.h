/// Robots as loaded against KDL.
#pragma once
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic::bench {

/// Whether KDL has the joints of the tree: fixed, revolute and prismatic ones.
bool kdlKnows(const ArticulationDef& tree);

/// Largest difference over 10 random positions of: link poses, against the reach of the tree; the mass matrix and the forces of gravity,
/// each against its largest number.
double differenceFromKdl(const ArticulationDef& tree);

/// Forces of the joints of one degree, in the order of the links, as all of q, v and v̇ are [N·m] or [N].
std::vector<double> kdlInverseDynamics(const ArticulationDef& tree, const std::vector<double>& q, const std::vector<double>& v,
                                       const std::vector<double>& v_dot, const Vector3& gravity);

}  // namespace haptic::bench
