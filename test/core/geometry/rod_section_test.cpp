// Outlines of two rods' sections, and integrals over their arcs.
#include "haptic_core/geometry/volume/rod_section.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "../../benchmark/shapes_pairs.h"
#include "haptic_core/geometry/volume/arc_integrals.h"
#include "haptic_core/geometry/volume/rod_breaks.h"

namespace haptic {
namespace rod_section_test {

using bench::RodKinds;
using bench::RodPose;
using bench::RodPoses;
constexpr double kEps = std::numeric_limits<double>::epsilon();

/// ∫ (1 − cos θ)ᵏ from −φ to φ by Simpson's rule, whose error is below 1e-19 with so many steps.
double arcIntegral(int k, long double angle) {
  constexpr int kSteps = 40000;
  long double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const long double s = std::sin(angle * (2.0L * i / kSteps - 1) / 2);
    sum += (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2) * std::pow(2 * s * s, static_cast<long double>(k));
  }
  return static_cast<double>(sum * 2 * angle / (3 * kSteps));
}

TEST(ArcIntegrals, AreThoseOfSimpsonsRule) {
  constexpr double h = 0.7;
  for (const double angle : {1e-6, 1e-3, 0.1, 0.299, 0.3, 0.8, 1.2, M_PI / 2}) {
    const double chord = 2 * h * std::sin(angle), sum = 2 * h * std::cos(angle);
    const ArcIntegrals k(lanes(chord), lanes(chord * chord), lanes(sum), lanes(h));
    const double found[] = {k.k0[0], k.k1[0], k.k2[0], k.k3[0]};
    // The cosine's rounding is one of q, which counts four times in the last.
    for (int i = 0; i < 4; ++i) {
      const double exact = h * arcIntegral(i, angle);
      EXPECT_NEAR(found[i], exact, 30 * kEps * exact) << i << " at " << angle;
    }
  }
}

using Names = std::vector<std::tuple<int, int, int, int, int, int>>;

Names namesOf(const RodOutline& outline) {
  Names names;
  for (int i = 0; i < outline.count; ++i) {
    const RodOutline::Piece& p = outline.piece[i];
    names.emplace_back(p.rod, p.line, p.from.other, p.from.way, p.to.other, p.to.way);
  }
  return names;
}

/// Moments are taken of the outline that a piece between two breaks has in its middle. Shorter pieces than this share of the heights
/// may lie between breaks that are not resolved.
TEST(RodSection, HasOneOutlineBetweenBreaks) {
  constexpr double kResolved = 1e-5;
  int compared = 0;
  for (const RodKinds kinds : {RodKinds::kCylinders, RodKinds::kCapsules, RodKinds::kBoth}) {
    RodPoses poses(kinds, 31);
    for (int i = 0; i < 300; ++i) {
      const RodPose pose = poses.next();
      const Rod A = pose.rod(0), B = pose.rod(1);
      RodPair pair;
      if (!pair.place(A, B, pose.X_AB)) continue;
      RodBreaks breaks;
      breaks.find(pair);
      for (int k = 0; k + 1 < breaks.count; ++k) {
        const double from = breaks.over[k], length = breaks.over[k + 1] - from;
        if (length < kResolved * pair.width) continue;
        RodSection section(pair);
        section.find(pair.heightAt(from + 0.5 * length));
        const Names middle = namesOf(section.outline());
        for (const double t : {0.01, 0.2, 0.8, 0.99}) {
          section.find(pair.heightAt(from + t * length));
          EXPECT_EQ(namesOf(section.outline()), middle) << "pose " << i << " piece " << k << " at " << t;
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 6000);
}

}  // namespace rod_section_test
}  // namespace haptic
