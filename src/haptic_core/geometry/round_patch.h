/// The patch of a contact with a ball, for what its moments do not tell: pressure that is clipped, friction that turns, ∫d².
///
/// The thickness of V is not piecewise linear, so there is no closed form for all of these. The part of the polyhedron's
/// surface in the ball, seen along n, is cut into the shares of its faces; on each the thickness is smooth. A share is
/// integrated on rays from a point inside it, by Gauss's rule over its boundary (8 points on a line and on each third of a
/// turn) and along the rays (8). Relative error of ∫ d² and of friction: 1e-12 where a ball shallower than a fifth of its
/// radius lies on one face, 1e-6 over edges and corners; where a pressure is clipped inside the patch 1e-3 of the clipped
/// part, continuous in the poses.
#pragma once
#include "haptic_core/geometry/ball_cut.h"
#include "haptic_core/geometry/gauss_legendre.h"

namespace haptic {

struct ContactVolume;
struct PartMoments;

/// V = ball ∩ polyhedron or ball ∩ ball as the last call of `contactVolume` left it in the workspace. Frame Q: the ball's
/// centre, the axes in which it was cut.
struct RoundVolume {
  /// A piece of a share's outline, in P's x and y [m].
  struct Curve {
    bool arc;              ///< an arc of an ellipse; else a line
    double from, sweep;    ///< of an arc: first angle, and angle swept [rad]
    Vector2 middle, x, y;  ///< arc: middle + x cos + y sin; line: middle + x t, t from 0 to 1
  };
  /// A face's part of the patch, seen along n.
  struct Share {
    int first, count;      ///< its curves
    Vector2 inside;        ///< a point of it
  };
  /// The plane of a face, in P.
  struct Plane {
    Vector3 normal;        ///< in P
    double offset;         ///< about P's origin [m]
  };

  bool filled = false;          ///< false: the workspace holds a polyhedron
  BallCut cut;                  ///< what the polyhedron's faces and the ball have in common
  Pose X_AQ;                    ///< of frame Q in A
  double sign = 1;              ///< -1: the polyhedron is B
  double radius = 0;            ///< of the ball [m]
  double other_radius = 0;      ///< of a second ball; 0: there are planes instead [m]
  Vector3 other_Q = Vector3::Zero();  ///< its centre
  bool axial = false;           ///< round about n through P's origin

  LoadedVector<PlaneMoments> parts;  ///< of the faces, while the contact is made
  LoadedVector<Curve> curves;   ///< scratch of RoundPatch
  LoadedVector<Share> shares;   ///< scratch of RoundPatch
  LoadedVector<Plane> planes;   ///< scratch of RoundPatch

  void reserve(int faces, int half_edges);  ///< set-up: room for a polyhedron of so many faces and half edges
};

/// Of `contact`, whose V is `volume`. (in realtime)
class RoundPatch {
 public:
  /// Its outline. The thickness is known after `fit`.
  RoundPatch(RoundVolume& volume, const ContactVolume& contact) noexcept;
  /// (in realtime) Scales the thickness so that its integral is the volume of the contact.
  RoundPatch& fit() noexcept;

  double reach() const noexcept;                      ///< largest |r| of the patch, within 2 % and not below it [m]
  double thickness(const Vector2& r) const noexcept;  ///< of V at r along n [m]; 0 outside
  /// Visits (r, weight [m²], d [m]) with Σ weight · d = Vol.
  template <class Visit>
  void eachSample(Visit&& visit) const noexcept;
  /// The same on rays from one point for all: a direction that turns about it is then constant on each.
  template <class Visit>
  void eachSampleAbout(const Vector2& centre, Visit&& visit) const noexcept;
  double thicknessSquared() const noexcept;           ///< ∫ d² dA [m⁴]

 private:
  struct Sphere {
    Vector2 middle;
    double radius, lowest, highest;                   ///< in P [m]
  };
  static Sphere sphereAt(const Vector3& centre_P, double radius) {
    return {centre_P.head<2>(), radius, centre_P.z() - radius, centre_P.z() + radius};
  }
  void addShare(const CutFace& face, const Matrix3& R_PQ, const Vector3& p_PQ) noexcept;
  void standIn() noexcept;
  double heightOver(const Vector2& r) const noexcept;
  double radial(double from, double to, double& square) const noexcept;
  template <class Visit>
  void alongRays(const RoundVolume::Curve& curve, const Vector2& centre, Visit&& visit) const noexcept;

  RoundVolume& v_;
  const ContactVolume& contact_;
  Sphere ball_, other_;
  double scale_ = 1, uniform_ = 0;  ///< of the thickness; in place of it, unless 0
};

template <class Visit>
void RoundPatch::alongRays(const RoundVolume::Curve& c, const Vector2& centre, Visit&& visit) const noexcept {
  const auto ray = [&](const Vector2& to, const Vector2& step, double weight) {
    const Vector2 a = to - centre;
    const double turn = v_.sign * weight * (a.x() * step.y() - a.y() * step.x());
    integrate(kGauss8, 0, 1, [&](double t, double w) {
      const Vector2 r = centre + t * a;
      visit(r, turn * t * w, thickness(r));
    });
  };
  if (!c.arc) {
    integrate(kGauss8, 0, 1, [&](double t, double w) { ray(c.middle + t * c.x, c.x, w); });
    return;
  }
  const int parts = c.sweep > 0 ? static_cast<int>(c.sweep / 2.1) + 1 : 0;  // a third of a turn each
  for (int i = 0; i < parts; ++i) {
    integrate(kGauss8, c.from + i * c.sweep / parts, c.from + (i + 1) * c.sweep / parts, [&](double angle, double w) {
      const double cosine = std::cos(angle), sine = std::sin(angle);
      ray(c.middle + cosine * c.x + sine * c.y, cosine * c.y - sine * c.x, w);
    });
  }
}

template <class Visit>
void RoundPatch::eachSample(Visit&& visit) const noexcept {
  for (const RoundVolume::Share& share : v_.shares) {
    for (int i = share.first; i < share.first + share.count; ++i) alongRays(v_.curves[i], share.inside, visit);
  }
}

template <class Visit>
void RoundPatch::eachSampleAbout(const Vector2& centre, Visit&& visit) const noexcept {
  for (const RoundVolume::Curve& curve : v_.curves) alongRays(curve, centre, visit);
}

}  // namespace haptic
