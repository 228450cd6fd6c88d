/// Whether every motion that a tree's joints allow meets inertia.
///
/// A link's own inertia says nothing: a finger that slides needs a mass and no moment, and of two joints in a row the link between them
/// may weigh nothing. What counts is the joint-space inertia M(q) = Σ Jᵀ I J. It is positive definite where every factor
///   D_i = S_iᵀ I_i^A S_i
/// of its factorization from the leaves to the root is (Featherstone 2008, chapter 7: I^A is the articulated inertia of the subtree of
/// link i, S_i the axes of its joint). D_i is compared with S_iᵀ I_i^C S_i of the same subtree with its joints locked: a share, without
/// unit. M(q) can vanish at some q alone, as that of three axes through one point where two of them are parallel. So it is looked at
/// where the tree starts, and at kSampledPoses others, in which joints stand at their limits and at quarter turns.
#pragma once
#include "haptic_core/world/definition.h"

namespace haptic {

/// D below this share of the locked subtree's inertia counts as none: a thousand roundings of the sums, and a millionth of what the
/// slenderest rod of a robot has (1:1000).
inline constexpr double kLeastExcited = 1e-12;

inline constexpr int kSampledPoses = 64;  ///< a joint has seven places at most; each pair of places comes up once or more, in the mean

/// Index of the link nearest the leaves whose joint, with those beyond it, has a motion without inertia at some sampled pose; -1: none
/// has. Links must stand after their parents. Cost: kSampledPoses sweeps over the tree, at set-up. Mimic joints follow.
int linkWithoutInertia(const ArticulationDef& articulation);

}  // namespace haptic
