/// String tensions that present a wrench: an exactly solved quadratic program.
///
///   minimise |W (Aᵀ t - w)|² + λ |t|²   subject to  t_min ≤ t ≤ t_max,   W = diag(1,1,1, 1/r,1/r,1/r[, 1])
///
/// A is the structure matrix (string_kinematics.h), r the knots' rms radius, so that 1 N and r · 1 N cost
/// alike. With λ = 0 tensions jump at the border of the presentable wrenches; λ > 0 makes them continuous and
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
/// λ from the distance to the border. One λ must serve two ends: beyond the presentable wrenches a steady tension
/// wants it large (dt ≈ |y| dm / λ for a change dm of the structure), inside a true wrench wants it small. So `present`
/// takes λ = c |y|^⅘, with |y| the distance in newtons from the wrench asked for to the one presented and c the λ at
/// 1 N (`border_lambda`). That is the one solution of the strictly convex problem
///   minimise ⅚ |W (Aᵀ t - w)|^(6/5) + ½ c |t|²,
/// so t stays a continuous function of pose and wrench. The power: 0 is a constant λ; at 1 (a norm, exact inside)
/// tensions jump where the strings give a direction up. At equal steps (SPIDAR-G6X3R, 50 mN per 10 µm outside) 4.5 % of
/// 5 N and 0.1 N·m are lost inside with power 0, 0.7 % with ½, 0.01 % with ⅘; from 0.9 on the steps grow again.
/// λ = c |y(λ)|^⅘ is solved by secants in ln λ: |y| grows with λ and |y|/λ falls, so there is one root.
#pragma once
#include <array>
#include <cstdint>
#include <memory>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// How a solve ended.
enum class TensionStatus : unsigned char { kSolved, kIterationLimit, kNotFinite };

/// String tensions, and the wrench that they present.
struct TensionReport {
  StringVector tension;      ///< [N], within the bounds whatever the status
  Wrench F_G_B;              ///< wrench of the tensions: at G's origin, in B
  double grasp_force = 0;    ///< presented along the opening [N]
  double error = 0;          ///< |W (Aᵀ t - w)| [N]
  double lambda = 0;         ///< with which it was solved [1]
  double kkt_residual = 0;   ///< violation of the optimality conditions over 1 N + |W w| [1]
  std::uint32_t at_min = 0;  ///< bit per string
  std::uint32_t at_max = 0;  ///< bit per string
  int iterations = 0;        ///< active sets tried
  /// KNotFinite: minimum tensions, for the wrench was not finite.
  TensionStatus status = TensionStatus::kNotFinite;
};

class TensionSolver;  // one instantiation per dof and capacity

/// String tensions that present a wrench, by an exactly solved quadratic program.
class TensionDistribution {
 public:
  /// Bounds and λ from the device; `kinematics` gives dof, strings and r.
  TensionDistribution(const DeviceDef& def, const StringKinematics& kinematics);
  ~TensionDistribution();
  TensionDistribution(TensionDistribution&&) noexcept;             ///< the other one is empty afterwards
  TensionDistribution& operator=(TensionDistribution&&) noexcept;  ///< the other one is empty afterwards

  double lambda() const { return lambda_; }  ///< of `solve`
  void setLambda(double lambda) noexcept;    ///< (in realtime) > 0; smaller than 1e-9 is taken as 1e-9

  /// λ of the device's rule: at 1 N missing where its file has a `border_lambda`, else the constant one.
  double ruleLambda() const { return border_lambda_ > 0 ? border_lambda_ : lambda_; }
  void setRuleLambda(double lambda) noexcept;  ///< (in realtime) > 0

  /// (in realtime) Takes W Aᵀ of a pose (`StringKinematics::scaledStructure`).
  void setStructure(const StructureMatrix& scaled) noexcept;

  /// (in realtime) Tensions for the wrench on the grip at G's origin in B, and the force along the opening.
  /// Starts from the active set of the call before. A wrench that is not finite gives minimum tensions.
  /// Cost, 8 strings: 0.1 µs when pose and active set are those of the call before, 0.2 µs when the pose is
  /// new, 0.5 µs when the set is.
  const TensionReport& solve(const Wrench& F_G_B, double grasp_force = 0) noexcept;

  /// (in realtime) The same with λ from the distance to the border, when the device's file has a `border_lambda`.
  /// Cost: one `solve` inside, five or so outside.
  const TensionReport& present(const Wrench& F_G_B, double grasp_force = 0) noexcept;

  void forgetActiveSet() noexcept;  ///< (in realtime) the next solve starts cold
  /// The active set as two numbers per string, for recordings: it may decide the last bit of the next solve.
  void saveActiveSet(double* out) const noexcept;
  void restoreActiveSet(const double* in) noexcept;                 ///< what `saveActiveSet` wrote
  const TensionReport& report() const noexcept { return report_; }  ///< of the last solve

 private:
  using Scaled = std::array<double, kMaxDof>;
  bool scale(const Wrench& F_G_B, double grasp_force) noexcept;
  double solveWith(double lambda) noexcept;
  double lambdaFor(double missing) const noexcept;
  const TensionReport& finish(bool finite) noexcept;

  int strings_, dof_;
  double radius_, lambda_, border_lambda_, lambda_used_ = 0;
  Scaled wanted_{}, achieved_{};  ///< W w, W Aᵀ t
  StringVector min_, max_;
  std::unique_ptr<TensionSolver> solver_;
  TensionReport report_;
};

}  // namespace haptic
