/// The Newton iteration of tension_distribution.h, for one number of degrees of freedom and one capacity.
/// Internal to the folder.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>

#include "haptic_core/spidar/small_cholesky.h"
#include "haptic_core/spidar/string_lanes.h"
#include "haptic_core/spidar/tension_distribution.h"

namespace haptic {

/// What TensionDistribution calls, whatever the number of columns and strings.
class TensionSolver {
 public:
  virtual ~TensionSolver() = default;
  /// By string [N]; the set-up.
  virtual void setBounds(const StringVector& min, const StringVector& max) noexcept = 0;
  virtual void setLambda(double lambda) noexcept = 0;  ///< the weight of |t|², > 0
  virtual void setStructure(const StructureMatrix& scaled) noexcept = 0;  ///< W Aᵀ of a pose, by string
  virtual void forgetActiveSet() noexcept = 0;  ///< the next solve starts with all strings free
  /// Two numbers per string: 1 where it is free, the tension that it is held at.
  virtual void saveActiveSet(double* out) const noexcept = 0;
  virtual void restoreActiveSet(const double* in) noexcept = 0;  ///< what `saveActiveSet` wrote
  /// `wanted` is W w. Fills all of `report` but what needs r.
  virtual void solve(const double* wanted, double* achieved, TensionReport& report) noexcept = 0;
};

/// The Newton iteration for kDof columns and up to kLanes strings. Its loops have constant bounds.
template <int kDof, int kLanes>
class TensionNewton final : public TensionSolver {
 public:
  using Lane = StringLane<kLanes>;               ///< one number per string
  using Error = Eigen::Matrix<double, kDof, 1>;  ///< one number per column

  /// See TensionSolver.
  void setBounds(const StringVector& min, const StringVector& max) noexcept override {
    strings_ = static_cast<int>(min.size());
    // Padding strings have no column: any tension between these bounds, zero in fact.
    min_ = Lane::constant(-1);
    max_ = Lane::constant(1);
    for (int i = 0; i < strings_; ++i) {
      min_.set(i, min[i]);
      max_.set(i, max[i]);
    }
    degenerate_ = kDegenerate * max.maxCoeff();
    factored_ = false;
  }

  /// See TensionSolver.
  void setLambda(double lambda) noexcept override {
    lambda_ = lambda;
    stiffness_ = 1 / lambda;
    factored_ = false;
  }

  /// See TensionSolver.
  void setStructure(const StructureMatrix& scaled) noexcept override {
    for (int c = 0; c < kDof; ++c) {
      double column[kLanes] = {};  // padding has none
      std::copy_n(scaled.data() + c * strings_, strings_, column);
      for (int k = 0; k < Lane::kPackets; ++k) columns_.column[c].packet[k] = loadLanes(column + 4 * k);
    }
    factored_ = false;
  }

  /// See TensionSolver.
  void forgetActiveSet() noexcept override {
    free_ = Lane::constant(1);
    held_ = Lane::constant(0);
    factored_ = false;
  }

  void saveActiveSet(double* out) const noexcept override {
    for (int i = 0; i < strings_; ++i) {
      *out++ = free_[i];
      *out++ = held_[i];
    }
  }

  /// See TensionSolver.
  void restoreActiveSet(const double* in) noexcept override {
    forgetActiveSet();
    for (int i = 0; i < strings_; ++i) {
      free_.set(i, *in++);
      held_.set(i, *in++);
    }
  }

  void solve(const double* wanted, double* achieved, TensionReport& report) noexcept override {
    wanted_ = Eigen::Map<const Error>(wanted);
    report.status = run(report.iterations) ? TensionStatus::kSolved : TensionStatus::kIterationLimit;
    judge(achieved, report);
  }

 private:
  // Newton needs 2 to 9 sets in practice; the line search makes it finite, this bounds the tick.
  static constexpr int kIterationBound = 60;
  // Tensions closer than this share of the greatest are equal: a string on its bound may count as free or
  // held.
  static constexpr double kDegenerate = 1e-14;

  void factorActiveSet() noexcept {
    typename SmallCholesky<kDof>::Rows s;
    const Lane weight = stiffness_ * free_;
    for (int a = 0; a < kDof; ++a) {
      const Lane weighted = columns_.column[a] * weight;
      for (int b = 0; b < a; ++b) s[a][b] = weighted.dot(columns_.column[b]);
      s[a][a] = 1 + weighted.dot(columns_.column[a]);
    }
    cholesky_.factor(s, 0.0);
    held_wrench_ = wrenchOf(held_);
    factored_ = true;
  }

  Error wrenchOf(const Lane& tension) const noexcept {
    Error w;
    for (int c = 0; c < kDof; ++c) w[c] = columns_.column[c].dot(tension);
    return w;
  }

  /// y of the active set, and the tensions `slope_` it asks of every string.
  void solveActiveSet() noexcept {
    y_ = wanted_ - held_wrench_;
    cholesky_.solve(y_);
    setSlope();
  }

  void setSlope() noexcept { slope_ = stiffness_ * columns_.combine(y_); }

  /// Clamps `slope_` into `tension_`; true when these are the tensions of the set that gave `slope_`.
  bool settled() noexcept {
    tension_ = clamp(slope_, min_, max_);
    const Lane difference = tension_ - (free_ * slope_ + held_);
    return difference.squaredNorm() <= degenerate_ * degenerate_;
  }

  void adoptActiveSet() noexcept {
    const Lane one = Lane::constant(1), zero = Lane::constant(0);
    free_ = whereEqual(tension_, slope_, one, zero);
    held_ = whereEqual(tension_, slope_, zero, tension_);
    factored_ = false;
  }

  double potential() const noexcept {
    return y_.dot(0.5 * y_ - wanted_) + lambda_ * tension_.dot(slope_ - 0.5 * tension_);
  }

  /// dφ/dα at from + α (y - from).
  double slopeAlong(double alpha, const Error& from, const Lane& from_slope) const noexcept {
    const Error step = y_ - from;
    const Lane change = slope_ - from_slope;
    return step.dot(from + alpha * step - wanted_) +
           lambda_ * change.dot(clamp(from_slope + alpha * change, min_, max_));
  }

  /// α in [0, 1] with the least φ. dφ/dα is piecewise linear and rising: bisection over the breakpoints finds
  /// the piece with the root, and the root follows.
  double lineSearch(const Error& from, const Lane& from_slope) const noexcept {
    std::array<double, 2 * kLanes + 2> breaks;
    int count = 0;
    breaks[count++] = 0;
    for (int i = 0; i < strings_; ++i) {
      for (const double bound : {min_[i], max_[i]}) {
        const double alpha = (bound - from_slope[i]) / (slope_[i] - from_slope[i]);
        if (alpha > 0 && alpha < 1) breaks[count++] = alpha;
      }
    }
    breaks[count++] = 1;
    std::sort(breaks.begin(), breaks.begin() + count);
    int low = 0, high = count - 1;
    if (slopeAlong(1, from, from_slope) <= 0) return 1;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      (slopeAlong(breaks[middle], from, from_slope) <= 0 ? low : high) = middle;
    }
    const double at_low = slopeAlong(breaks[low], from, from_slope);
    const double at_high = slopeAlong(breaks[high], from, from_slope);
    return breaks[low] + (breaks[high] - breaks[low]) * (at_low / (at_low - at_high));
  }

  bool run(int& iterations) noexcept {
    if (!factored_) factorActiveSet();
    iterations = 1;
    solveActiveSet();
    return settled() || search(iterations);
  }

  /// Newton from a first y whose tensions belong to another set than the one it was computed with.
  bool search(int& iterations) noexcept {
    double phi = potential();
    while (++iterations <= kIterationBound) {
      const Error from = y_;
      const Lane from_slope = slope_;
      adoptActiveSet();
      factorActiveSet();
      solveActiveSet();
      if (settled()) return true;
      double next = potential();
      if (!(next < phi)) {
        const double alpha = lineSearch(from, from_slope);
        y_ = from + alpha * (y_ - from);
        setSlope();
        settled();
        next = potential();
      }
      phi = next;
    }
    return false;
  }

  /// Results of the tensions: wrench, error, active bounds, optimality.
  void judge(double* achieved, TensionReport& report) const noexcept {
    const Error given = wrenchOf(tension_);
    const Error error = given - wanted_;
    Eigen::Map<Error> out(achieved);
    out = given;
    // Natural residual: what one gradient step, projected back into the bounds, would change.
    const Lane gradient = columns_.combine(error) + lambda_ * tension_;
    const Lane violation = tension_ - clamp(tension_ - gradient, min_, max_);
    // The report's storage holds every capacity; padding lies beyond its size.
    std::memcpy(report.tension.data(), &tension_, sizeof(tension_));
    report.at_min = bitsNotAbove(tension_, min_);
    report.at_max = bitsNotAbove(max_, tension_);
    report.error = error.norm();
    report.kkt_residual = std::sqrt(violation.squaredNorm()) / (1 + wanted_.norm());
  }

  int strings_ = 0;
  double lambda_ = 1, stiffness_ = 1, degenerate_ = 0;
  bool factored_ = false;
  StringColumns<kLanes, kDof> columns_{};  ///< W A
  Lane min_, max_;
  Lane free_, held_;          ///< active set: 1 where free; the bound's tension where held
  Lane slope_{}, tension_{};  ///< m_i · y / λ, and that clamped
  Error wanted_ = Error::Zero(), y_ = Error::Zero();
  // Of one active set at one structure, kept for the next wrench.
  Error held_wrench_ = Error::Zero();
  SmallCholesky<kDof> cholesky_;

 public:
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace haptic
