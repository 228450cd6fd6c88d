#include "haptic_core/geometry/volume/rod_integral.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/gauss_legendre.h"
#include "haptic_core/geometry/volume/section_moments.h"

namespace haptic {
namespace {

/// Axes at a smaller angle [sine] cross so far out that their parallelograms are not worth a rule of their
/// own.
constexpr double kCrossing = 1e-3;
/// Shares of the angles in which the rods meet beyond which a part of a piece of round ends has 16, 12 and 8 sections; below them it has
/// 4. With 8 and 4 such a part errs by 1e-5 and 1e-2 of itself. With 16 in all parts down to 2e-3 capsules nearly parallel took a third
/// more sections, and erred by 1e-14 of their second moments, not 4e-11. Of angles, not of heights: near a rod's top its surface goes like
/// their root.
constexpr double kLong = 2e-2, kMiddling = 4e-3, kTiny = 1e-9;
/// A piece of round ends that is higher than this share of the lesser radius has 24 sections, and one higher than kHighest twice 24:
/// singularities beyond V are near it. With 16 up to 0.3 radii the area vector was off by 2e-9 of itself, with 24 in all by 4e-9.
constexpr double kDeep = 0.1, kHighest = 0.5;
/// Heights so many times narrower than the way to the next root have sections that are nearly polynomials of
/// sin θ and cos θ.
constexpr double kShallow = 20;
/// A piece shorter than this share of its neighbour is too near an end of it for one rule.
constexpr double kShort = 0.05;
/// A break nearer than this share of a piece is its end: the difference is the power 3/2.
constexpr double kMerged = 1e-6;
/// Lengths of the gap over which the map of both roots goes.
constexpr double kSpread = 200;
/// A quarter of the piece lies below this t: its middle has half of it at least.
constexpr double kInner = 1.0 / 3;
/// In t² (3 − 2 t) − κ t² (1 − t)² (1 − 2 t) it leaves at both ends the curve of sin² π t/2: 3 − κ = π²/4. With κ = 0 singularities beyond
/// V come a tenth nearer, and the largest error doubles.
constexpr double kFlat = 3 - M_PI * M_PI / 4;
/// Wider pieces of cylinders [rad] take 16 sections: moments are trigonometric polynomials of degree 10 or less, or nearly. Others take 8,
/// since moments may be of degree 8 within the piece, however narrow it is; they err by 1.4e-9 of V's second moments at 0.43, with the
/// power 16 of the width.
constexpr double kWide = 0.35;
/// Sum of half axes of the ellipse without a singularity, beyond which less than 16 sections will do.
constexpr double kFar = 5.6;

/// Gauss's rule of 24 nodes: exact up to degree 47.
constexpr GaussPoint kGauss24[] = {
    {0.9951872199970213, 0.0123412297999872},  {0.9747285559713095, 0.028531388628933663}, {0.9382745520027328, 0.04427743881741981},
    {0.8864155270044011, 0.05929858491543678}, {0.820001985973903, 0.0733464814110803},    {0.7401241915785544, 0.08619016153195327},
    {0.6480936519369755, 0.09761865210411388}, {0.5454214713888396, 0.10744427011596563},  {0.4337935076260451, 0.1155056680537256},
    {0.3150426796961634, 0.12167047292780339}, {0.1911188674736163, 0.1258374563468283},   {0.06405689286260563, 0.12793819534675216}};

/// The angle θ of a height: x = w sin² θ, θ from 0 to π/2.
double angleOf(double width, double over) {
  return elementary::atan2(std::sqrt(over), std::sqrt(std::max(0.0, width - over)));
}

/// Gauss's nodes in θ, the same for all pairs: where they lie, as shares of the heights, and dx/dθ times their weights.
template <int kHalf>
struct AllHeights {
  double over[2 * kHalf], under[2 * kHalf], weight[2 * kHalf];

  explicit AllHeights(const GaussPoint (&rule)[kHalf], double from, double to) {
    int i = 0;
    integrate(rule, from, to, [&](double theta, double w) {
      const elementary::SineCosine angle = elementary::sinCos(theta);
      over[i] = angle.sine * angle.sine, under[i] = angle.cosine * angle.cosine, weight[i++] = 2 * w * angle.sine * angle.cosine;
    });
  }
};
const AllHeights<4> kShallowRule(kGauss8, 0, M_PI / 2);
const AllHeights<8> kDeepRule(kGauss16, 0, M_PI / 2), kLowerRule(kGauss16, 0, M_PI / 4), kUpperRule(kGauss16, M_PI / 4, M_PI / 2);

/// ∫ from a to b, four nodes at once: visits (places, weights).
template <int kHalf, class Visit>
void integrateInLanes(const GaussPoint (&rule)[kHalf], double a, double b, Visit&& visit) {
  const Lanes middle = lanes(0.5 * (a + b)), half = lanes(0.5 * (b - a));
  for (int i = 0; i < kHalf; i += 2) {
    const GaussPoint &g = rule[i], &k = rule[i + 1];
    visit(middle + half * Lanes{-g.at, g.at, -k.at, k.at}, half * Lanes{g.weight, g.weight, k.weight, k.weight});
  }
}

/// By so many nodes.
template <class Visit>
void integrateInLanes(int nodes, double a, double b, Visit&& visit) {
  if (nodes == 24) return integrateInLanes(kGauss24, a, b, visit);
  if (nodes == 16) return integrateInLanes(kGauss16, a, b, visit);
  if (nodes == 12) return integrateInLanes(kGauss12, a, b, visit);
  nodes == 8 ? integrateInLanes(kGauss8, a, b, visit) : integrateInLanes(kGauss4, a, b, visit);
}

/// Sums over heights of a section's moments, z over the middle of the range.
struct Sums {
  double plain[6] = {0, 0, 0, 0, 0, 0};  ///< ∫ 1, x, y, xx, xy, yy
  double z[3] = {0, 0, 0}, zz = 0;       ///< ∫ z (1, x, y), ∫ z²

  /// ∫ (x, y, z), and of their products.
  void moments(double& zeroth, Vector3& first, Matrix3& second) const {
    zeroth = plain[0];
    first << plain[1], plain[2], z[0];
    second << plain[3], plain[4], z[1], plain[4], plain[5], z[2], z[1], z[2], zz;
  }
};

/// The same in lanes, over heights four at once.
struct LaneSums {
  PlaneSums plain;
  Lanes z[3], zz;

  LaneSums() {
    plain.clear();
    for (Lanes& x : z) x = lanes(0);
    zz = lanes(0);
  }
  void add(const Lanes& weight, const Lanes& height, const PlaneSums& m) {
    const Lanes wz = weight * height;
    plain.add(weight, m);
    for (int i = 0; i < 3; ++i) z[i] += wz * m.v[i];
    zz += wz * height * m.v[0];
  }
  Sums total() const {
    Sums out;
    for (int i = 0; i < 6; ++i) out.plain[i] = sum(plain.v[i]);
    for (int i = 0; i < 3; ++i) out.z[i] = sum(z[i]);
    out.zz = sum(zz);
    return out;
  }
};

class Integrator {
 public:
  Integrator(const RodPair& pair, RodIntegral& out, RodBreaks& breaks)
      : pair_(pair),
        out_(out),
        breaks_(breaks),
        middle_(pair.low + 0.5 * pair.width),
        beyond_(std::min(pair.above[0] + pair.above[1], pair.below[0] + pair.below[1])),
        root_above_(pair.above[0] + pair.above[1] < pair.below[0] + pair.below[1]) {}

  void integrate() {
    if (!crossing()) pieces();
    finish();
  }

 private:
  bool crossing();
  void pieces();
  int nodesFor(double from, double to) const;
  void finish() {
    out_.origin << o_, middle_;
    solid_.moments(out_.solid.volume, out_.solid.first, out_.solid.second);
    for (int i = 0; i < 3; ++i) surface_[i].moments(out_.surface[i].area, out_.surface[i].first, out_.surface[i].second);
  }

  const RodPair& pair_;
  RodIntegral& out_;
  RodBreaks& breaks_;
  double middle_;        ///< z about which heights are summed [m]: within V, since V may be much smaller than the range
  const double beyond_;  ///< distance of the next root of a half width from the range [m]
  const bool root_above_;  ///< over it, not below
  Vector2 o_ = Vector2::Zero();
  Sums solid_, surface_[3];
};

/// Sums over the heights between breaks, about a point of V.
class PieceIntegrator {
 public:
  PieceIntegrator(const RodPair& pair, const RodBreaks& breaks, const Vector2& origin, double middle)
      : pair_(pair), breaks_(breaks), middle_(lanes(middle)), section_(pair, origin) {}

  /// Evenly in θ.
  void add(const RodOutline& outline, double from, double to, int nodes) {
    integrateInLanes(nodes, from, to, [&](const Lanes& theta, const Lanes& weight) { addSections(outline, theta, weight); });
  }
  void addRounded(const RodOutline& outline, int piece, const double* angle, double share);

  LaneSums solid, surface[3];

 private:
  void addSections(const RodOutline& outline, const Lanes& theta, const Lanes& weight);

  const RodPair& pair_;
  const RodBreaks& breaks_;
  const Lanes middle_;
  SectionMoments section_;
};

/// With a, b the half widths: y = η, x = x0 + η cot − ξ / sin, |η| ≤ a, |ξ| ≤ b. False: an end may lie in V,
/// or the angle is small.
bool Integrator::crossing() {
  const RodPair& p = pair_;
  if (p.sine < kCrossing) return false;
  double most[2];
  const double axis[2] = {0, p.distance};
  for (int i = 0; i < 2; ++i) {
    const double z = std::clamp(axis[i], p.low, p.low + p.width) - axis[i];
    most[i] = std::sqrt(std::max(0.0, (p.radius[i] - z) * (p.radius[i] + z)));
  }
  const double along_B = -p.centre.y() * p.inverse_sine, along_A = p.centre.x() + along_B * p.cosine;
  if (std::abs(along_A) + (most[0] * p.cosine + most[1]) * p.inverse_sine > p.half[0]) return false;
  if (std::abs(along_B) + (most[1] * p.cosine + most[0]) * p.inverse_sine > p.half[1]) return false;
  // ∫ (1, z, z², a², b²) of the area a b and of A's side b z / a.
  double f[5] = {0, 0, 0, 0, 0}, g[5] = {0, 0, 0, 0, 0};
  const auto addNodes = [&](const auto& rule) {
    for (std::size_t i = 0; i < std::size(rule.over); ++i) {
      const RodHeight x{p.width * rule.over[i], p.width * rule.under[i]};
      const double a2 = p.square(0, x), b2 = p.square(1, x), ab = std::sqrt(a2 * b2), z = p.z(x), u = z - middle_;
      const double area = p.width * rule.weight[i] * ab, flank = area / a2 * z;
      f[0] += area, f[1] += area * u, f[2] += area * u * u, f[3] += area * a2, f[4] += area * b2;
      g[0] += flank, g[1] += flank * u, g[2] += flank * u * u, g[3] += flank * a2, g[4] += flank * b2;
    }
  };
  // The other rod's top or bottom within the range's width of an end: its root, too, is near.
  if (beyond_ < p.width) {
    addNodes(kLowerRule), addNodes(kUpperRule);
  } else if (beyond_ < kShallow * p.width) {
    addNodes(kDeepRule);
  } else {
    addNodes(kShallowRule);
  }
  o_ = Vector2(along_A, 0);
  breaks_.over[0] = 0, breaks_.over[1] = p.width, breaks_.count = 2;
  const double c = 4 * p.inverse_sine, cot = p.cosine * p.inverse_sine,
               square = p.inverse_sine * p.inverse_sine;
  solid_ = {{c * f[0], 0, 0, c * (cot * cot * f[3] + square * f[4]) / 3, c * cot * f[3] / 3, c * f[3] / 3}, {0, 0, 0}, 0};
  solid_.z[0] = c * f[1], solid_.zz = c * f[2];
  surface_[2] = {{c * g[0], 0, 0, c * (cot * cot * g[3] + square * g[4] / 3), c * cot * g[3], c * g[3]}, {0, 0, 0}, 0};
  surface_[2].z[0] = c * g[1], surface_[2].zz = c * g[2];
  // Across, A's two sides differ by the terms odd in y.
  surface_[1].plain[1] = c * cot * f[0], surface_[1].plain[2] = c * f[0];
  surface_[1].z[1] = c * cot * f[1], surface_[1].z[2] = c * f[1];
  return true;
}

/// About a point of the longest piece in which the rods meet. Each piece has the outline of its middle.
void Integrator::pieces() {
  RodBreaks& breaks = breaks_;
  breaks.find(pair_);
  RodOutline outline[RodBreaks::kMost + 1];
  RodSection section(pair_);
  double angle[RodBreaks::kMost + 2], longest = 0, range = 0;
  for (int i = 0; i < breaks.count; ++i) angle[i] = angleOf(pair_.width, breaks.over[i]);
  for (int i = 0; i + 1 < breaks.count; ++i) {
    const double from = breaks.over[i], length = breaks.over[i + 1] - from;
    if (!section.find(pair_.heightAt(from + 0.5 * length))) continue;
    outline[i] = section.outline();
    range += angle[i + 1] - angle[i];
    if (length <= longest) continue;
    longest = length;
    middle_ = pair_.low + from + 0.5 * length;
    o_.setZero();
    for (int k = 0; k < section.pointCount(); ++k) o_ += section.points()[k];
    o_ /= section.pointCount();
  }
  const bool rounded = pair_.round[0] || pair_.round[1];
  PieceIntegrator integrator(pair_, breaks, o_, middle_);
  for (int i = 0; i + 1 < breaks.count; ++i) {
    if (outline[i].count == 0) continue;
    const double from = angle[i], to = angle[i + 1], share = (to - from) / range;
    if (rounded) {
      integrator.addRounded(outline[i], i, angle, share);
    } else {
      integrator.add(outline[i], from, to, share > kTiny ? nodesFor(from, to) : 4);
    }
  }
  solid_ = integrator.solid.total();
  for (int i = 0; i < 6; ++i) solid_.plain[i] *= kConeShare[i];
  for (int i = 0; i < 3; ++i) solid_.z[i] *= kConeShare[i];
  solid_.zz *= kConeShare[0];
  for (int i = 0; i < 3; ++i) surface_[i] = integrator.surface[i].total();
}

/// A root of the half widths lies at the angle i σ from that of the lower or upper end, sinh² σ = its distance over the heights. Gauss's
/// rule of n nodes errs by ρ⁻²ⁿ if no singularity lies within the ellipse of sum ρ of half axes about the interval.
int Integrator::nodesFor(double from, double to) const {
  const double length = to - from, sigma = elementary::asinh(std::sqrt(beyond_ / pair_.width)), way = root_above_ ? M_PI / 2 - to : from;
  const double d = std::sqrt(way * way + sigma * sigma) / length, rho = 1 + 2 * d + 2 * std::sqrt(d * (1 + d));
  return length > kWide || rho < kFar ? 16 : 8;
}

/// θ = from + length t² (3 − 2 t …), flat at both ends: where a lens begins, its moments have the power 3/2 of the height. A break just
/// beyond an end is as near a singularity, and so is its own image at −θ, since half widths are odd in θ: there θ = from + gap sinh² u
/// first, in which the roots of both vanish.
void PieceIntegrator::addRounded(const RodOutline& outline, int i, const double* angle, double share) {
  const double from = angle[i], length = angle[i + 1] - from;
  const double height = breaks_.over[i + 1] - breaks_.over[i];
  const double lesser = std::min(pair_.radius[0], pair_.radius[1]);
  const auto nodesOf = [&](double part) {
    if (height > kDeep * lesser) return 24;
    const double all = share * part / length;
    return all > kLong ? 16 : all > kMiddling ? 12 : all > kTiny ? 8 : 4;
  };
  double middle = length;  // length without the ends
  double inside[2] = {0, 0};  // t at which the middle begins, from either end
  for (const int side : {0, 1}) {
    const double end = angle[i + side], way = side ? -1 : 1;
    double gap = 0;
    for (int k = i + side; k >= 0 && k < breaks_.count && std::abs(angle[k] - end) < kShort * length; k += side ? 1 : -1)
      gap = std::abs(angle[k] - end);
    const double mirrored = 2 * (side ? M_PI / 2 - end : end);
    if (mirrored < kShort * length) gap = std::max(gap, mirrored);
    if (!(gap > kMerged * length)) continue;
    const double t = std::min(std::sqrt(kSpread / (3 - kFlat) * gap / length), kInner), w = t * (1 - t);
    const double part = length * (t * t * (3 - 2 * t) - kFlat * w * w * (1 - 2 * t));
    inside[side] = t;
    middle -= part;
    integrateInLanes(nodesOf(part), 0, elementary::asinh(std::sqrt(part / gap)), [&](const Lanes& u, const Lanes& weight) {
      const auto [sine, cosine] = hyperbolicSineCosine(u);
      const Lanes rise = lanes(gap) * sine;
      addSections(outline, lanes(end) + lanes(way) * rise * sine, lanes(2) * weight * rise * cosine);
    });
  }
  const double first = inside[0], last = 1 - inside[1];
  const int halves = height > kHighest * lesser ? 2 : 1;
  for (int k = 0; k < halves; ++k) {
    integrateInLanes(nodesOf(middle), first + (last - first) * k / halves, first + (last - first) * (k + 1) / halves,
                     [&](const Lanes& t, const Lanes& weight) {
                       const Lanes w = t * (lanes(1) - t);
                       const Lanes gone = t * t * (lanes(3) - lanes(2) * t) - lanes(kFlat) * w * w * (lanes(1) - lanes(2) * t);
                       const Lanes rate = w * (lanes(6 - 2 * kFlat) + lanes(10 * kFlat) * w);
                       addSections(outline, lanes(from) + lanes(length) * gone, lanes(length) * weight * rate);
                     });
  }
}

/// Sections at the angles θ.
void PieceIntegrator::addSections(const RodOutline& outline, const Lanes& theta, const Lanes& weight) {
  const auto [sine, cosine] = quarterSineCosine(theta);
  const Lanes over = lanes(pair_.width) * sine, under = lanes(pair_.width) * cosine;
  const RodHeights x{over * sine, under * cosine};
  section_.find(outline, x);
  const Lanes w = lanes(2) * weight * over * cosine, z = lanes(pair_.low) + x.over, height = z - middle_;
  solid.add(w, height, section_.outline);
  surface[0].add(w, height, section_.along_x);
  surface[1].add(w, height, section_.along_y);
  surface[2].add(w * z / section_.width[0], height, section_.curved);
}

}  // namespace

RodIntegral::RodIntegral(const RodPair& pair, RodBreaks& breaks) noexcept {
  Integrator(pair, *this, breaks).integrate();
}

}  // namespace haptic
