/// The heights between which the outline of two rods' common section keeps its kind, and the section's
/// moments are smooth.
///
/// A rim is the circle in which a rod's side ends: in a plane along both axes two points. The outline changes
/// where one of them crosses the other's sides (a polynomial of degree 4 in the height), its end planes or
/// the circles about its ends (degree 2), and where a circle about an end touches the other's sides, end
/// planes or circles (degree 2, since the squared half widths differ by a linear function). Squaring makes
/// double roots of such as nearly meet, so that each root is polished by Newton's method on the equation
/// before it was squared. A root counts where its point lies on both outlines.
///
/// Heights at which the half widths together reach from one axis to the other bound all: without them a
/// shallow contact loses roots among those of the whole rods.
#pragma once
#include "haptic_core/geometry/volume/rod_pair.h"

namespace haptic {

/// Heights over the lowest plane, in order; the first and the last bound V.
struct RodBreaks {
  static constexpr int kMost = 48;  ///< breaks between the bounds

  double over[kMost + 2];  ///< [m]
  int count = 0;           ///< after `find` at least 2

  void find(const RodPair& pair) noexcept;  ///< (in realtime)
};

}  // namespace haptic
