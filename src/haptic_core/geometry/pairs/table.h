/// The table of pairs: for two kinds of shapes the functions that compute their contact, their distance and the memory they need.
///
/// A pair has one entry, in the order of ShapeKind; the table turns a pair that comes the other way round, and says so (`turned`).
/// A function puts its results in A's frame as the caller has A, so that nothing is computed in other bits after a turn.
/// A new kind: a class in shapes/, a row here.
#pragma once
#include "haptic_core/geometry/search/gjk.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// Two shapes and their pose. `first` is of the kind that ShapeKind lists first.
struct ShapePair {
  const ConvexShape &first, &second;  ///< in the table's order
  bool turned;                        ///< the caller's A is `second`
  const Pose& X_AB;                   ///< of the caller's B in its A

  const ConvexShape& A() const { return turned ? second : first; }  ///< the caller's
  const ConvexShape& B() const { return turned ? first : second; }  ///< the caller's
};

/// (in realtime) As `contactVolume` in contact_volume.h.
using ContactFunction = void (*)(const ShapePair&, const ContactRequest&, PairCache&, ContactWorkspace&, ContactVolume&) noexcept;
/// (in realtime) As `closestPoints` in shape_distance.h.
using DistanceFunction = void (*)(const ShapePair&, const Vector3& direction_A, ClosestPoints&) noexcept;
/// Set-up: makes room in a workspace, for both orders.
using RoomFunction = void (*)(const ConvexShape& first, const ConvexShape& second, ContactWorkspace&);

/// One pair of kinds.
struct PairEntry {
  ContactFunction contact;    ///< null: the pair is listed in the other order
  DistanceFunction distance;  ///< likewise
  RoomFunction room;          ///< likewise
};

/// Vertices of a shape that a PairCache may name: its own, or those of its stand-in; 1: it has none, and is named by 0.
int cachedVertices(const ConvexShape& shape);

/// Of two kinds, `first` not after `second`.
const PairEntry& pairEntry(ShapeKind first, ShapeKind second) noexcept;

}  // namespace haptic
