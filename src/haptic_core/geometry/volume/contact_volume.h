/// The contact volume V = A ∩ B of two convex shapes and every moment of it that a wrench needs.
///
/// Conventions. Everything is expressed in A's frame, computed from the relative pose X_AB alone.
///   n        contact normal, unit, from A into B: the direction in which B is pushed.
///   P        patch frame: origin at the centroid of V, z = n, x and y any tangent axes (a function of n).
///   r=(x,y)  tangent coordinates in P;  d(r) ≥ 0  thickness of V along n;  ∫dA over V's projection on x,y.
/// S_A is the area vector of V's surface that belongs to A (∫ of A's outward normal), and S_B = -S_A. n
/// points along S_A. Moving B by δ changes the volume by δ·S_B = -δ·S_A: along +n it shrinks at the rate A0 =
/// n·S_A.
///
/// The area moments A0, A1, A2 count V's projection with the sign of n·(A's outward normal). Where A's part
/// of the surface folds over (deep contacts) the folded part counts negative, which is what makes A0, A1, A2
/// the exact derivatives of the volume; for every ordinary contact they are the plain moments of the
/// projection.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

class ContactWorkspace;

/// Where the contact normal comes from.
enum class NormalRule : unsigned char {
  kAreaVector,  ///< n along S_A: a function of the pose alone, the gradient of the volume
  kHistory      ///< n as it was when the pair was last separated, turning with A (the seeds' rule)
};

/// The part of an approach rate ḋ(r) = ρ + s·r over a patch that makes V thicker: all of it, less the motions that leave V congruent, as
/// rolling does (compressing_rate.h). It is ρ + lever·s + (slope s)·r.
struct CompressingRate {
  Matrix2 slope = Matrix2::Identity();  ///< symmetric, from 0 to 1 [1]
  Vector2 lever = Vector2::Zero();      ///< approach at P per unit of a slope that is left out, less that of P itself [m]
  bool all = true;                      ///< neither body spins: slope is 1, lever 0
  /// Where a place of the patch feels, and is felt by, the turns that compress [m].
  Vector2 felt(const Vector2& r) const { return slope * r + lever; }
};

/// The part of a side of V that neighbouring pieces of the same body cover.
struct CoveredArea {
  Vector3 vector = Vector3::Zero();  ///< outward, in A's frame [m²]
  double area = 0;                   ///< sum of its parts' sizes [m²]
  bool touched = false;              ///< V meets a cover, be it one with a gap too wide to be left out
};

/// The volume of intersection of two convex shapes, with the moments that a contact force needs.
struct ContactVolume {
  /// Which of the fields below are filled.
  enum class Status : unsigned char {
    kSeparated,  ///< a separating direction proves it; `depth` alone is filled
    kTouching,   ///< common points, no volume; n and P are defined, moments are zero
    kOverlap     ///< all fields filled
  };
  /// Bits of `flags`.
  enum Flag : unsigned {
    kCapacityExceeded =
        1u
        << 0,  ///< faces or vertices dropped: raise the capacity named in the plan; the contact still pushes
    kNormalFromHistory =
        1u << 1,  ///< the area vector (nearly) vanishes; n is the last normal, or the shortest way out
    kOnSeam = 1u << 2,  ///< V ends where pieces of one body touch
  };

  Status status = Status::kSeparated;       ///< of the last computation
  unsigned flags = 0;                       ///< of Flag
  Pose X_AP;                                ///< patch frame in A; n = X_AP.R.col(2), centroid = X_AC().p
  double rise = 0;                          ///< of P over the centroid [m]; 0 but for parts of a flush contact (seams.h)
  Vector3 area_vector_A = Vector3::Zero();  ///< S_A [m²]
  CoveredArea covered_a, covered_b;         ///< of A's and of B's side of V, where the request knows covers (InnerSides)
  double volume = 0;                        ///< ∫ d dA [m³]
  Matrix2 V2 = Matrix2::Zero();             ///< ∫ r rᵀ d dA [m⁵]; ∫ r d dA = 0 by the choice of P
  CompressingRate compressing;              ///< of the rate at which the surfaces approach
  double A0 = 0;                            ///< ∫ dA [m²]
  Vector2 A1 = Vector2::Zero();             ///< ∫ r dA [m³]
  Matrix2 A2 = Matrix2::Zero();             ///< ∫ r rᵀ dA [m⁴]
  /// With which body n turns, where it is not S_A's direction: 0 with A, 1 with B; negative: n follows S_A.
  double turns_with_b = -1;
  /// V's extent along the normal of the supporting face, the one with the largest share of the patch, or along n if that is less [m].
  /// Of two rods the overlap of both along that normal or n, where a side's normal is normal to both axes. On curved surfaces up to
  /// a few percent more. Separated: ≤ 0, minus a gap that is proven.
  double depth = 0;

  Vector3 normal() const { return X_AP.R.col(2); }                   ///< n, in A's frame
  Pose X_AC() const { return {X_AP.R, X_AP.p - rise * normal()}; }  ///< P moved to the centroid
};

/// Memory of a pair from one step to the next. Trivially copyable, and STATE: save and restore it with
/// the world. (It starts searches near their end and gives the normal when the area vector vanishes; a result
/// may differ in its last bits with another cache, and in its normal when flagged kNormalFromHistory.)
struct PairCache {
  Vector3 direction =
      Vector3::Zero();               ///< unit, from A to B, in A's frame: separates, or nearly; zero: unknown
  Vector3 normal = Vector3::Zero();  ///< the last contact normal, in A's frame; zero: never touched
  int vertex_a = 0, vertex_b = 0;    ///< where supports along `direction` were found

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.direction), visit(s.normal), visit(s.vertex_a), visit(s.vertex_b);
  }
};

/// What neighbouring pieces of the same body cover of a convex piece (internal_faces.h).
struct InnerFaces {
  /// A covered part of a face.
  struct Cover {
    int face;                      ///< of the piece
    std::vector<Vector3> outline;  ///< convex, in the piece's frame, counter-clockwise seen from outside the piece [m]
    double gap = 0;                ///< between it and the neighbour's face, or the lap of both, where it is no rounding [m]

    /// Share with which a contact of this depth takes it for no surface: one that is ten times as deep as the gap does not feel it [1].
    double share(double depth) const { return gap > 0 ? std::min(1.0, std::max(0.0, 2 - 10 * gap / depth)) : 1.0; }
  };
  std::vector<std::uint64_t> bits;  ///< bit f of word f/64: face f is covered, at least in part
  std::vector<Cover> covers;        ///< a face may have several

  /// Face f is covered, at least in part.
  bool has(int face) const { return bits[face >> 6] >> (face & 63) & 1; }
};

/// What neighbouring pieces cover of two pieces in contact.
/// Of A and of B; null: nothing is covered. Where a covered part of a face bounds V, V is a part of the contact of the whole
/// bodies (kOnSeam), and that part of its boundary is no surface: left out, the normal is that of the surface. With S_A, S_B
/// the area vectors of V's two sides, C_A, C_B the covered ones in them, of areas c_A and c_B,
///     n ∝ (c_A (S_A - C_A) - c_B (S_B - C_B)) / (c_A + c_B),
/// continuous in the poses, also where one of the two areas vanishes.
struct InnerSides {
  const InnerFaces* a = nullptr;  ///< of A's piece; null: nothing is covered
  const InnerFaces* b = nullptr;  ///< of B's piece
};

/// All that a caller may ask for beside the shapes and their pose.
struct ContactRequest {
  NormalRule rule = NormalRule::kAreaVector;  ///< where n comes from
  InnerSides inner;                           ///< covered faces
  Vector3 normal = Vector3::Zero();           ///< unit n in A's frame, prescribed, in place of the rule; zero: by the rule
};

/// Computes the contact volume. (in realtime) No heap, no locks; re-entrant with one workspace per thread.
/// The workspace must have been made for these shapes (`ContactWorkspace::reserve`); else faces are dropped,
/// flagged. Cost grows with the faces in contact. Error of the volume: a few roundings of the shapes'
/// coordinates times the area, i.e. relative c/depth with c ≤ 2e-15 m for 0.1 m bodies.
void contactVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB, PairCache& cache,
                   ContactWorkspace& workspace, ContactVolume& out, const ContactRequest& request = {}) noexcept;

/// The same of any two shapes, by the table of pairs (table.h).
void contactVolume(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, PairCache& cache,
                   ContactWorkspace& workspace, ContactVolume& out, const ContactRequest& request = {}) noexcept;

/// The same by the readable algorithm alone: cut A by one plane of B after the other. Cannot fail; the oracle
/// of the fast paths, and their fallback.
void contactVolumeByCutting(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                            PairCache& cache, ContactWorkspace& workspace, ContactVolume& out,
                            const ContactRequest& request = {}) noexcept;

}  // namespace haptic
