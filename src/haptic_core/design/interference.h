/// How near strings come to one another and to the grip, over certified cells of poses: a lower bound that holds at every pose, and a
/// pose that attains it up to a tolerance.
///
/// Two strings: the distance of two segments, in closed form. Between two poses of a cell points E + s (K - E), E' + t (K' - E')
/// move apart by s ΔK - t ΔK', with ΔK = Δp + ΔR k, |Δp| ≤ |w_p|, |ΔR k| ≤ φ |k| (pose_cell.h), s, t in [0, 1], so the distance changes by
/// at most |w_p| + φ (|k| + |k'|).
/// A string and the grip, taken for the ball about its origin on which the string's knot lies: the string enters the ball where
/// d · R k < 0. Its height d · R k over the tangent plane, per length of the string times |k|, changes by at most |k| (s/(l_min) + φ).
/// The least of a distance over many cells is bracketed by dividing the cell with the lowest bound until bound and value agree.
#pragma once
#include <vector>

#include "haptic_core/design/pose_cell.h"

namespace haptic {

/// The nearest that two strings, or a string and the grip, come.
struct Nearest {
  int first = 0, second = -1;        ///< strings; second -1: the grip
  double at_least = 0;               ///< bound that no pose of the cells falls below [m]
  double found = 0;                  ///< value at `at` [m]; at most the bound plus the tolerance, unless the bound of the work ended it
  Vector6 at = Vector6::Zero();      ///< a pose of the cells
};

/// Distance at a pose [m]: of two strings, or of a string and the grip (see above).
double stringDistance(const DeviceDef& def, const Vector6& at, int first, int second);

/// All pairs of strings that share neither exit nor knot, and each string with a knot away from the grip's origin; nearest first.
std::vector<Nearest> nearestOver(const DeviceDef& def, const std::vector<PoseCell>& cells, double tolerance = 2e-4);

}  // namespace haptic
