/// Two faces that look at one another, as one sees them along a normal: where they lie over one another, and how deep.
#pragma once
#include <algorithm>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// A function c·(1, x, y) over a plane.
struct LinearField {
  double c = 0, cx = 0, cy = 0;  ///< value at the origin, slopes along x and y
  double at(double x, double y) const { return c + cx * x + cy * y; }  ///< value at (x, y)
};

/// Two faces laid over one another along a normal.
/// The common part of the projections of a face of A and one of B, convex and counter-clockwise in P's x and y [m], and the
/// thickness between the two planes [m]: positive where they overlap, negative where there is a gap. Unlike the faces of V it
/// reaches as far as the faces do, so that it shows the contact that a small turn would bring. A cylinder's end is an octagon of
/// the same area.
class FaceOverlay {
 public:
  static constexpr int kMostCorners = 16;  ///< of the common part; more, and `find` gives up

  /// (in realtime) Of the faces that look most along z of P, from A to B. False where these are not nearly parallel, do not
  /// lie over one another, or have too many corners together; nothing is left behind then. Cost: the faces of both and about
  /// 20 ns a corner.
  bool find(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Pose& X_AP) noexcept;
  /// (in realtime) Moves P along its x and y to the middle of the corners.
  void centre(Pose& X_AP) noexcept;

  /// (in realtime) Moves all of it [m].
  void shift(double x, double y) noexcept;

  void clear() noexcept { corners_ = 0; }                      ///< (in realtime) nothing in common
  bool empty() const { return corners_ == 0; }                 ///< nothing in common
  int corners() const { return corners_; }                     ///< of the common part
  double x(int i) const { return x_[i]; }                      ///< of corner i, in P [m]
  double y(int i) const { return y_[i]; }                      ///< of corner i, in P [m]
  const LinearField& thickness() const { return thickness_; }  ///< over P's x and y [m]
  double area() const;  ///< [m²]

  /// (in realtime) Visits (x, y, weight) of points over the part in which both fields are positive: Σ weight f = ∫ f dA
  /// for polynomials f up to the fourth degree.
  template <class Visit>
  void integrate(const LinearField& a, const LinearField& b, Visit&& visit) const noexcept;

 private:
  struct Polygon {
    double x[kMostCorners + 2], y[kMostCorners + 2];
    int corners = 0;
  };
  static void clip(const LinearField& positive, Polygon& polygon) noexcept;
  bool needsClipping(const LinearField& field, bool& nothing) const noexcept;

  double x_[kMostCorners], y_[kMostCorners];
  LinearField thickness_;
  int corners_ = 0;
};

template <class Visit>
void FaceOverlay::integrate(const LinearField& a, const LinearField& b, Visit&& visit) const noexcept {
  // Strang and Fix's six points on a triangle, of degree four: barycentric coordinates (1 - 2 s, s, s).
  static constexpr double kAt[2] = {0.445948490915965, 0.091576213509771}, kWeight[2] = {0.223381589678011, 0.109951743655322};
  Polygon p;
  bool nothing = false;
  const bool clip_a = needsClipping(a, nothing), clip_b = needsClipping(b, nothing);
  if (nothing) return;
  p.corners = corners_;
  std::copy_n(x_, corners_, p.x);
  std::copy_n(y_, corners_, p.y);
  if (clip_a) clip(a, p);
  if (clip_b) clip(b, p);
  for (int i = 1; i + 1 < p.corners; ++i) {
    const double ux = p.x[i] - p.x[0], uy = p.y[i] - p.y[0], vx = p.x[i + 1] - p.x[0], vy = p.y[i + 1] - p.y[0];
    const double area = 0.5 * (ux * vy - uy * vx);
    for (int k = 0; k < 2; ++k) {
      const double s = kAt[k], t = 1 - 2 * s, weight = area * kWeight[k];
      visit(p.x[0] + s * ux + s * vx, p.y[0] + s * uy + s * vy, weight);
      visit(p.x[0] + t * ux + s * vx, p.y[0] + t * uy + s * vy, weight);
      visit(p.x[0] + s * ux + t * vx, p.y[0] + s * uy + t * vy, weight);
    }
  }
}

}  // namespace haptic
