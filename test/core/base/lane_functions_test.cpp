// Elementary functions in lanes against those of one number in more bits.
#include "haptic_core/base/lane_functions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace lane_functions_test {

constexpr double kEps = std::numeric_limits<double>::epsilon();

TEST(LaneFunctions, SinesOfAQuarterTurn) {
  for (int i = 0; i <= 1000; i += 4) {
    const auto at = [i](int k) { return M_PI / 2 * std::min(1.0, std::pow((i + k) / 1000.0, 4)); };
    const LaneSineCosine found = quarterSineCosine(Lanes{at(0), at(1), at(2), at(3)});
    for (int k = 0; k < 4; ++k) {
      const long double x = at(k);
      EXPECT_NEAR(found.sine[k], static_cast<double>(std::sin(x)), 4 * kEps * std::sin(at(k)));
      EXPECT_NEAR(found.cosine[k], static_cast<double>(std::cos(x)), 4 * kEps);
    }
  }
}

/// Three doublings double the relative error of the cosine each time.
TEST(LaneFunctions, HyperbolicSines) {
  for (int i = 0; i <= 1000; i += 4) {
    const auto at = [i](int k) { return 4 * std::min(1.0, std::pow((i + k) / 1000.0, 2)); };
    const LaneSineCosine found = hyperbolicSineCosine(Lanes{at(0), at(1), at(2), at(3)});
    for (int k = 0; k < 4; ++k) {
      const long double x = at(k);
      EXPECT_NEAR(found.sine[k], static_cast<double>(std::sinh(x)), 16 * kEps * std::sinh(at(k)));
      EXPECT_NEAR(found.cosine[k], static_cast<double>(std::cosh(x)), 16 * kEps * std::cosh(at(k)));
    }
  }
}

}  // namespace lane_functions_test
}  // namespace haptic
