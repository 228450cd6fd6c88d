/// How stiff surfaces are where a scene does not say, or says that they are rigid.
///
/// Resting. A body of weight W that stands on a side of its hull sinks until k V(d) = W, with V the common volume of a flat
/// floor and the shapes on that side at depth d. With the least k for which d ≤ kSink L on every side on which it can stand (the
/// centre of mass lies over it), L its least extent, it rests no deeper than that share of its size. Water-like cubes of any
/// size need 1e6 N/m³, the default, below which nothing is chosen. A link of a tree that floats carries the tree's weight. Loads on
/// a body, off its centre or on an edge, and supports thinner than the body on them, are known of a whole scene alone: its loader adds
/// the weights above, the 2 N of a hand where the scene has one, and corrects k by the depths at which the scene comes to rest
/// (resting_depths.h).
/// Rigid. A body whose surface is said to be rigid rests no deeper than kRigidSink of its size under what stands on it, by the same rule.
/// On an edge or a corner it goes deeper, for V(d) has no face there; a settled scene that rests on one is stiffened further, or is a
/// warning. What moves asks for more: a world makes each rigid pair as stiff as its step resolves (Model::law).
/// Touching. A body that a pointer touches is as stiff as the hand can bear: the k that a relaxed hand bears when it presses
/// with 2 N on any side of the pointer, at the loop's rate over a wire as slow as the slowest shipped device's. A softer body
/// lets the pointer sink in by millimetres for nothing; the loop would weaken a stiffer one (world/hand_bound.h).
#pragma once
#include <cmath>

#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/world/definition.h"

namespace haptic {

inline constexpr double kSink = 0.01;  ///< share of the least extent: 1 mm on 10 cm, which an eye just sees at arm's length
inline constexpr double kRigidSink = 1e-6;  ///< share of the least extent at rest: 0.1 µm of 10 cm, below any reading of a pose
inline constexpr double kSlowestWire = 4e-4;  ///< [s] of urdf/devices, G6X4's
inline constexpr double kItsCount = 3.485e-5;  ///< [m] of the G6X4's strings

/// Stiffness that a link needs to rest.
struct RestingStiffness {
  double stiffness = 0;  ///< [N/m³]; 0: nothing rests
  double extent = 0;     ///< L [m]
};

/// At set-up. `weight` [N] that the link carries. `thinnest` [m] of its supports: it takes L's place where it is less. `sink`: depth over
/// L.
RestingStiffness restingStiffness(const LinkDef& link, double weight, double thinnest = INFINITY, double sink = kSink);

/// Weight [N] that link `link` carries when it lies on something; 0: it cannot lie.
double carriedWeight(const ArticulationDef& articulation, int link, double gravity);

/// [N/m³], at set-up.
double touchStiffness(const WorldDef& def, int pointer, const HandMapping& mapping);

}  // namespace haptic
