/// The parts of a convex solid's faces in a round tube about the z axis, and the volume that both enclose.
///
/// The boundary of V = tube ∩ solid is the part of the faces in the tube, and the part of the tube in the solid. On a face
/// that is a polygon cut by an ellipse: edges of the polygon and arcs. Seen along z the ellipse is a circle, so that a face is
/// cut as a ball cuts it. V and its moments are sums of cones from a point o of V, of which every piece of the boundary faces
/// away: no term cancels another. On the tube, in angle and height, one integral over the angle is a closed form; Green's
/// theorem makes the other one along the arcs.
///
/// An arc runs between two points of the solid's edges, which are kept: with φ from the direction in which the face looks out,
/// its height is z = z₀ + (z₁ - z₀) (cos φ₀ - cos φ)/(cos φ₀ - cos φ₁), which does not mind a face along the tube, and cuts an
/// arc where it turns back. All integrands are smooth in φ, for Gauss's rule: 16 points for half a turn.
#pragma once
#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/ball_cut.h"
#include "haptic_core/geometry/volume/solid_moments.h"

namespace haptic {

/// Share of an arc's rise at the share `t` of its turn, which starts `from` [rad] and goes over `sweep` without passing a
/// multiple of π; and its derivative by t.
double arcRise(double from, double sweep, double t, double& rate) noexcept;

/// A piece of a face's boundary; an arc lies on the tube, its angles are about z.
using TubeCurve = RoundCurve<Vector3>;

/// A part of an arc that only rises or falls: angles from the face's apex, and heights [m].
struct TubeArc {
  double from, sweep;  ///< [rad]
  double z0, z1;       ///< at its ends [m]
};

/// Part of a face in the tube.
struct TubeFace {
  Vector3 normal;         ///< outward
  double offset = 0;      ///< normal·x on it [m]
  int index = -1;         ///< of the plane that made it
  double apex = 0;        ///< angle in which it looks out across z
  int first = 0, count = 0;  ///< its curves
  bool whole = false;     ///< all of the ellipse, one arc
};

/// See above. The tube's axis is z.
class TubeCut {
 public:
  void reserve(int faces, int half_edges);  ///< set-up: room for solids of so many faces and half edges
  void clear() noexcept { faces_.clear(), curves_.clear(); }  ///< nothing is cut

  /// (in realtime) Of all faces; false: the tube misses the solid.
  bool cut(const CutSolid& solid, double radius) noexcept;
  /// (in realtime) Common area of a convex polygon in the face's plane and the tube [m²]. `outline`: counter-
  /// clockwise seen from outside. Uses room behind the curves.
  double areaWithin(const TubeFace& face, const LoadedVector<Vector3>& outline) noexcept;

  const LoadedVector<TubeFace>& faces() const { return faces_; }    ///< those that the tube cuts
  const LoadedVector<TubeCurve>& curves() const { return curves_; }  ///< of all faces
  double radius() const { return radius_; }  ///< of the tube [m]

  Vector3 inside() const noexcept;  ///< a point of V
  PlaneMoments moments(const TubeFace& face, const Vector3& o) const noexcept;  ///< of its part
  /// Adds the cones from o, a point of V, over the tube's part.
  void addSide(const Vector3& o, SolidMoments& sums) const noexcept;

  /// Visits the parts of an arc.
  template <class Visit>
  void eachPart(const TubeFace& face, const TubeCurve& curve, Visit&& visit) const noexcept;

 private:
  template <class Corner, class Key>
  void cutLoop(int count, Corner corner, Key key, TubeFace& face) noexcept;
  void closeArcs(const TubeFace& face, bool holds_centre) noexcept;
  double wholeArea(const TubeFace& face) const noexcept;
  double areaOf(const TubeFace& face) const noexcept;
  template <class Visit>
  void eachTriangle(const TubeFace& face, const TubeCurve& curve, const elementary::SineCosine& apex, const Vector3& g,
                    Visit&& visit) const noexcept;
  double turningHeight(const TubeFace& face, const TubeCurve& curve, double alpha, int half_turns) const noexcept;

  double radius_ = 0, low_ = 0, high_ = 0;  ///< heights of the solid [m]
  LoadedVector<TubeFace> faces_;
  LoadedVector<TubeCurve> curves_;
};

template <class Visit>
void TubeCut::eachPart(const TubeFace& face, const TubeCurve& curve, Visit&& visit) const noexcept {
  const double alpha = std::remainder(curve.from - face.apex, 2 * M_PI), end = alpha + curve.sweep;
  const int way = curve.sweep > 0 ? 1 : -1;
  double from = alpha, z = curve.p.z();
  // The next multiple of π strictly ahead.
  int k = way > 0 ? static_cast<int>(std::floor(alpha / M_PI)) + 1 : static_cast<int>(std::ceil(alpha / M_PI)) - 1;
  for (; way * (end - k * M_PI) > 0; k += way) {
    const double at = turningHeight(face, curve, alpha, k);
    visit(TubeArc{from, k * M_PI - from, z, at});
    from = k * M_PI;
    z = at;
  }
  visit(TubeArc{from, end - from, z, curve.q.z()});
}

}  // namespace haptic
