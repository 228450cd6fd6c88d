/// The chain of the figures: n boxes 0.1 × 0.02 × 0.02 m of 0.1 kg, hinged alternately about y and (0, 1,
/// 1)/√2.
#pragma once
#include <string>

#include "haptic_core/dynamics/articulation_def.h"

namespace haptic::test {

constexpr double kChainLength = 0.1, kChainWidth = 0.02, kChainMass = 0.1;

/// Horizontal along x at q = 0; hinge i is at x = i · 0.1 m. A floating chain's first link hangs on nothing.
inline TreeDef chain(int links, bool floating = false) {
  TreeDef tree;
  tree.name = "chain" + std::to_string(links);
  for (int i = 0; i < links; ++i) {
    BodyDef body;
    body.name = "link" + std::to_string(i);
    body.parent = i - 1;
    body.joint.name = "hinge" + std::to_string(i);
    body.joint.type = i == 0 && floating ? JointType::kFloating : JointType::kRevolute;
    body.joint.X_PJ = Pose(Vector3(i == 0 ? 0 : kChainLength, 0, 0));
    body.joint.axis = i % 2 ? Vector3(0, 1, 1).normalized() : Vector3::UnitY();
    body.inertia.mass = kChainMass;
    body.inertia.p_LC = Vector3(kChainLength / 2, 0, 0);
    const double along = kChainMass / 12 * 2 * kChainWidth * kChainWidth;
    const double across = kChainMass / 12 * (kChainLength * kChainLength + kChainWidth * kChainWidth);
    body.inertia.I_C = Vector3(along, across, across).asDiagonal();
    tree.links.push_back(body);
  }
  return tree;
}

}  // namespace haptic::test
