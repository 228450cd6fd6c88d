/// When two shapes that move will touch: so that nothing fast passes through anything thin.
#pragma once
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// A shape under way: its pose at the start, and the constant twist of a point fixed to it.
struct ShapeMotion {
  Pose X_WS;        ///< at the start
  Vector3 p_W;      ///< the point that moves on a straight line, at the start: the centre of mass
  Twist V_W;        ///< at that point: [rad/s], [m/s]
  double reach = 0; ///< largest distance of the shape's points from it [m]

  Pose at(double t) const;  ///< X_WS after `t` [s]
};

/// First time in [0, h] at which the shapes come within `clearance` [m] of each other, or a little before; h where they do
/// not. Conservative advancement (Mirtich, Impulse-based dynamic
/// simulation of rigid body systems, 1996, section 2.3): the distance shrinks no faster than the relative speed along
/// its direction plus |ω × n| reach of both, so it may advance by distance over that rate. Never late. Shapes that already
/// touch give 0. `direction` starts the search and is left for the next. (in realtime)
double timeOfImpact(const ConvexShape& A, const ShapeMotion& a, const ConvexShape& B, const ShapeMotion& b,
                    double h, double clearance, Vector3& direction_A) noexcept;

/// Time in [from, h] up to which the shapes get no more than `depth` [m] deeper into each other than they are at `from`; `n_W` (unit, from
/// A to B, in W at `from`) points along their contact. No depth is more than the overlap along any direction, so that of two is looked at:
/// one turns with A, the other with B. At h first: a body that rolls, tips or turns away, however fast, has all the time. Else by secants
/// down to the time that the approach rate leaves, which may be early. The depth holds at the time that it returns, not at all before. (in
/// realtime)
double timeOfDepth(const ConvexShape& A, const ShapeMotion& a, const ConvexShape& B, const ShapeMotion& b,
                   double from, double h, double depth, const Vector3& n_W) noexcept;

/// When two shapes touch, and when they are too deep [s].
struct DepthTimes {
  double touch = 0, deep = 0;  ///< h where they do not
};

/// Both within [0, h]: `timeOfImpact`, then `timeOfDepth` along the direction in which they meet. `touching_W`: null, or the normal
/// (unit, from A to B, in W) of shapes that touch at 0 already. (in realtime)
DepthTimes timesOfDepth(const ConvexShape& A, const ShapeMotion& a, const ConvexShape& B, const ShapeMotion& b, double h,
                        double clearance, double depth, const Vector3* touching_W) noexcept;

/// Bound of the rate at which two moving shapes approach along the fixed unit direction n (from A to B, in W) [m/s].
double approachRate(const ShapeMotion& a, const ShapeMotion& b, const Vector3& n_W) noexcept;

}  // namespace haptic
