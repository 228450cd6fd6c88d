/// The stiffness of a surface from the material of its body.
///
/// A body is a rigid core under an elastic layer as thick as half of its least extent L. A layer that cannot bulge sideways
/// answers a pressure p with the strain p/M,
///     M = E (1 - ν)/((1 + ν)(1 - 2ν)) = κ(ν) E
/// (Johnson, Contact Mechanics, 1985, §5.8: thin compressible layers; the same M is that of Blankevoort et al., J. Biomech. 24,
/// 1991), so its foundation is M/(L/2). Two layers are in series, 1/k = L_A/(2 M_A) + L_B/(2 M_B). `combine` takes
/// the harmonic mean 2 k_A k_B/(k_A + k_B) of surfaces, which is twice the series; so a surface of its own has k = M/L.
/// Deviation: no layer of a compact body is confined by more than κ = 3/2. M grows without bound for ν → ½, where rubber and
/// skin are, but a bonded block as wide as two of its thickness, half of a cube, is stiffened by 1 + 2S² = 1.5 at
/// ν = ½ (S = ½ its loaded over its free area; Gent & Lindley, Proc. Inst. Mech. Eng. 173, 1959). ν > 1/3 has κ = 3/2.
/// A local contact, of a patch much smaller than the body, is stiffer in nature than this, and stiffens with its force (Hertz).
#pragma once
#include <algorithm>
#include <iterator>
#include <string>

namespace haptic {

/// A material that a body may be made of.
struct Solid {
  const char* name;      ///< in scene files
  double young_modulus;  ///< E [Pa]
  double poisson_ratio;  ///< ν [1]
  const char* source;    ///< of the two numbers
};

/// Sources of several solids.
inline constexpr char kGere[] = "Gere, Mechanics of Materials, 5th ed. 2001, app. H";
/// Likewise.
inline constexpr char kDowling[] = "Dowling, Mechanical Behavior of Materials, table 5.2";

/// Middle values of the ranges that the sources give.
inline constexpr Solid kSolids[] = {
    {"steel", 2.0e11, 0.29, kGere},       // 190…210 GPa, 0.27…0.30
    {"aluminium", 7.4e10, 0.33, kGere},   // 70…79 GPa
    {"concrete", 2.4e10, 0.15, kGere},    // compression, 17…31 GPa, 0.1…0.2
    {"wood", 1.2e10, 0.30, kGere},        // bending along the grain, Douglas fir 11…13 GPa; across it some tenth of that
    {"acrylic", 2.7e9, 0.35, kDowling},
    {"rubber", 2.0e6, 0.48, kGere},       // 0.7…4 MPa, 0.45…0.5
    {"skin", 4.2e5, 0.48, "Agache et al., Arch. Dermatol. Res. 269, 1980"},  // in vivo, below 30 years of age
};

/// ν where only E is given: metals have 0.27…0.33, and κ is 1.35 ± 0.1 there.
inline constexpr double kUsualPoissonRatio = 0.3;

/// Null: there is none of that name.
inline const Solid* solidNamed(const std::string& name) {
  const auto found = std::find_if(std::begin(kSolids), std::end(kSolids), [&](const Solid& s) { return name == s.name; });
  return found == std::end(kSolids) ? nullptr : found;
}

/// κ(ν), at most 3/2; 0 ≤ ν ≤ ½.
inline double confinement(double poisson_ratio) {
  constexpr double kMost = 1.5, kReached = 1.0 / 3;
  if (poisson_ratio >= kReached) return kMost;
  return (1 - poisson_ratio) / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
}

/// Foundation of a surface [N/m³] of a body of E [Pa], ν and least extent L [m].
inline double surfaceStiffness(double young_modulus, double poisson_ratio, double extent) {
  return confinement(poisson_ratio) * young_modulus / extent;
}

}  // namespace haptic
