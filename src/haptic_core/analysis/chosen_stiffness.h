/// How stiff surfaces are where a scene does not say, or says that they are rigid.
///
/// Resting. A body of weight W that stands on a side of its hull sinks until k V(d) = W, with V the common volume of a flat
/// floor and the shapes on that side at depth d. With the least k for which d ≤ kSink L on every side on which it can stand (the
/// centre of mass lies over it), L its least extent, it rests no deeper than that share of its size. Water-like cubes of any
/// size need 1e6 N/m³, the default, below which nothing is chosen. A link of a tree that floats carries the tree's weight. Loads on
/// a body, off its centre or on an edge, and supports thinner than the body on them, are known of a whole scene alone: its loader adds
/// the weights above, the 2 N of a hand where the scene has one, and corrects k by the depths at which the scene comes to rest
/// (resting_depths.h).
/// Rigid. A body whose surface is said to be rigid rests no deeper than kRigidSink of its size under what stands on it, and in a fall
/// from its own height H on a side on which it can stand it goes no deeper than d = kRigidFall L: with the
/// damper of Hunt and Crossley, F = k V (1 + c v), m v dv = -F dd gives k ∫₀ᵈ V = m (v0/c − ln(1 + c v0)/c²), for any V(d); v0² = 2 g H,
/// and c = 0 is the energy ½ m v0². The weight's own work on the way, m g d, is added: it is an upper bound. On an edge or a corner
/// it goes deeper, for V(d) has no face there; a settled scene that rests on one is stiffened further, or is a warning.
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
inline constexpr double kRigidFall = 1e-4;  ///< likewise in a fall from its own height; asks for some 20 to 200 times as much as rest does
inline constexpr double kSlowestWire = 4e-4;  ///< [s] of urdf/devices, G6X4's
inline constexpr double kItsCount = 3.485e-5;  ///< [m] of the G6X4's strings

/// Stiffness that a link needs to rest.
struct RestingStiffness {
  double stiffness = 0;  ///< [N/m³]; 0: nothing rests
  double extent = 0;     ///< L [m]
};

/// At set-up. `weight` [N] that the link carries. `thinnest` [m] of its supports: it takes L's place where it is less.
RestingStiffness restingStiffness(const LinkDef& link, double weight, double thinnest = INFINITY);

/// Loads that a link of a rigid body has to bear.
struct RigidLoad {
  double weight = 0;            ///< on it and its own [N]
  double own = 0;               ///< of what falls with it [N]
  double gravity = 0;           ///< [m/s²]
  double dissipation = 0;       ///< c of Hunt and Crossley [s/m]; 0: no damper helps
  double thinnest = INFINITY;   ///< least extent of its supports [m]
};

/// At set-up.
RestingStiffness rigidStiffness(const LinkDef& link, const RigidLoad& load);

/// c [s/m] of a scene for RigidLoad: the least that a surface or the scene gives; 0 where the law of pressure has none.
double leastDissipation(const WorldDef& def);

/// Weight [N] that link `link` carries when it lies on something; 0: it cannot lie.
double carriedWeight(const ArticulationDef& articulation, int link, double gravity);

/// [N/m³], at set-up.
double touchStiffness(const WorldDef& def, int pointer, const HandMapping& mapping);

}  // namespace haptic
