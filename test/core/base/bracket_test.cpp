// Oracle: roots that are known in closed form, and the order of convergence.
#include "haptic_core/base/bracket.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic {
namespace bracket_test {

/// Evaluations until |f| is below `enough`; the root in x.
template <class F>
int solve(F&& f, double low, double high, double enough, double& x) {
  Bracket bracket(low, f(low), high, f(high));
  for (int i = 1; i <= 200; ++i) {
    x = bracket.guess();
    const double value = f(x);
    if (std::abs(value) <= enough) return i;
    bracket.take(x, value);
  }
  return 201;
}

TEST(Bracket, TakesOneEvaluationOfALine) {
  double x = 0;
  EXPECT_EQ(solve([](double t) { return 3 * t - 1; }, 0, 1, 1e-15, x), 1);
  EXPECT_NEAR(x, 1.0 / 3, 1e-15);
}

/// Order 1.7: from an error of a tenth 1e-14 is five steps away; an end that always counts half needs one for each bit.
TEST(Bracket, ConvergesFasterThanHalving) {
  double x = 0;
  EXPECT_LE(solve([](double t) { return std::exp(t) - 2; }, 0, 1, 1e-14, x), 7);
  EXPECT_NEAR(x, std::log(2.0), 1e-14);
  EXPECT_LE(solve([](double t) { return t * t * t - 0.5; }, 0, 1, 1e-14, x), 9);
  EXPECT_NEAR(x, std::cbrt(0.5), 1e-14);
}

/// A kink, a plateau before a jump, a root of third order: no end stays for ever.
TEST(Bracket, EndsWhereTheFunctionIsNotSmooth) {
  double x = 0;
  EXPECT_LE(solve([](double t) { return t < 0.9 ? 0.01 * (t - 0.9) : 100 * (t - 0.9); }, 0, 1, 1e-12, x), 20);
  EXPECT_NEAR(x, 0.9, 1e-9);
  Bracket jump(0, -1, 1, 1);
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double t = jump.guess(), f = t < 0.37 ? -1 : 1;
    (f > 0 ? high : low) = t;
    jump.take(t, f);
  }
  EXPECT_LT(high - low, 1e-6);
  EXPECT_LE(solve([](double t) { return std::pow(t - 0.3, 3); }, 0, 1, 1e-15, x), 100);
  EXPECT_NEAR(x, 0.3, 1.1e-5);
}

TEST(Bracket, KeepsAwayFromTheEndsByItsMargin) {
  const Bracket bracket(0, -1, 1, 1e9);
  EXPECT_NEAR(bracket.guess(), 0, 1e-8);
  EXPECT_EQ(bracket.guess(0.1), 0.1);
}

}  // namespace bracket_test
}  // namespace haptic
