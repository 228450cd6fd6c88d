/// From two shapes and the motion of their links to the contact between them: the one place where force meets geometry.
///
///     volume of intersection → patch frame P → law of the pair → pressure and friction over the patch
///
/// Steps, certificate and error estimate all come here, so that the certified contact is the one that runs: joined
/// pieces, the rule of the normal, the recovery of bodies that started deep inside.
#pragma once
#include "haptic_core/contact/located_force.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/world/hand_bound.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/seams.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// One contact, with all that was computed on the way from geometry to force.
struct ContactEvaluation {
  ContactVolume volume;  ///< of A and B, in A's frame
  Pose X_AB;           ///< of B's shape in A's
  Pose X_WP;           ///< patch: origin at V's centroid, over seams in the whole's plane (seams.h), z = n from A to B
  Twist V_AB_P;        ///< of B's surface relative to A's at P, in P's axes: belts run over their shapes
  BeltRates belts;     ///< of these twists, at P in P's axes
  PairLaw law;         ///< as it holds now, recovery and hands taken into account
  LocatedForce force;  ///< on B at P, in P's axes
};

/// Where the shapes are and how their links move. Arrays by world index, the caller's.
struct ContactPlaces {
  const LinkWork* link = nullptr;  ///< by world link: how they move
  const Pose* X_WS = nullptr;      ///< by shape: where they are
  const int* held_by = nullptr;  ///< lead (HandWork) that prescribes the link's motion; -1: none
  const HandBound* bound = nullptr;  ///< by lead: what its hand bears; null: anything
  const double* pressed = nullptr;   ///< by world link: force that surfaces have to carry under it [N] (hand_bound.h); null: none
};

/// (in realtime) The law of a pair of shapes: the model's, firmer where a hand presses a tool with more than the surface can carry.
PairLaw lawOf(const Model& model, const ContactPlaces& places, int a, int b) noexcept;

/// (in realtime) How belts carry the surfaces over their shapes.
BeltRates beltRates(const Model& model, int shape_a, int shape_b, const LinkWork* link, const Pose& X_WP) noexcept;
/// (in realtime) B's rate less A's, in P's axes.
Twist beltTwist(const Model& model, int shape_a, int shape_b, const LinkWork* link, const Pose& X_WP) noexcept;

/// (in realtime) The volume alone, with X_AB. False: the shapes do not overlap; `out` then holds the status alone.
/// `seams` knows the pair by its `index` in the state; the pair's cache advances. `workspace` holds V.
bool findVolume(const Model& model, Seams& seams, int index, ActivePair& pair, const Pose* X_WS, ContactWorkspace& workspace,
                ContactEvaluation& out) noexcept;

/// (in realtime) Frame, twist and law of a volume that was found.
void placeContact(const Model& model, const ActivePair& pair, const ContactPlaces& places, ContactEvaluation& out) noexcept;

/// (in realtime) Everything but the force: both of these.
bool locateContact(const Model& model, Seams& seams, int index, ActivePair& pair, const ContactPlaces& places,
                   ContactWorkspace& workspace, ContactEvaluation& out) noexcept;

/// (in realtime) The whole: a contact's force with the friction memory `memory`, advanced by `advance`.
bool evaluateContact(const Model& model, Seams& seams, int index, ActivePair& pair, const ContactPlaces& places,
                     const FrictionMemory& memory, const Advance& advance, ContactWorkspace& workspace,
                     ContactEvaluation& out) noexcept;

/// (in realtime) ½ k ∫d² dA [J] of the contact whose V the workspace holds.
double elasticEnergy(const ContactVolume& volume, double stiffness, ContactWorkspace& workspace) noexcept;

/// (in realtime) The report of a contact.
ContactReport reportOf(const Model& model, const ActivePair& pair, const ContactVolume& volume, const Pose& X_WP,
                       const LocatedForce& force) noexcept;

}  // namespace haptic
