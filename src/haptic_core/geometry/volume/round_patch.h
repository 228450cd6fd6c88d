/// The patch of a contact with a round shape, for what its moments do not tell: pressure that is clipped, friction that
/// turns, ∫d².
///
/// ∫ d² dA over faces is twice V's moment about the plane of one of them, less the distances of the others' shares from it, which take
/// samples of these shares alone. The thickness of V is not piecewise linear, so there is no closed form for the rest. The part of
/// the polyhedron's surface in the round shape, seen along n, is cut into the shares of its faces; on each the thickness is smooth. A
/// share is integrated on rays from a point inside it, by Gauss's rule over its boundary (8 points on a line and on each third of a
/// turn) and along the rays (8; of a ball bent so that the root in its thickness, which lies beyond the ray's end, is none). Where V is
/// round about n, rings of constant thickness take the place of the rays. Of two rods the outline is the hull of points on the outlines
/// of their sections (rod_section.h), cut off to 32 lines, with a ray to each and 4 points on it. Relative error of ∫ d² and of friction:
/// 1e-12 where a ball shallower than a fifth of its radius lies on one face; over edges and corners 1e-6 and 1e-5 to a depth of half a
/// radius, ten times that where it is deeper and V does not fold over; 4e-3 of two rods, 1e-2 where a cylinder's rim crosses a share;
/// where a pressure is clipped inside the patch 1e-3 of the clipped part, 1e-2 under a rod, continuous in the poses.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/ball_cut.h"
#include "haptic_core/geometry/volume/gauss_legendre.h"
#include "haptic_core/geometry/volume/rod_breaks.h"
#include "haptic_core/geometry/volume/tube_cut.h"

namespace haptic {

struct ContactVolume;
struct PartMoments;

/// V = round shape ∩ polyhedron, ball, ellipsoid or rod as the last call of `contactVolume` left it in the workspace. Frame Q: a ball's
/// centre, and the axes in which it was cut; a rod's or ellipsoid's own frame; of two rods their frame E.
struct RoundVolume {
  /// At t from 0 to 1: a line, middle + x t; or an arc, middle + x cos φ + y sin φ + rise (share that `arcRise` gives), φ from
  /// `from` over `sweep`. In Q, and in P.
  template <class Vector>
  struct CurveIn {
    bool arc;                    ///< else a line
    double from, sweep;          ///< of an arc: first angle, and angle swept [rad]
    Vector middle, x, y, rise;   ///< see above [m]

    /// The point at t [m], and its derivative by t.
    Vector at(double t, Vector& rate) const {
      if (!arc) return rate = x, middle + t * x;
      const auto [sine, cosine] = elementary::sinCos(from + t * sweep);
      rate = sweep * (cosine * y - sine * x);
      if (rise.isZero(0)) return middle + cosine * x + sine * y;
      double speed;
      const double share = arcRise(from, sweep, t, speed);
      rate += speed * rise;
      return middle + cosine * x + sine * y + share * rise;
    }
  };
  using Curve = CurveIn<Vector2>;  ///< a piece of a share's outline, in P's x and y
  using Rim = CurveIn<Vector3>;    ///< a piece of a face part's outline, in Q
  /// Part of a face of the polyhedron that bounds V.
  struct FacePart {
    Vector3 normal;        ///< outward, in Q
    int index;             ///< of the face
    double offset;         ///< of its plane [m]
    PlaneMoments moments;  ///< about the point that the contact is summed about
    int first, count;      ///< a rod's: its rims
  };
  /// A face's part of the patch, seen along n.
  struct Share {
    int first, count;      ///< its curves
    Vector2 inside;        ///< a point of it
    int plane;             ///< that bounds V over all of it; -1: there is none
    double shadow = 0;     ///< area, or a bound of it [m²]
  };
  /// The plane of a face, in P.
  struct Plane {
    Vector3 normal;        ///< in P
    double offset;         ///< about P's origin [m]
  };

  /// The second of two rods, and where their sections were taken.
  struct SecondRod {
    const Rod* rod = nullptr;    ///< null: there is none
    RodPair pair = {};           ///< the two rods
    RodBreaks breaks = {};       ///< heights between which their sections were taken
    bool outlined = false;       ///< `hull` holds the outline
    double reach = 0;            ///< of the patch, see RoundPatch::reach [m]
  };

  bool filled = false;          ///< false: the workspace holds a polyhedron
  BallCut cut;                  ///< common parts of the polyhedron's faces and the ball
  Pose X_AQ;                    ///< of frame Q in A
  double sign = 1;              ///< -1: the polyhedron is B
  double radius = 0;            ///< of the ball or rod, or of the ball that an ellipsoid is in y [m]
  bool oval = false;            ///< an ellipsoid, which was cut as a ball in the coordinates y: x = stretch y along each axis of Q
  Vector3 stretch = Vector3::Ones();  ///< see above
  const Rod* rod = nullptr;     ///< null: a ball
  double other_radius = 0;      ///< of a second ball; 0: there are planes instead [m]
  Vector3 other_Q = Vector3::Zero();  ///< its centre
  bool axial = false;           ///< round about n through P's origin

  SecondRod second;             ///< where two rods meet

  LoadedVector<FacePart> parts; ///< parts of the polyhedron that bound V
  LoadedVector<Rim> rims;       ///< of a rod's parts
  LoadedVector<ContactFace> near;    ///< the polyhedron's planes that reach a rod, in its frame
  TubeCut tube;                 ///< of a rod's cylinder
  LoadedVector<Vector2> outline, hull;  ///< points of two rods' sections; the patch's outline, counter-clockwise and closed, in P [m]
  LoadedVector<Curve> curves;   ///< scratch of RoundPatch
  LoadedVector<Share> shares;   ///< scratch of RoundPatch
  LoadedVector<Plane> planes;   ///< scratch of RoundPatch: those that look back or across n, then one for each share
  int planes_back = 0;          ///< scratch of RoundPatch: how many those are
  double sampled = NAN;         ///< ∫ thickness by RoundPatch's samples, once they were taken [m³]

  void reserve(int faces, int half_edges);  ///< set-up: room for a polyhedron of so many faces and half edges
  void reserveRods();                       ///< set-up: room for two rods
};

/// Of `contact`, whose V is `volume`. (in realtime)
class RoundPatch {
 public:
  /// Its outline. The thickness is known after `fit`.
  RoundPatch(RoundVolume& volume, const ContactVolume& contact) noexcept;
  /// (in realtime) Scales the thickness so that its integral is the volume of the contact.
  RoundPatch& fit() noexcept;

  double reach() const noexcept;                      ///< largest |r| of the patch, within 2 % and not below it [m]
  /// Visits (r, weight [m²], d [m]) with Σ weight · d = Vol.
  template <class Visit>
  void eachSample(Visit&& visit) const noexcept;
  /// The same on rays from one point for all: a direction that turns about it is then constant on each.
  template <class Visit>
  void eachSampleAbout(const Vector2& centre, Visit&& visit) const noexcept;
  /// (in realtime) ∫ d² dA [m⁴]; needs no `fit`, and may do it between two round shapes.
  double thicknessSquared() noexcept;
  /// Whether V is round about n through P, after `fit`.
  bool isAxial() const { return v_.axial && !(uniform_ > 0); }
  /// Visits what `eachSample` does, where V is round, on rings of so many points, the thickness once a ring. What varies around
  /// a ring like a trigonometric polynomial of less than `angles` is exact.
  template <class Visit>
  void eachOnRings(int angles, Visit&& visit) const noexcept;

 private:
  static constexpr int kAll = -1;  ///< in place of a share's plane: all of them
  struct Sphere {
    Vector2 middle;
    double radius, lowest, highest;                   ///< in P [m]
  };
  static Sphere sphereAt(const Vector3& centre_P, double radius) {
    return {centre_P.head<2>(), radius, centre_P.z() - radius, centre_P.z() + radius};
  }
  /// The faces' coordinates in P: a point is at turn x + p, and the normal of a plane goes along level n.
  struct IntoP {
    Matrix3 turn;
    Vector3 p;
    Matrix3 level;
  };
  static IntoP intoP(const Pose& X_PQ) { return {X_PQ.R, X_PQ.p, X_PQ.R}; }
  template <class Faces>
  void addShares(const Faces& faces, const IntoP& map, bool planar) noexcept;
  void addShare(const RoundVolume::FacePart& part, const Matrix3& R_PQ, const Vector3& p_PQ, int plane) noexcept;
  void addShare(const CutFace& face, const Matrix3& R_PQ, const Vector3& p_PQ, int plane) noexcept;
  void standIn() noexcept;
  double levelOf(const RoundVolume::Plane& plane, const Vector2& r) const noexcept;
  const RoundVolume::Plane* mainPlane() const noexcept;
  double squaresBelow(const RoundVolume::Plane& main) const noexcept;
  template <class Visit>
  void eachSampleOf(const RoundVolume::Share& share, Visit&& visit, bool coarse = false) const noexcept;
  void addOval(const Pose& X_PQ) noexcept;
  void findOutline(const Pose& X_PQ) noexcept;
  Vector2 evenStart(const Vector2& across_both) const noexcept;
  void sampleHull(Vector2 even) noexcept;
  void addOutline() noexcept;
  double heightOver(const Vector2& r, int plane) const noexcept;
  bool resolves(double found) const noexcept;
  template <class Visit>
  void eachRing(Visit&& visit) const noexcept;
  template <class Visit>
  void alongRays(const RoundVolume::Curve& curve, const Vector2& centre, int plane, Visit&& visit, bool coarse = false) const noexcept;
  double thickness(const Vector2& r, int plane) const noexcept;
  double bendTowards(const Vector2& centre, const Vector2& a) const noexcept;

  RoundVolume& v_;
  const ContactVolume& contact_;
  Sphere ball_, other_;
  /// A rod in P.
  struct RodInP {
    const Rod* rod;
    Vector3 centre, axis;
    bool within(const Vector2& r, double& low, double& high) const noexcept;
  };
  RodInP rod_, second_;
  /// An ellipsoid in P. Over r it begins at lowest + slope (r - middle) + thin |across (r - middle)|²/…, as a ball does in y.
  struct OvalInP {
    Eigen::Matrix<double, 3, 2> across;  ///< y across the line over r
    Vector2 middle, slope;
    double radius, thin, lowest, highest;  ///< radius of the ball; lengths along z over those in y; in P [m]
    bool within(const Vector2& r, double& low, double& high) const noexcept;
  };
  OvalInP oval_;
  double scale_ = 1, uniform_ = 0;  ///< of the thickness; in place of it, unless 0
};

template <class Visit>
void RoundPatch::alongRays(const RoundVolume::Curve& c, const Vector2& centre, int plane, Visit&& visit, bool coarse) const noexcept {
  const auto sum = [coarse](double from, double to, auto&& at) {
    coarse ? integrate(kGauss4, from, to, at) : integrate(kGauss8, from, to, at);
  };
  const auto ray = [&](const Vector2& to, const Vector2& step, double weight) {
    const Vector2 a = to - centre;
    const double turn = v_.sign * weight * (a.x() * step.y() - a.y() * step.x());
    const auto at = [&](double t, double w) {
      const Vector2 r = centre + t * a;
      visit(r, turn * t * w, thickness(r, plane));
    };
    if (v_.second.rod) return integrate(kGauss4, 0, 1, at);
    const double bend = bendTowards(centre, a);
    sum(0, 1, [&](double s, double w) { at(s * (1 + bend * (1 - s)), w * (1 + bend - 2 * bend * s)); });
  };
  if (v_.second.rod && !c.arc) return ray(c.middle + 0.5 * c.x, c.x, 1);
  const int parts = c.arc ? static_cast<int>(std::abs(c.sweep) / 2.1) + 1 : 1;  // a third of a turn each
  for (int i = 0; i < parts; ++i) {
    sum(static_cast<double>(i) / parts, (i + 1.0) / parts, [&](double t, double w) {
      Vector2 rate;
      const Vector2 r = c.at(t, rate);
      ray(r, rate, w);
    });
  }
}

template <class Visit>
void RoundPatch::eachSampleOf(const RoundVolume::Share& share, Visit&& visit, bool coarse) const noexcept {
  for (int i = share.first; i < share.first + share.count; ++i) alongRays(v_.curves[i], share.inside, share.plane, visit, coarse);
}

template <class Visit>
void RoundPatch::eachSample(Visit&& visit) const noexcept {
  for (const RoundVolume::Share& share : v_.shares) eachSampleOf(share, visit);
}

/// Visits (radius [m], area [m²], thickness [m], not scaled). By the square of the radius, in which a cap is smooth: the more
/// so the shallower. With (a/R)² up to 0.09, 0.36 and 0.9 the rules leave 1e-13, 1e-15 and 1e-9.
template <class Visit>
void RoundPatch::eachRing(Visit&& visit) const noexcept {
  const double a = v_.cut.faces()[0].radius, R = v_.other_radius > 0 ? std::min(v_.radius, v_.other_radius) : v_.radius;
  const auto ring = [&](double square, double weight) {
    const double r = std::sqrt(square);
    visit(r, M_PI * weight, heightOver({r, 0}, kAll));
  };
  if (a * a <= 0.09 * R * R) {
    integrate(kGauss4, 0, a * a, ring);
  } else if (a * a <= 0.36 * R * R) {
    integrate(kGauss8, 0, a * a, ring);
  } else {
    integrate(kGauss16, 0, a * a, ring);
  }
}

template <class Visit>
void RoundPatch::eachOnRings(int angles, Visit&& visit) const noexcept {
  const elementary::SineCosine turn = elementary::sinCos(2 * M_PI / angles);
  eachRing([&](double radius, double area, double d) {
    Vector2 r(radius, 0);
    for (int i = 0; i < angles; ++i) {
      visit(r, area / angles, scale_ * d);
      r = Vector2(turn.cosine * r.x() - turn.sine * r.y(), turn.sine * r.x() + turn.cosine * r.y());
    }
  });
}

template <class Visit>
void RoundPatch::eachSampleAbout(const Vector2& centre, Visit&& visit) const noexcept {
  for (const RoundVolume::Curve& curve : v_.curves) alongRays(curve, centre, kAll, visit);
}

}  // namespace haptic
