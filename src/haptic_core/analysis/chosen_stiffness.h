/// How stiff surfaces are where a scene does not say.
///
/// Resting. A body of weight W that stands on a side of its hull sinks until k V(d) = W, V what a flat floor and the sides'
/// shapes have in common at depth d. With the least k for which d ≤ kSink L on every side on which it can stand (the
/// centre of mass lies over it), L its least extent, it rests no deeper than that share of its size. Water-like cubes of any
/// size need 1e6 N/m³, the default, below which nothing is chosen. A link of a tree that floats carries the tree's weight. What stands
/// on a body, off its centre or on an edge, and what is thinner than the body that stands on it, a whole scene tells: its loader adds
/// the weights above, the 2 N of a hand where the scene has one, and corrects k by the depths at which the scene comes to rest
/// (resting_depths.h).
/// Touching. What a hand touches with its pointer is as stiff as it can bear: the k that a relaxed hand bears when it presses
/// with 2 N on any side of the pointer, at the loop's rate over a wire as slow as the slowest shipped device's. What is softer
/// lets the pointer sink in by millimetres for nothing; what is stiffer the loop would weaken (world/hand_bound.h).
#pragma once
#include <cmath>

#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/world/definition.h"

namespace haptic {

inline constexpr double kSink = 0.01;  ///< share of the least extent: what an eye tells at arm's length on 10 cm
inline constexpr double kSlowestWire = 4e-4;  ///< [s] of urdf/devices, G6X4's

/// What a link needs to rest.
struct RestingStiffness {
  double stiffness = 0;  ///< [N/m³]; 0: nothing rests
  double extent = 0;     ///< L [m]
};

/// At set-up. `weight` [N] that the link carries. `thinnest` [m] of what it stands on: L is that, where it is less than the link's own.
RestingStiffness restingStiffness(const LinkDef& link, double weight, double thinnest = INFINITY);

/// Weight [N] that link `link` carries when it lies on something; 0: it cannot lie.
double carriedWeight(const ArticulationDef& articulation, int link, double gravity);

/// [N/m³], at set-up.
double touchStiffness(const WorldDef& def, int pointer, const HandMapping& mapping);

}  // namespace haptic
