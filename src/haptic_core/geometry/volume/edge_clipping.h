/// The fast path: V from the edges of each body clipped by the planes of the other.
#pragma once
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {

/// Finds V from the edges of each body clipped by the planes of the other.
/// V's edges are the edges of A inside B, the edges of B inside A, and the seam where face f of A crosses
/// face g of B. Every end of a clipped edge is an end of two pieces of seam: an edge between f1 and f2 that
/// leaves through g ends a piece of (f1, g) and starts one of (f2, g). So each pair (f, g) must collect
/// exactly one start and one end. When all do, the surface is closed, and its volume is wrong by no more than
/// its vertices are, whatever the signs that rounding gave; when one does not, rounding decided two tests in
/// ways that do not go together, and the caller falls back on cutting.
///
/// Ties are decided before they can disagree: a point within a few roundings of a plane counts as outside
/// when it is A's and as inside when it is B's, as if B were that much smaller. Exactly aligned faces are
/// then an ordinary case.
///
/// Cost: only points beyond the lowest of the other body along `direction` take part, found by walking from
/// the support vertices; (points of one) × (faces of the other) sign tests, four at a time.
class EdgeClipper {
 public:
  /// The edges close a surface; there is no common volume; or rounding decided two tests in ways that do not
  /// go together.
  enum class Result : unsigned char { kClosed, kNothing, kInconsistent };

  /// `direction` (unit, A to B, in A's frame) has shown the overlap: highest of A along it `top_a`, lowest of
  /// B `bottom_b`, at vertices `support_a`, `support_b`.
  struct Overlap {
    Vector3 direction;         ///< separates least: unit, from A to B, in A's frame
    double top_a, bottom_b;    ///< along `direction` [m]
    int support_a, support_b;  ///< vertices of A and of B
  };

  /// For one contact; A, B, X_AB and the workspace must outlive it.
  EdgeClipper(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
              ContactWorkspace& workspace);

  /// Any two shapes.
  Result clip(const Overlap& overlap);
  /// Two boxes (isBox()): all of both takes part and A's planes are its axes.
  Result clipBoxes();

 private:
  void gather(const ConvexPolyhedron& body, const Vector3& direction, double threshold, int support,
              ContactSide& side);
  void classify(ContactSide& side, const ContactSide& other, double tolerance);

  const ConvexPolyhedron &A_, &B_;
  const Pose& X_AB_;
  ContactWorkspace& w_;
  ContactSide &a_, &b_;
  double tolerance_;
};

}  // namespace haptic
