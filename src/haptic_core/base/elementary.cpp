#include "haptic_core/base/elementary.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

namespace haptic::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity(),
                 kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kExponentBias = 1023, kFractionBits = 52;

std::uint64_t bitsOf(double x) {
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}
double fromBits(std::uint64_t bits) {
  double x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}
/// 2ⁿ, -1022 ≤ n ≤ 1023.
double powerOfTwo(int n) {
  return fromBits(static_cast<std::uint64_t>(n + kExponentBias) << kFractionBits);
}
/// x 2ⁿ, |n| ≤ 2044: in two factors, for neither leaves the range.
double scaled(double x, int n) {
  return x * powerOfTwo(n / 2) * powerOfTwo(n - n / 2);
}

/// A number as the sum of two doubles, `low` below half a unit of `high`.
struct Two {
  double high, low;
};
/// a + b exactly (D. Knuth).
Two sumOf(double a, double b) {
  const double s = a + b, of_b = s - a;
  return {s, (a - (s - of_b)) + (b - of_b)};
}
/// The upper 26 bits of a number: its square is exact.
double upper(double x) {
  return fromBits(bitsOf(x) & ~std::uint64_t{0x7ffffff});
}
/// a b exactly (T. Dekker, here with halves by bits: no overflow).
Two productOf(double a, double b) {
  const double p = a * b, a0 = upper(a), b0 = upper(b), a1 = a - a0, b1 = b - b0;
  return {p, ((a0 * b0 - p) + a0 * b1 + a1 * b0) + a1 * b1};
}

/// Nearest integer, |x| < 2⁵¹: there the sum with 1.5·2⁵² keeps no fraction.
double nearest(double x) {
  return (x + 0x1.8p52) - 0x1.8p52;
}

// ---- angles ----

constexpr double kQuarterPi = 0x1.921fb54442d18p-1;
/// k π/4 in two doubles.
constexpr Two kEighths[5] = {{0, 0},
                             {kQuarterPi, 0x1.1a62633145c07p-55},
                             {2 * kQuarterPi, 0x1.1a62633145c07p-54},
                             {0x1.2d97c7f3321d2p+1, 0x1.a79394c9e8a0ap-54},
                             {4 * kQuarterPi, 0x1.1a62633145c07p-53}};

/// Below it an angle is reduced by four parts of π/2, of which three are short enough for exact products.
constexpr double kLargeAngle = 0x1p20;
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
constexpr double kHalfPi[4] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69, 0x1.b839a252049c1p-104};

/// Bits of 2/π behind the point, after one word of zeros.
constexpr std::uint64_t kTwoOverPiBits[] = {0,
                                            0xa2f9836e4e441529,
                                            0xfc2757d1f534ddc0,
                                            0xdb6295993c439041,
                                            0xfe5163abdebbc561,
                                            0xb7246e3a424dd2e0,
                                            0x06492eea09d1921c,
                                            0xfe1deb1cb129a73e,
                                            0xe88235f52ebb4484,
                                            0xe99c7026b45f7e41,
                                            0x3991d639835339f4,
                                            0x9c845f8bbdf9283b,
                                            0x1ff897ffde05980f,
                                            0xef2f118b5a0a6d1f,
                                            0x6d367ecf27cb09b7,
                                            0x4f463f669e5fea2d,
                                            0x7527bac7ebe5f17b,
                                            0x3d0739f78a5292ea,
                                            0x6bfb5fb11f8d5d08,
                                            0x56033046fc7b6bab};

/// An angle as a multiple of π/2 and a rest within ±π/4.
struct Reduced {
  Two rest;
  unsigned quadrant;  ///< modulo 4
};

/// |x| ≥ 2²⁰ (Payne and Hanek): x = m 2ᵉ. Of 2/π only the bits matter that give x·2/π modulo 4: 192 of them,
/// from the one that e moves to weight 2. The nearest that a double comes to a multiple of π/2 is 2⁻⁶¹, the
/// bits left out are worth 2⁻¹³⁷.
Reduced reducedLarge(double x) {
  __extension__ using Wide = unsigned __int128;
  const std::uint64_t bits = bitsOf(x);
  const int e = static_cast<int>(bits >> kFractionBits & 0x7ff) - kExponentBias - kFractionBits;
  const std::uint64_t m = (bits & ((std::uint64_t{1} << kFractionBits) - 1)) | std::uint64_t{1}
                                                                                   << kFractionBits;
  const int first = 64 + e - 2, word = first / 64, shift = first % 64;
  const auto window = [&](int i) {
    const std::uint64_t* w = kTwoOverPiBits + word + i;
    return shift ? w[0] << shift | w[1] >> (64 - shift) : w[0];
  };
  const Wide low = Wide{m} * window(2), middle = Wide{m} * window(1) + (low >> 64),
             high = Wide{m} * window(0) + (middle >> 64);
  std::uint64_t a = static_cast<std::uint64_t>(high), b = static_cast<std::uint64_t>(middle),
                c = static_cast<std::uint64_t>(low);
  unsigned quadrant = static_cast<unsigned>(a >> 62);
  a = a << 2 | b >> 62, b = b << 2 | c >> 62, c <<= 2;
  const bool negative = a >> 63;  // beyond a half: from the next multiple down
  if (negative) {
    ++quadrant;
    c = ~c + 1;
    b = ~b + (c == 0);
    a = ~a + (b == 0 && c == 0);
  }
  int exponent = 0;  // the first word that is not 0 comes to the front, then its first bit
  while (a == 0) a = b, b = c, c = 0, exponent -= 64;
  const int zeros = __builtin_clzll(a);
  if (zeros) a = a << zeros | b >> (64 - zeros), b = b << zeros | c >> (64 - zeros);
  exponent -= zeros;
  const double h = static_cast<double>(a >> 11) * powerOfTwo(exponent - 53),
               l = static_cast<double>((a & 0x7ff) << 42 | b >> 22) * powerOfTwo(exponent - 106);
  const Two p = productOf(h, 2 * kQuarterPi);
  const Two rest = sumOf(p.high, p.low + (h * kEighths[2].low + l * 2 * kQuarterPi));
  const bool flip = negative != (x < 0);
  return {{flip ? -rest.high : rest.high, flip ? -rest.low : rest.low},
          (x < 0 ? 0u - quadrant : quadrant) & 3};
}

Reduced reduced(double x) {
  if (std::fabs(x) <= kQuarterPi) return {{x, 0}, 0};
  if (!(std::fabs(x) < kLargeAngle)) return x - x == 0 ? reducedLarge(x) : Reduced{{kNaN, kNaN}, 0};
  const double n = nearest(x * kTwoOverPi);
  const unsigned quadrant = static_cast<unsigned>(static_cast<int>(n)) & 3;
  const Two a = sumOf(x - n * kHalfPi[0], -(n * kHalfPi[1]));
  // A rest that cancelled further needs more of π.
  constexpr double kCancelled = 0x1p-27;
  if (std::fabs(a.high) > kCancelled) return {sumOf(a.high, a.low - n * kHalfPi[2]), quadrant};
  const Two b = sumOf(a.high, -(n * kHalfPi[2]));
  return {sumOf(b.high, (a.low + b.low) - n * kHalfPi[3]), quadrant};
}

/// sin and cos within ±π/4. The polynomials' errors are 2⁻⁵⁷ and 2⁻⁶³ of the result.
double sineOf(const Two& r) {
  const double z = r.high * r.high, z2 = z * z, v = z * r.high;
  const double p = (0x1.111111110f73p-7 + z * -0x1.a01a019be9207p-13) +
                   z2 * ((0x1.71de355529ee2p-19 + z * -0x1.ae5e4b825a19ep-26) + z2 * 0x1.5d8b528d95491p-33);
  return r.high + (v * (-0x1.5555555555548p-3 + z * p) + (r.low - 0.5 * z * r.low));
}
double cosineOf(const Two& r) {
  const double z = r.high * r.high, z2 = z * z, half = 0.5 * z, w = 1 - half;
  const double p = (0x1.555555555554bp-5 + z * -0x1.6c16c16c15p-10) +
                   z2 * ((0x1.a01a019c8bab3p-16 + z * -0x1.27e4f7ee47df7p-22) +
                         z2 * (0x1.1ee9d927f1c61p-29 + z * -0x1.8fa4f71df5a24p-37));
  return w + (((1 - w) - half) + (z2 * p - r.high * r.low));
}

/// (atan t - t)/t³ by z = t², |t| ≤ tan π/8; error 2⁻⁵⁹ of the angle.
double arcTangentTail(double z) {
  const double z2 = z * z, z4 = z2 * z2;
  const double low = (-0x1.555555555553dp-2 + z * 0x1.9999999995869p-3) +
                     z2 * (-0x1.24924922ad548p-3 + z * 0x1.c71c70e60a38ap-4);
  const double middle = (-0x1.745cf8db98b52p-4 + z * 0x1.3b11190720a43p-4) +
                        z2 * (-0x1.10ebb6fb15ee9p-4 + z * 0x1.df0f32a58aa23p-5);
  const double high = (-0x1.9cd2338800324p-5 + z * 0x1.37d4037da91c8p-5) + z2 * -0x1.256635f594a4fp-6;
  return low + z4 * (middle + z4 * high);
}

/// (asin s - s)/s³ by z = s², |s| ≤ 1/2; error 2⁻⁶² of the angle.
double arcSineTail(double z) {
  const double z2 = z * z, z4 = z2 * z2;
  const double low = (0x1.5555555555553p-3 + z * 0x1.33333333339e9p-4) +
                     z2 * (0x1.6db6db6d4c426p-5 + z * 0x1.f1c71ca6e82f5p-6);
  const double middle = (0x1.6e8b9b1859061p-6 + z * 0x1.1c4f829139011p-6) +
                        z2 * (0x1.c9812dd346d3ep-7 + z * 0x1.7ba167d47b131p-7);
  const double high = (0x1.36d5782d86157p-7 + z * 0x1.47b35864fed1dp-7) +
                      z2 * (0x1.74ffd64642298p-11 + z * 0x1.95bfb3544a98ap-6) +
                      z4 * (-0x1.ab2fcef36119cp-6 + z * 0x1.1343dfaf692f6p-5);
  return low + z4 * (middle + z4 * high);
}

/// asin √((1 - a)/2) for a in [1/2, 1]: half the arc cosine of a.
Two halfArcCosine(double a) {
  const double z = 0.5 * (1 - a), s = std::sqrt(z);
  if (s == 0) return {0, 0};
  const Two square = productOf(s, s);
  const double root_rest = ((z - square.high) - square.low) / (2 * s);
  return {s, root_rest + s * z * arcSineTail(z)};
}

// ---- exponentials ----

constexpr double kLogTwo[2] = {0x1.62e42feep-1, 0x1.a39ef35793c76p-33};  ///< ln 2; the first with 32 bits
constexpr double kPerLogTwo = 0x1.71547652b82fep+0;

/// n and x - n ln 2, within ±ln(2)/2.
struct Exponent {
  int n;
  Two rest;
  explicit Exponent(double x)
      : n(static_cast<int>(nearest(x * kPerLogTwo))), rest(sumOf(x - n * kLogTwo[0], -(n * kLogTwo[1]))) {}
};

/// (eʳ - 1 - r - r²/2)/r³ by its series, |r| ≤ ln(2)/2: the next term is below 2⁻⁶⁰.
double exponentialTail(double r) {
  const double r2 = r * r, r4 = r2 * r2;
  const double low = (1.0 / 6 + r * (1.0 / 24)) + r2 * (1.0 / 120 + r * (1.0 / 720));
  const double middle = (1.0 / 5040 + r * (1.0 / 40320)) + r2 * (1.0 / 362880 + r * (1.0 / 3628800));
  const double high =
      (1.0 / 39916800 + r * (1.0 / 479001600)) + r2 * (1.0 / 6227020800 + r * (1.0 / 87178291200));
  return low + r4 * (middle + r4 * high);
}

/// ln x + n ln 2, 0 < x < ∞. With x = 2ᵏ(1 + f) and s = f/(2 + f), ln(1 + f) = f - f²/2 + s(f²/2 + R), R =
/// 2/3 s² + 2/5 s⁴ + … by a polynomial of s², error 2⁻⁵⁹ of the logarithm.
double logOf(const Two& of, int n) {
  double x = of.high;
  if (x < std::numeric_limits<double>::min()) x *= 0x1p54, n -= 54;
  const std::uint64_t root_half = bitsOf(0.70710678118654752), bits = bitsOf(x);
  const int k = static_cast<int>(static_cast<std::int64_t>(bits - root_half) >> kFractionBits);
  n += k;
  const double m = fromBits(bits - (static_cast<std::uint64_t>(k) << kFractionBits));  // in [√½, √2)
  const double f = m - 1, s = f / (2 + f), z = s * s, z2 = z * z;
  const double R =
      z * ((0x1.5555555555592p-1 + z * 0x1.999999997ff18p-2) +
           z2 * ((0x1.24924941e16f9p-2 + z * 0x1.c71c521433406p-3) +
                 z2 * ((0x1.74663cf5724eep-3 + z * 0x1.39a1e7a63de58p-3) + z2 * 0x1.2f03cafa490e3p-3)));
  const double f0 = upper(f), tail = of.low == 0 ? 0 : of.low / of.high;
  const Two a = sumOf(n * kLogTwo[0], f), b = sumOf(a.high, -0.5 * f0 * f0);
  return b.high +
         ((s * (0.5 * f * f + R) - 0.5 * (f + f0) * (f - f0)) + (n * kLogTwo[1] + (a.low + b.low)) + tail);
}

}  // namespace

SineCosine sinCos(double x) noexcept {
  const Reduced r = reduced(x);
  const double s = sineOf(r.rest), c = cosineOf(r.rest);
  switch (r.quadrant) {
    case 0:
      return {x == 0 ? x : s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double sin(double x) noexcept {
  const Reduced r = reduced(x);
  const double value = r.quadrant & 1 ? cosineOf(r.rest) : x == 0 ? x : sineOf(r.rest);
  return r.quadrant & 2 ? -value : value;
}

double cos(double x) noexcept {
  const Reduced r = reduced(x);
  const double value = r.quadrant & 1 ? sineOf(r.rest) : cosineOf(r.rest);
  return r.quadrant == 1 || r.quadrant == 2 ? -value : value;
}

double asin(double x) noexcept {
  const double a = std::fabs(x);
  if (!(a <= 1)) return kNaN;
  if (a <= 0.5) return x == 0 ? x : x + x * (x * x) * arcSineTail(x * x);
  const Two half = halfArcCosine(a), sum = sumOf(kEighths[2].high, -2 * half.high);
  return std::copysign(sum.high + (sum.low + (kEighths[2].low - 2 * half.low)), x);
}

double acos(double x) noexcept {
  const double a = std::fabs(x);
  if (!(a <= 1)) return kNaN;
  if (a <= 0.5) {
    const Two sum = sumOf(kEighths[2].high, -x);
    return sum.high + (sum.low + (kEighths[2].low - x * (x * x) * arcSineTail(x * x)));
  }
  const Two half = halfArcCosine(a);
  if (x > 0) return 2 * (half.high + half.low);
  const Two sum = sumOf(kEighths[4].high, -2 * half.high);
  return sum.high + (sum.low + (kEighths[4].low - 2 * half.low));
}

// The quotient of the lesser by the greater coordinate and, beyond tan π/8, that of their difference by their
// sum: each with the rest of its division.
double atan2(double y, double x) noexcept {
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  double lesser = std::fabs(y), greater = std::fabs(x);
  const bool steep = lesser > greater;
  if (steep) std::swap(lesser, greater);
  if (greater == kInfinity) lesser = lesser == kInfinity, greater = 1;
  if (greater == 0) greater = 1;
  constexpr double kHuge = 0x1p500, kTiny = 0x1p-400;
  if (greater > kHuge) lesser *= 1 / kHuge, greater *= 1 / kHuge;
  if (greater < kTiny) lesser *= kHuge, greater *= kHuge;

  const bool eighth = lesser > 0.41421356237309503 * greater;
  Two above{lesser, 0}, below{greater, 0};
  if (eighth) above = sumOf(greater, -lesser), below = sumOf(greater, lesser);
  const double inverse = 1 / below.high, t = above.high / below.high, z = t * t;
  constexpr double kStraight =
      0x1p-30;  // below, t³/3 is nothing beside t, and products with its rest may underflow
  if (t < kStraight && !eighth && !steep && !std::signbit(x)) return std::copysign(t, y);
  const Two product = productOf(t, below.high);
  const double rest = (((above.high - product.high) - product.low) + (above.low - t * below.low)) * inverse;
  const double tail = (rest - rest * z) + t * z * arcTangentTail(z);
  int base = eighth ? 1 : 0;
  bool back = eighth;
  if (steep) base = 2 - base, back = !back;
  if (std::signbit(x)) base = 4 - base, back = !back;
  if (base == 0) return std::copysign(t + tail, y);
  const Two sum = sumOf(kEighths[base].high, back ? -t : t);
  return std::copysign(sum.high + (sum.low + (kEighths[base].low + (back ? -tail : tail))), y);
}

double exp(double x) noexcept {
  constexpr double kMost = 709.79, kLeast = -745.14;  // beyond: infinite, 0
  if (x > kMost) return kInfinity;
  if (x < kLeast) return 0;
  if (std::isnan(x)) return x;
  const Exponent e(x);
  const double r = e.rest.high;
  const Two sum = sumOf(1, r);
  return scaled(sum.high + (r * r * (0.5 + r * exponentialTail(r)) + (sum.low + e.rest.low)), e.n);
}

double expm1(double x) noexcept {
  constexpr double kLarge = 40;  // beyond, 1 is less than half a unit of eˣ, and eˣ of 1
  if (x > kLarge) return exp(x);
  if (x < -kLarge) return -1;
  if (std::isnan(x) || std::fabs(x) < 0x1p-54) return x;
  const Exponent e(x);
  const double r = e.rest.high, r0 = upper(r), power = powerOfTwo(e.n);
  const double small =
      r * (r * r) * exponentialTail(r) + 0.5 * (r + r0) * (r - r0) + (e.rest.low + e.rest.low * r);
  const Two a = sumOf(power, -1), b = sumOf(a.high, power * r), c = sumOf(b.high, power * (0.5 * r0 * r0));
  return c.high + (power * small + (a.low + b.low + c.low));
}

double log(double x) noexcept {
  if (std::isnan(x) || x == kInfinity) return x;
  if (x <= 0) return x == 0 ? -kInfinity : kNaN;
  return logOf({x, 0}, 0);
}

double asinh(double x) noexcept {
  const double a = std::fabs(x);
  if (!(a < kInfinity) || a < 0x1p-28) return x;
  if (a < 0.36) {  // (asinh x - x)/x³ by z = x², error 2⁻⁶⁵ of the result
    const double z = x * x, z2 = z * z, z4 = z2 * z2;
    const double low = (-0x1.5555555555555p-3 + z * 0x1.33333333331dbp-4) +
                       z2 * (-0x1.6db6db6d9abcfp-5 + z * 0x1.f1c71c5fe9ce8p-6);
    const double middle = (-0x1.6e8b9fa60528cp-6 + z * 0x1.1c4e658b50e11p-6) +
                          z2 * (-0x1.c98b51cb4e492p-7 + z * 0x1.79d0b3cdd2868p-7);
    const double high = (-0x1.39c62ec1eb4a8p-7 + z * 0x1.e256862d1d35fp-8) + z2 * -0x1.f502c82a16c5ap-9;
    return x + x * z * (low + z4 * (middle + z4 * high));
  }
  constexpr double kLarge = 0x1p28;  // beyond, 1 is nothing beside x²
  if (a > kLarge) return std::copysign(logOf({a, 0}, 1), x);
  const Two square = productOf(a, a), u = sumOf(1, square.high);
  const double root = std::sqrt(u.high);
  const Two back = productOf(root, root), w = sumOf(a, root);
  const double rest = (((u.high - back.high) - back.low) + (u.low + square.low)) / (2 * root);
  return std::copysign(logOf(sumOf(w.high, w.low + rest), 0), x);
}

// A third of the bits is a root to 3 %; Halley's iteration cubes the error, twice; once more from 26 bits,
// whose square is exact.
double cbrt(double x) noexcept {
  double a = std::fabs(x);
  if (!(a < kInfinity) || a == 0) return x;
  const bool subnormal = a < std::numeric_limits<double>::min();
  if (subnormal) a *= 0x1p54;
  constexpr std::uint64_t kTwoThirds =
      static_cast<std::uint64_t>((682 - 0.033) * 0x1p52);  // of the exponent's bias
  double t = fromBits(bitsOf(a) / 3 + kTwoThirds);
  for (int i = 0; i < 2; ++i) {
    const double q = a / (t * t);
    t += t * ((q - t) / (t + t + q));
  }
  t = upper(t);
  const double q = a / (t * t);
  t += t * ((q - t) / (t + t + q));
  return std::copysign(subnormal ? t * 0x1p-18 : t, x);
}

double hypot(double x, double y) noexcept {
  double greater = std::fabs(x), lesser = std::fabs(y);
  if (greater == kInfinity || lesser == kInfinity) return kInfinity;
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  if (lesser > greater) std::swap(lesser, greater);
  if (lesser == 0) return greater;
  constexpr double kHuge = 0x1p500, kTiny = 0x1p-400;
  double scale = 1;
  if (greater > kHuge) scale = 0x1p600;
  if (greater < kTiny) scale = 0x1p-600;
  greater /= scale, lesser /= scale;
  const Two a = productOf(greater, greater), b = productOf(lesser, lesser), sum = sumOf(a.high, b.high);
  const double root = std::sqrt(sum.high);
  const Two square = productOf(root, root);
  const double rest = ((sum.high - square.high) - square.low) + (sum.low + (a.low + b.low));
  return (root + rest / (2 * root)) * scale;
}

}  // namespace haptic::elementary
