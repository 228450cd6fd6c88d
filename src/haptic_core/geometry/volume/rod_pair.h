/// Two rods seen in the planes along both of their axes.
///
/// Such a plane cuts a cylinder in a rectangle and a capsule in a stadium, about the rod's axis, of half
/// width √(r² − z²) at the height z over the axis. Heights are counted over the lowest plane that meets both
/// rods, and under the highest: the squared half widths are products of such heights, so that no digits
/// cancel where the rods only just meet.
///
/// Frame E, in A's frame: x along A's axis, y across, z the planes' normal. With B's axis b in A and s =
/// |(b_x, b_y)|, z = (−b_y, b_x, 0)/s: normal to A's axis exactly and to B's to rounding, whatever the angle;
/// below 8 ε z points along the shortest line between the axes, and where there is none it is any. A result
/// does not depend on which of the directions is taken.
#pragma once
#include <array>

#include "haptic_core/geometry/shapes/rod.h"

namespace haptic {

/// A plane's height over the lowest and under the highest plane that meets both rods [m]. Both, since one of
/// them may be tiny.
struct RodHeight {
  double over, under;  ///< their sum is `RodPair::width`
};

/// Two rods in frame E; index 0 is A, 1 is B.
struct RodPair {
  double radius[2], half[2];  ///< of the rods: radii and half lengths of the axes [m]
  bool round[2];              ///< capsules
  double cosine, sine;        ///< of the angle between the axes, both ≥ 0: B's axis is (cosine, sine, 0)
  /// Their reciprocals; of 0 a number so large that crossings lie beyond every end.
  double inverse_cosine, inverse_sine;
  Vector2 centre;     ///< of B, in E; A's is the origin [m]
  double distance;    ///< of B's axis along E's z [m]
  double low, width;  ///< the planes that meet both rods: z from `low` to `low + width` [m]
  double above[2], below[2];  ///< how far a rod reaches beyond these planes [m]
  Matrix3 R_AE;               ///< axes of E, whose origin is A's

  /// False: no plane along both axes meets both rods.
  bool place(const Rod& A, const Rod& B, const Pose& X_AB) noexcept;

  /// A vector from the frame of one rod, x along its axis and y across, to that of `to`; A's frame is E.
  Vector2 turned(int to, const Vector2& v) const {
    const double s = to == 1 ? -sine : sine;
    return {cosine * v.x() - s * v.y(), s * v.x() + cosine * v.y()};
  }
  /// Of the lower and the upper of two sides or ends.
  static double sign(int i) { return i & 1 ? 1 : -1; }
  /// Whether a rod's section is bounded by a straight line there: lines 0 and 1 are its sides, 2 and 3 its ends.
  bool isLine(int rod, int line) const { return line < 2 || !round[rod]; }
  /// Middle of an end of the other rod, in this rod's frame [m].
  Vector2 endSeenFrom(int rod, int end) const {
    const Vector2 along(sign(end) * half[1 - rod], 0);
    return rod == 0 ? Vector2(centre + turned(0, along)) : turned(1, along - centre);
  }
  /// From the middle of an end of A to that of an end of B, in E [m].
  Vector2 betweenEnds(int of_A, int of_B) const { return endSeenFrom(0, of_B) - Vector2(sign(of_A) * half[0], 0); }
  /// Squared half width of a rod in a plane [m²].
  double square(int rod, const RodHeight& x) const { return (x.under + above[rod]) * (x.over + below[rod]); }
  /// Squared half width of A less that of B [m²]; linear in the height.
  double squareDifference(const RodHeight& x) const {
    return (above[0] - above[1]) * x.over + (below[0] - below[1]) * x.under + above[0] * below[0] -
           above[1] * below[1];
  }
  /// Of the plane that lies `over` the lowest [m].
  RodHeight heightAt(double over) const { return {over, width - over}; }
  /// z over A's axis [m].
  double z(const RodHeight& x) const { return low + x.over; }
  /// A direction along which B can leave A.
  struct Direction {
    Vector3 n_E;     ///< unit, on the side on which B lies
    double overlap;  ///< way along it until they are apart [m]; negative: a gap
  };
  using Directions = std::array<Direction, 4>;  ///< the normals of: both sides, A's side alone, A's ends, B's ends
  Directions directions() const noexcept;       ///< see above
  /// How far B has to move along unit n, in E, to leave A [m]; negative: a gap.
  double overlapAlong(const Vector3& n_E) const noexcept;
  /// A vector of A's frame, in E.
  Vector3 intoE(const Vector3& v_A) const { return {R_AE.col(0).dot(v_A), R_AE.col(1).dot(v_A), R_AE.col(2).dot(v_A)}; }
  /// Distance of the two axes, as pieces of line, in E's x and y [m]; 0 where they cross.
  double axisDistance() const noexcept;
};

}  // namespace haptic
