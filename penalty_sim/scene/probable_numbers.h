/// Numbers of a scene that are possible and improbable, judged by others of the same link or joint.
#pragma once
#include "scene/robot_tree.h"

namespace haptic {

/// A warning for each, with the number and one that would be expected (number_bounds.h):
/// - a centre of mass farther from what the link has (its shapes, its joints) than that is wide;
/// - a moment of inertia beyond kMatterMargin times that of all mass at the link's farthest point, or below that of a copper wire as long
///   as the link, or a greatest one below that of a ball of osmium, by kMatterMargin;
/// - a density of the shapes that no matter has, by kMatterMargin;
/// - a link larger than kRobotSize that is joined to others;
/// - a joint of a robot that holds its pose, which must carry a weight and has no drive, or one too weak to move what it has.
/// Once the world's gravity and the tree's poses are known.
void warnOfImprobableNumbers(LoadContext& context);

}  // namespace haptic
