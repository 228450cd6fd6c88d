/// Memory for one contact at a time, sized at load, and the polyhedron V that the last call left in it.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/volume/contact_side.h"
#include "haptic_core/geometry/volume/cut_solid.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/geometry/volume/round_patch.h"

namespace haptic {

struct ContactVolume;
struct CoveredArea;
struct InnerFaces;
struct PartMoments;

/// An edge of V between its faces: from → to in the loop of `left`, to → from in that of `right`.
struct ContactEdge {
  int from, to;     ///< vertices of V
  int left, right;  ///< faces of V
};

/// A planar polygon of V's surface, counter-clockwise seen from outside.
struct ContactLoop {
  int face;          ///< face of V
  int first, count;  ///< its vertices: loopVertices()[first … first + count - 1]
};

/// A face of V seen along the normal of the contact.
struct FaceShadow {
  /// Which way the face looks along n: up, down, or so steeply that its shadow is a line.
  enum Side : unsigned char { kAbove, kBelow, kSteep };
  Side side = kSteep;        ///< of this face
  int anchor = -1;           ///< one of its vertices
  double area = 0;           ///< of the projection [m²], negative below
  double most = 0;           ///< largest distance along n from the plane of its side's largest face [m]
  int first = 0, count = 0;           ///< its edges, where they are grouped
  Vector2 longest = Vector2::Zero();  ///< its longest edge [m]; it and the box where shadows are bounded
  Vector2 low = Vector2::Constant(INFINITY), high = Vector2::Constant(-INFINITY);  ///< box in P [m]
  /// The boxes overlap.
  bool meets(const FaceShadow& o) const { return (low.array() <= o.high.array()).all() && (o.low.array() <= high.array()).all(); }
  /// Upper bound of the area that two of them have in common, from their widths where they cross [m²].
  double commonArea(const FaceShadow& o) const {
    const double smaller = std::min(std::abs(area), std::abs(o.area));
    const double crossing = std::abs(longest.x() * o.longest.y() - longest.y() * o.longest.x());
    return std::abs(area * o.area) * 4 < smaller * crossing ? std::abs(area * o.area) * 4 / crossing : smaller;
  }
};

/// ∫ d dS and ∫ d p dS over a face of V, d the thickness there and p in P.
struct FaceLoad {
  Vector3 normal;                   ///< outward, in P's axes
  double load = 0;                  ///< ∫ d dS [m³]
  Vector3 first = Vector3::Zero();  ///< ∫ d p dS [m⁴]
};

/// Pairs up two things that share a key, in a table that needs no clearing between uses.
class PairTable {
 public:
  void reserve(int entries);  ///< set-up: room for so many pairs
  void clear() noexcept;      ///< (in realtime) forgets all pairs; O(1)
  /// The value stored under (a, b), or a new slot holding -1. Null when full.
  int* find(int a, int b) noexcept;

 private:
  struct Slot {
    std::uint64_t key;
    std::uint32_t epoch;
    int value;
  };
  std::vector<Slot> slots_;
  std::uint32_t epoch_ = 1;
};

/// A contact's V, kept while its workspace serves others.
struct KeptVolume {
  LoadedVector<Vector3> vertices;   ///< in A's frame [m]
  LoadedVector<ContactFace> faces;  ///< of V
  LoadedVector<ContactEdge> edges;  ///< those from `seam_begin` where the surfaces of A and B cross
  int seam_begin = 0;               ///< see above
  RoundVolume round;                ///< instead, where one of the shapes is round
};

/// Memory for one contact at a time, with the volume V that the last call left in it.
/// One per thread. Filled by `contactVolume`; the accessors describe the last call's V while its status was
/// kOverlap.
class ContactWorkspace {
 public:
  /// Makes room for contacts between A and B, beside earlier reservations; see table.h. Not in a tick.
  void reserve(const ConvexShape& A, const ConvexShape& B);
  /// The same for any two of these shapes.
  void reserve(const std::vector<const ConvexShape*>& shapes);
  void reserve(const ConvexPolyhedron& A, const ConvexPolyhedron& B);  ///< of two polyhedra
  void reserveRound(const ConvexShape& other);  ///< of a round shape with another, whose faces cut it
  void reserveCut(const ConvexShape& shape, int planes);  ///< of a polyhedron that so many planes cut
  void reserveRod(const ConvexShape& other);              ///< of a rod with another shape
  /// The same for any two shapes with `face_count` faces together.
  void reserve(int face_count);
  /// True when any contact between A and B fits.
  bool fits(const ConvexPolyhedron& A, const ConvexPolyhedron& B) const;

  /// Makes `kept` as large as the workspace is for V. Not in a tick.
  void reserve(KeptVolume& kept) const;
  /// (in realtime) Swaps V with that of `kept`, which was reserved as the workspace was. O(1).
  void exchange(KeptVolume& kept) noexcept;

  /// (in realtime) Forgets the last V: no vertices, faces and edges.
  void clear() noexcept;

  const LoadedVector<Vector3>& vertices() const { return vertices_; }  ///< in A's frame [m]
  const LoadedVector<ContactFace>& faces() const { return faces_; }    ///< of V
  /// Those where the surfaces of A and B cross come last: `left` is A's face, `right` is B's.
  const LoadedVector<ContactEdge>& edges() const { return edges_; }

  /// (in realtime) A point inside each face, the mean of its vertices, in A's frame [m]; until V changes or the next call.
  /// Cost O(edges).
  const LoadedVector<Vector3>& faceCentres() noexcept;

  /// (in realtime) A convex polygon in P, and keeping the part of it where an affine `height` is ≥ 0; until the next call of
  /// anything else. A plane adds one corner at most, so that faces of V laid over one another fit.
  LoadedVector<Vector2>& polygon() { return polygon_; }
  /// (in realtime) Scratch by face: where a cut leaves its outline, and where it comes back to it.
  LoadedVector<Vector3>& leaves() { return leave_; }
  LoadedVector<Vector3>& returns() { return return_; }  ///< (in realtime) see leaves
  template <class Height>
  void keepAbove(Height height) noexcept;   ///< (in realtime) of `polygon`
  int dropped() const { return dropped_; }  ///< corners for which there was no room, since `clear`

  /// (in realtime) Chains the edges into one polygon per face; for drawing. Cost O(edges).
  void buildLoops() noexcept;
  /// (in realtime) Those of one face alone. Cost O(edges), and the square of the face's.
  void buildLoopsOf(int face) noexcept;

  /// (in realtime) What volume_cutting.h has left of a solid.
  const CutSolid& solid() const { return solid_; }

  /// V where one of the shapes is round: `filled`, and of the above only the faces of the other shape that bound it.
  RoundVolume& round() { return round_; }
  const RoundVolume& round() const { return round_; }  ///< see above
  /// (in realtime) See covered_area.h, which calls it.
  CoveredArea coveredArea(Owner owner, const InnerFaces& inner, const Pose& X_AS) noexcept;
  const LoadedVector<ContactLoop>& loops() const { return loops_; }  ///< one per face, after `buildLoops` or `buildLoopsOf`
  /// Vertices of V, loop after loop.
  const LoadedVector<int>& loopVertices() const { return loop_vertices_; }

  /// A piece of the seam while its ends are being found, between planes of the sides; -1: not yet.
  struct Seam {
    /// `start`, `end`: vertices of V; the planes are those of A's side and of B's.
    int start, end, plane_a, plane_b;
  };

 private:
  friend class VolumeCutter;
  friend class EdgeClipper;
  friend class RoundContact;
  template <class Side, class Seams>
  friend class EdgeCollector;
  friend class ContactIntegrator;
  friend PartMoments momentsWhere(ContactWorkspace&, const ContactVolume&, const Vector2&, double) noexcept;
  friend double thicknessSquared(ContactWorkspace&, const ContactVolume&) noexcept;
  friend class FaceLoads;

  void reserveSides(int vertices, int faces);
  void reserveResult(int face_count);
  void projectVertices(const ContactVolume& contact) noexcept;
  void projectFaces(const ContactVolume& contact) noexcept;
  void boundShadows() noexcept;
  bool projectSides(const ContactVolume& contact) noexcept;
  double squaresBelowOneFace(const ContactVolume& contact) const noexcept;
  void groupEdges() noexcept;
  void overlayFaces(int above, int below) noexcept;
  void clipPolygon(const Vector2& from, const Vector2& to) noexcept;

  LoadedVector<Vector3> vertices_;
  LoadedVector<ContactFace> faces_;
  LoadedVector<ContactEdge> edges_;
  int seam_begin_ = 0;
  LoadedVector<ContactLoop> loops_;
  LoadedVector<int> loop_vertices_, next_edge_;
  ContactSide side_a_, side_b_;
  LoadedVector<Vector3> outline_, cut_outline_;  ///< a face's polygon within a cover's outline
  LoadedVector<Seam> seams_;
  LoadedVector<Lanes> turned_;  ///< vertices from one of them, in P's axes
  LoadedVector<Lanes> feet_;    ///< the points of the faces' planes nearest to that vertex, likewise, and their normals' share along n
  LoadedVector<double> edge_areas_, face_areas_;  ///< twice, projected: of the triangle (that vertex, edge), and of a face
  CutSolid solid_, cut_;
  LoadedVector<double> height_;
  LoadedVector<int> moved_to_, cap_next_;
  PairTable pairs_;
  LoadedVector<Vector3> patch_points_;    ///< vertices in P
  LoadedVector<Vector3> leave_, return_;  ///< per face, where a cut leaves its loop and returns
  LoadedVector<Vector3> centres_;         ///< of `faceCentres`
  LoadedVector<FaceShadow> shadows_;
  LoadedVector<Vector3> away_;  ///< per vertex: below U, above L, and U - L [m]
  int largest_[2] = {-1, -1};   ///< of the faces above and below
  LoadedVector<FaceLoad> loads_;
  LoadedVector<int> shadow_edges_;
  LoadedVector<Vector2> polygon_, clipped_;
  RoundVolume round_;
  int dropped_ = 0;
};

template <class Height>
void ContactWorkspace::keepAbove(Height height) noexcept {
  clipped_.clear();
  for (int i = 0; i < polygon_.size(); ++i) {
    const Vector2 &p = polygon_[i], &q = polygon_[i + 1 < polygon_.size() ? i + 1 : 0];
    const double hp = height(p), hq = height(q);
    if (hp >= 0 && !clipped_.push_back(p)) ++dropped_;
    if ((hp >= 0) != (hq >= 0) && !clipped_.push_back(p + hp / (hp - hq) * (q - p))) ++dropped_;
  }
  std::swap(polygon_, clipped_);
}

}  // namespace haptic
