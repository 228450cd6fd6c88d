/// String tensions that present a wrench: an exactly solved quadratic program.
///
///   minimise |W (Aᵀ t - w)|² + λ |t|²   subject to  t_min ≤ t ≤ t_max,   W = diag(1,1,1, 1/r,1/r,1/r[, 1])
///
/// A is the structure matrix (string_kinematics.h), r the knots' rms radius, so that 1 N and r · 1 N cost
/// alike. With λ = 0 tensions jump at the border of what can be presented; λ > 0 makes them continuous and
/// shrinks the presented wrench by about λ (Hasegawa & Sato, slides 10-12).
///
/// Method. With M = W Aᵀ and w' = W w, put y = w' - M t (the scaled wrench error). Stationarity says
///   t_i = clamp(m_i · y / λ, t_min, t_max),
/// so y alone solves the problem: it minimises the strongly convex, piecewise quadratic
///   φ(y) = ½|y|² - w'·y + Σ ψ_i(m_i·y / λ),  ψ_i' = λ clamp.
/// Newton on φ is an active-set method with a dof × dof system: for the free set F and the held set B,
///   (1 + M_F M_Fᵀ / λ) y = w' - M_B t_B.
/// It ends when the tensions that y implies are those of the set it was computed with: then y is exact. A
/// step that does not lower φ is shortened by an exact line search over the breakpoints, which makes the
/// method finite. A guess of the set (the last tick's) makes it one solve.
///
/// Corrections. One λ must serve two ends: a steady tension at the border of what can be presented wants it
/// large, a true wrench inside wants it small. So `present` asks again, raised by what was missing: w₁ = w +
/// (w - Aᵀ t₀), as in iterated Tikhonov regularisation. Inside, the lost share falls from ε = λ/(σ² + λ) to
/// ε²; at the border, where no tension brings what is missing, nearly nothing changes; and t stays a
/// continuous function of pose and wrench. At equal tension steps this loses less everywhere than one
/// constant λ (bench_spidar prints both).
#pragma once
#include <array>
#include <cstdint>
#include <memory>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

enum class TensionStatus : unsigned char { kSolved, kIterationLimit, kNotFinite };

struct TensionReport {
  StringVector tension;      ///< [N], within the bounds whatever the status
  Wrench F_G_B;              ///< what the tensions present: at G's origin, in B
  double grasp_force = 0;    ///< presented along the opening [N]
  double error = 0;          ///< |W (Aᵀ t - w)| [N]
  double kkt_residual = 0;   ///< violation of the optimality conditions over 1 N + |W w| [1]
  std::uint32_t at_min = 0;  ///< bit per string
  std::uint32_t at_max = 0;  ///< bit per string
  int iterations = 0;        ///< active sets tried
  TensionStatus status = TensionStatus::kNotFinite;
};

class TensionSolver;  // one instantiation per dof and capacity

class TensionDistribution {
 public:
  /// Bounds and λ from the device; `kinematics` gives dof, strings and r.
  TensionDistribution(const DeviceDef& def, const StringKinematics& kinematics);
  ~TensionDistribution();

  double lambda() const { return lambda_; }
  void setLambda(double lambda) noexcept;  ///< (in realtime) > 0; smaller than 1e-9 is taken as 1e-9

  /// (in realtime) Takes W Aᵀ of a pose (`StringKinematics::scaledStructure`).
  void setStructure(const StructureMatrix& scaled) noexcept;

  /// (in realtime) Tensions for the wrench on the grip at G's origin in B, and the force along the opening.
  /// Starts from the active set of the call before. A wrench that is not finite gives minimum tensions.
  /// Cost, 8 strings: 0.1 µs when pose and active set are those of the call before, 0.2 µs when the pose is
  /// new, 0.5 µs when the set is.
  const TensionReport& solve(const Wrench& F_G_B, double grasp_force = 0) noexcept;

  /// (in realtime) `solve`, corrected as often as the device file says; errors are those of the wrench asked
  /// for.
  const TensionReport& present(const Wrench& F_G_B, double grasp_force = 0) noexcept;

  void forgetActiveSet() noexcept;  ///< (in realtime) the next solve starts cold
  const TensionReport& report() const noexcept { return report_; }

 private:
  using Scaled = std::array<double, kMaxDof>;
  const TensionReport& solveCorrected(const Wrench& F_G_B, double grasp_force, int corrections) noexcept;

  int strings_, dof_, corrections_;
  double radius_, lambda_;
  StringVector min_, max_;
  std::unique_ptr<TensionSolver> solver_;
  TensionReport report_;
};

}  // namespace haptic
