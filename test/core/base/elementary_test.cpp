// Elementary functions against those of 113 bits.
#include "haptic_core/base/elementary.h"

#include <gtest/gtest.h>
#include <quadmath.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>

namespace haptic {
namespace {

using Quad = __float128;

/// Numbers by our own steps: every run draws the same.
class Draw {
 public:
  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15;
    std::uint64_t z = state_;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
  }
  double between(double a, double b) { return a + (b - a) * static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// ±m 2ᵉ, e in [least, most].
  double binade(int least, int most) {
    const double m = 1 + static_cast<double>(bits() >> 12) * 0x1p-52;
    const int e = least + static_cast<int>(bits() % static_cast<unsigned>(most - least + 1));
    return std::ldexp(bits() & 1 ? m : -m, e);
  }

 private:
  std::uint64_t state_ = 1;
};

/// Distance of `got` from `exact`, in units in the last place of `exact` (at least the smallest subnormal).
double ulps(double got, Quad exact) {
  if (isnanq(exact)) return std::isnan(got) ? 0 : 1e300;
  if (std::fabs(got) == INFINITY || isinfq(exact)) {
    const double nearest = static_cast<double>(exact);
    return got == nearest ? 0 : 1e300;
  }
  const int exponent = exact == 0 ? -1074 : std::max(-1074, ilogbq(exact) - 52);
  return static_cast<double>(fabsq(got - exact) / ldexpq(1, exponent));
}

constexpr int kDraws = 20000;

/// The largest error over `draw`'s arguments.
double worst(double (*ours)(double), Quad (*exact)(Quad), const std::function<double()>& draw,
             double& where) {
  double most = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw(), error = ulps(ours(x), exact(x));
    if (error > most) most = error, where = x;
  }
  return most;
}

constexpr double kBound = 0.8;  // [ulp], as the header states

void within(const char* name, double (*ours)(double), Quad (*exact)(Quad),
            const std::function<double()>& draw, double bound = kBound) {
  double where = 0;
  const double most = worst(ours, exact, draw, where);
  EXPECT_LT(most, bound) << name << " at " << std::hexfloat << where;
  EXPECT_GT(most, 0.45) << name << ": half a unit is what rounding alone leaves";
}

double sineOfBoth(double x) {
  return elementary::sinCos(x).sine;
}
double cosineOfBoth(double x) {
  return elementary::sinCos(x).cosine;
}

TEST(Elementary, AnglesOfAnySize) {
  Draw draw;
  for (const auto& range : {std::pair(-1, 1), {-30, -1}, {1, 19}, {18, 22}, {20, 60}, {60, 1023}}) {
    const auto of = [&] { return draw.binade(range.first, range.second); };
    if (range.first != -30) within("cos", elementary::cos, cosq, of);
    within("sin", elementary::sin, sinq, of);
    within("sine of both", sineOfBoth, sinq, of);
    if (range.first != -30) within("cosine of both", cosineOfBoth, cosq, of);
  }
}

// There the rest cancels most: the nearest doubles to k π/2, and the double that comes nearest of all
// (6381956970095103·2⁷⁹⁷, W. Kahan).
TEST(Elementary, AnglesNextToMultiplesOfAQuarterTurn) {
  Draw draw;
  double most = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double k = std::floor(std::ldexp(draw.between(1, 2), static_cast<int>(draw.bits() % 40)));
    const double x = static_cast<double>(k * asinq(1));
    most = std::max({most, ulps(elementary::sin(x), sinq(x)), ulps(elementary::cos(x), cosq(x))});
  }
  const double hardest = 6381956970095103 * 0x1p797;
  most = std::max(
      {most, ulps(elementary::sin(hardest), sinq(hardest)), ulps(elementary::cos(hardest), cosq(hardest))});
  EXPECT_LT(most, kBound);
}

TEST(Elementary, ArcsOfSinesAndCosines) {
  Draw draw;
  for (const auto& function : {std::pair(elementary::asin, asinq), {elementary::acos, acosq}}) {
    within("between", function.first, function.second, [&] { return draw.between(-1, 1); });
    within("near the ends", function.first, function.second,
           [&] { return std::copysign(1 - std::fabs(draw.binade(-50, -2)), draw.between(-1, 1)); });
  }
  within("asin of small", elementary::asin, asinq, [&] { return draw.binade(-26, -2); });
}

TEST(Elementary, AnglesOfPoints) {
  Draw draw;
  for (const auto& range : {std::pair(-2, 2), {-12, 12}, {-300, 300}, {-1022, 1023}, {-1074, -1000}}) {
    double most = 0;
    for (int i = 0; i < kDraws; ++i) {
      const double y = draw.binade(range.first, range.second), x = draw.binade(range.first, range.second);
      const double error = ulps(elementary::atan2(y, x), atan2q(y, x));
      most = std::max(most, error);
      ASSERT_LT(error, kBound) << std::hexfloat << y << ' ' << x;
    }
    EXPECT_GT(most, 0.45);
  }
}

TEST(Elementary, ExponentialsAndLogarithms) {
  Draw draw;
  within("exp", elementary::exp, expq, [&] { return draw.between(-708, 709.78); });
  within("exp of small", elementary::exp, expq, [&] { return draw.binade(-20, 1); });
  within(
      "exp, subnormal", elementary::exp, expq, [&] { return draw.between(-745.2, -708); }, 1.0);
  for (const auto& range : {std::pair(-3.0, 3.0), {-50.0, 50.0}, {-1.1, -0.3}, {0.3, 1.1}})
    within("expm1", elementary::expm1, expm1q, [&] { return draw.between(range.first, range.second); });
  within("expm1 of small", elementary::expm1, expm1q, [&] { return draw.binade(-53, 0); });
  within("log", elementary::log, logq, [&] { return std::fabs(draw.binade(-1074, 1023)); });
  within("log about 1", elementary::log, logq, [&] { return draw.between(0.5, 2); });
  within("log beside 1", elementary::log, logq, [&] { return 1 + draw.binade(-40, -2); });
  within("asinh", elementary::asinh, asinhq, [&] { return draw.binade(-27, 60); });
  within("asinh, large", elementary::asinh, asinhq, [&] { return draw.binade(20, 1023); });
  within("asinh about 0", elementary::asinh, asinhq, [&] { return draw.between(-2, 2); });
}

TEST(Elementary, RootsAndLengths) {
  Draw draw;
  within("cbrt", elementary::cbrt, cbrtq, [&] { return draw.binade(-1074, 1023); });
  for (const auto& range : {std::pair(-1, 1), {-20, 20}, {-1022, -900}, {900, 1022}}) {
    double most = 0;
    for (int i = 0; i < kDraws; ++i) {
      const double x = draw.binade(range.first, range.second), y = draw.binade(range.first, range.second);
      most = std::max(most, ulps(elementary::hypot(x, y), hypotq(x, y)));
    }
    EXPECT_LT(most, kBound) << range.first;
    EXPECT_GT(most, 0.45);
  }
}

/// Same bits: NaN equals NaN, and 0 is not -0.
bool same(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || (a == b && std::signbit(a) == std::signbit(b));
}

TEST(Elementary, SpecialValuesAreThoseOfC) {
  const double inf = INFINITY, least = 5e-324,
               values[] = {0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, inf, -inf, NAN, least, -least};
  struct Named {
    const char* name;
    double (*ours)(double);
    double (*theirs)(double);
  };
  for (const Named& f : {Named{"sin", elementary::sin, std::sin},
                         {"cos", elementary::cos, std::cos},
                         {"asin", elementary::asin, std::asin},
                         {"acos", elementary::acos, std::acos},
                         {"expm1", elementary::expm1, std::expm1},
                         {"asinh", elementary::asinh, std::asinh},
                         {"cbrt", elementary::cbrt, std::cbrt}}) {
    for (const double x : {0.0, -0.0, inf, -inf, static_cast<double>(NAN)})
      EXPECT_TRUE(same(f.ours(x), f.theirs(x))) << f.name << '(' << x << ") is " << f.ours(x);
  }
  for (const double x : {0.0, -0.0, 1.0, inf, static_cast<double>(NAN), -1.0})
    EXPECT_TRUE(same(elementary::log(x), std::log(x))) << x << ' ' << elementary::log(x);
  for (const double x : {0.0, -0.0, inf, -inf, static_cast<double>(NAN), 710.0, -746.0})
    EXPECT_TRUE(same(elementary::exp(x), std::exp(x))) << x << ' ' << elementary::exp(x);
  EXPECT_TRUE(std::isnan(elementary::asin(1.0000000000000002)) &&
              std::isnan(elementary::acos(-1.0000000000000002)));
  EXPECT_EQ(elementary::acos(1), 0);
  for (const double y : values) {
    for (const double x : values) {
      EXPECT_TRUE(same(elementary::atan2(y, x), std::atan2(y, x)))
          << y << ' ' << x << ' ' << elementary::atan2(y, x);
      EXPECT_TRUE(same(elementary::hypot(y, x), std::hypot(y, x)))
          << y << ' ' << x << ' ' << elementary::hypot(y, x);
    }
  }
}

}  // namespace
}  // namespace haptic
