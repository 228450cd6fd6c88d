/// One normal for the contact of two bodies that is spread over several of their convex pieces.
#pragma once
#include <cstdint>
#include <vector>

#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Finds one normal for a contact that is spread over several pieces of a body.
/// Where pieces of a body meet, each piece's V is a part of the bodies' V, cut off at an internal face. What becomes of its
/// normal depends on how the surface goes on there:
///
///   convex, concave   an edge of the body, or an inner corner (a wall on a floor): each part has the normal of its own
///                     surface, without the internal face (contact_volume.h, InnerSides).
///   flush             no edge at all (two floor tiles): the parts are one contact. The sum of a body's own surfaces over the
///                     parts is the area vector of the whole, and all get the normal of the sum; else a body sliding over
///                     the seam would be braked by an edge that is not there. Internal faces are left out of each part, for
///                     one of them may belong to a part with a bend, however small, which is none of the sum. Where pieces
///                     of both bodies meet, both have such a sum, and that of the body with more internal faces counts more.
///                     All have P in the plane through the
///                     centroid of the whole: there is one friction, not one per part at a depth of its own, whose difference
///                     would turn what rolls over the seam.
///
/// Which it is was decided from geometry at load: parts are flush when a surface that continues from piece to piece
/// (internal_faces.h) bounds them both.
class Seams {
 public:
  explicit Seams(const Model& model);  ///< set-up: decides which pairs can be flush

  /// False: no pieces of this world are flush within a body; nothing needs to be called.
  bool any() const { return model_.has_seams; }

  /// (in realtime) Computes the contact volume of each pair that may lie on a flush seam, and their common
  /// normals: of pairs[which[0 … count)], or of the first `count` when `which` is null. The pairs' caches advance.
  /// Cost: one contact volume per such pair; kept for `locate`, where it is not computed again.
  void find(ActivePair* pairs, const int* which, int count, const Pose* X_WS, ContactWorkspace& workspace) noexcept;
  /// (in realtime) Likewise, of pairs[which].
  void find(ActivePair* pairs, const std::vector<int>& which, const Pose* X_WS, ContactWorkspace& workspace) noexcept {
    find(pairs, which.data(), static_cast<int>(which.size()), X_WS, workspace);
  }

  /// (in realtime) The contact volume of pair i at X_AB, by the world's rule, or with the common normal when the pair is a part of
  /// a flush contact: then true. `workspace` holds V after it; the pair's kept volume is gone.
  bool locate(int i, ActivePair& pair, const Pose& X_WA, const Pose& X_AB, ContactWorkspace& workspace, ContactVolume& out) noexcept;

 private:
  bool locatePart(int i, ActivePair& pair, const Pose& X_WA, const Pose& X_AB, ContactWorkspace& workspace,
                  ContactVolume& out) noexcept;
  /// What `find` computed of a pair, by the area vector.
  struct Kept {
    Pose X_AB;                ///< where it was
    ContactVolume volume;     ///< all but V
    bool known = false;       ///< false: nothing is kept
    KeptVolume* V = nullptr;  ///< null: they do not overlap
  };
  /// From body to body in one order for all parts, whichever of a pair's shapes comes first.
  struct Part {
    int pair, shape_a, shape_b, cluster;
    double sign;  ///< -1: the pair has them the other way round
    Vector3 own_a_W, own_b_W;     ///< area vectors of a's own surface on V and, against it, of b's: S_A without internal faces [m²]
    double covered_a, covered_b;  ///< area of those [m²]
    Vector3 moment_W;             ///< V times its centroid [m⁴]
    double volume;                ///< V [m³]
    std::uint64_t surfaces_a, surfaces_b;  ///< bit n: flat surface n (modulo 64) of that side bounds it
  };
  std::uint64_t surfacesOf(int shape, Owner owner, const ContactWorkspace& workspace) const noexcept;
  int bodyOf(int shape) const noexcept;
  bool joined(const Part& x, const Part& y) const noexcept;

  const Model& model_;
  LoadedVector<Part> parts_;
  std::vector<char> found_;
  std::vector<Kept> kept_;  ///< by pair
  std::vector<KeptVolume> volumes_;
  std::vector<Vector3> normal_W_, centroid_W_;  ///< of the whole contact, by pair, where one was found
};

}  // namespace haptic
