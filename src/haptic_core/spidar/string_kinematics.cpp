#include "haptic_core/spidar/string_kinematics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/spidar/small_cholesky.h"

namespace haptic {

/// Lengths, their errors and the scaled structure matrix at one pose; one lane of strings per column.
template <int kDof>
struct StringLinearisation {
  using Lane = StringKinematics::Lane;
  alignas(64) std::array<Lane, kDof> column;  ///< force, torque / r, opening
  alignas(64) Lane length, error;

  void evaluate(const StringKinematics& k, const GripPose& x) noexcept {
    const Matrix3& R = x.X_BG.R;
    const Vector3& p = x.X_BG.p;
    const double per_radius = 1.0 / k.radius_;
    for (int i = 0; i < k.padded_; ++i) {
      double kx = k.knot_[0][i], ky = k.knot_[1][i], kz = k.knot_[2][i];
      if constexpr (kDof == 7) {
        kx += x.opening * k.knot_per_opening_[0][i];
        ky += x.opening * k.knot_per_opening_[1][i];
        kz += x.opening * k.knot_per_opening_[2][i];
      }
      const double ax = R(0, 0) * kx + R(0, 1) * ky + R(0, 2) * kz;
      const double ay = R(1, 0) * kx + R(1, 1) * ky + R(1, 2) * kz;
      const double az = R(2, 0) * kx + R(2, 1) * ky + R(2, 2) * kz;
      const double vx = k.exit_[0][i] - (p.x() + ax), vy = k.exit_[1][i] - (p.y() + ay),
                   vz = k.exit_[2][i] - (p.z() + az);
      const double l = std::sqrt(vx * vx + vy * vy + vz * vz);
      const double inverse = 1.0 / l;
      const double dx = vx * inverse, dy = vy * inverse, dz = vz * inverse;
      length[i] = l;
      column[0][i] = dx;
      column[1][i] = dy;
      column[2][i] = dz;
      if constexpr (kDof >= 6) {
        column[3][i] = (ay * dz - az * dy) * per_radius;
        column[4][i] = (az * dx - ax * dz) * per_radius;
        column[5][i] = (ax * dy - ay * dx) * per_radius;
      }
      if constexpr (kDof == 7) {
        const double gx = k.knot_per_opening_[0][i], gy = k.knot_per_opening_[1][i],
                     gz = k.knot_per_opening_[2][i];
        column[6][i] = dx * (R(0, 0) * gx + R(0, 1) * gy + R(0, 2) * gz) +
                       dy * (R(1, 0) * gx + R(1, 1) * gy + R(1, 2) * gz) +
                       dz * (R(2, 0) * gx + R(2, 1) * gy + R(2, 2) * gz);
      }
    }
  }

  /// Fills `error` against the measured lengths and clears the padding; returns the sum of squares [m²].
  double compare(const Lane& measured, int strings, int padded) noexcept {
    double sum = 0;
    for (int i = 0; i < strings; ++i) {
      error[i] = length[i] - measured[i];
      sum += error[i] * error[i];
    }
    for (int i = strings; i < padded; ++i) {
      error[i] = 0;
      for (int c = 0; c < kDof; ++c) column[c][i] = 0;
    }
    return sum;
  }
};

namespace {

// Damping after the first bad step, relative to the eigenvalues of AᵀA (about 1): small enough to stay close
// to Gauss-Newton, large enough to matter at the next try.
constexpr double kFirstDamping = 1e-2;
constexpr double kDampingFactor = 8;
constexpr double kLeastDamping = 1e-6;
constexpr double kGreatestDamping = 1e8;  // beyond, steps are rounding: a minimum that lengths cannot leave
// A linearisation means nothing beyond about half a radian or half a string.
constexpr double kLargestTurn = 0.7, kLargestShift = 0.5;

/// Dot product over `padded` lanes (a multiple of four), in four fixed partial sums that vectorise.
inline double dot(const double* a, const double* b, int padded) {
  double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
  for (int i = 0; i < padded; i += 4) {
    s0 += a[i] * b[i];
    s1 += a[i + 1] * b[i + 1];
    s2 += a[i + 2] * b[i + 2];
    s3 += a[i + 3] * b[i + 3];
  }
  return (s0 + s2) + (s1 + s3);
}

/// One Newton step to the nearest rotation: the error of R Rᵀ - 1 is squared.
Matrix3 orthonormalised(const Matrix3& R) {
  return R * (1.5 * Matrix3::Identity() - 0.5 * (R.transpose() * R));
}

template <int kDof>
GripPose moved(const GripPose& x, const std::array<double, kDof>& u, double radius) {
  GripPose y = x;
  y.X_BG.p += Vector3(u[0], u[1], u[2]);
  if constexpr (kDof >= 6) {
    const Vector3 turn = Vector3(u[3], u[4], u[5]) / radius;
    y.X_BG.R = orthonormalised(rotationFromVector(turn).toRotationMatrix() * x.X_BG.R);
  }
  if constexpr (kDof == 7) y.opening += u[6];
  return y;
}

/// Shortens `u` where it leaves the range of the linearisation; returns its norm [m].
template <int kDof>
double limitStep(std::array<double, kDof>& u, double largest_turn, double largest_shift) {
  double shift = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], turn = 0;
  if constexpr (kDof >= 6) turn = u[3] * u[3] + u[4] * u[4] + u[5] * u[5];
  double norm2 = shift + turn;
  if constexpr (kDof == 7) norm2 += u[6] * u[6];
  const double norm = std::sqrt(norm2);
  const double excess = std::max(std::sqrt(shift) / largest_shift, std::sqrt(turn) / largest_turn);
  if (excess <= 1) return norm;
  for (double& value : u) value /= excess;
  return norm / excess;
}

/// (AᵀA + damping) u = Aᵀ e of Levenberg and Marquardt. Good steps bring the damping back to zero: Gauss-Newton.
template <int kDof>
class DampedStep {
 public:
  /// A pose that is better: its equations.
  void accept(const StringLinearisation<kDof>& line, int padded) noexcept {
    damping_ = damping_ > kLeastDamping ? damping_ / kDampingFactor : 0;
    for (int a = 0; a < kDof; ++a) {
      gradient_[a] = dot(line.column[a].data(), line.error.data(), padded);
      for (int b = 0; b <= a; ++b) gram_[a][b] = dot(line.column[a].data(), line.column[b].data(), padded);
    }
  }
  /// A pose that is worse: shorter steps from the one before.
  void refuse() noexcept { damping_ = std::max(kFirstDamping, damping_ * kDampingFactor); }
  /// False: no damping is enough.
  bool solve(std::array<double, kDof>& u) noexcept {
    while (!factor() && damping_ < kGreatestDamping) refuse();
    if (damping_ >= kGreatestDamping) return false;
    u = gradient_;
    cholesky_.solve(u);
    return true;
  }
  /// The step of the last equations from other errors of the lengths [m].
  void solve(const StringLinearisation<kDof>& line, const typename StringLinearisation<kDof>::Lane& error, int padded,
             std::array<double, kDof>& u) const noexcept {
    for (int a = 0; a < kDof; ++a) u[a] = dot(line.column[a].data(), error.data(), padded);
    cholesky_.solve(u);
  }
  bool nearlyFree() const { return damping_ <= kFirstDamping; }  ///< the last step was hardly shortened

 private:
  bool factor() noexcept {
    typename SmallCholesky<kDof>::Rows damped = gram_;
    for (int a = 0; a < kDof; ++a) damped[a][a] += damping_;
    return cholesky_.factor(damped, kLeastDamping * kLeastDamping);
  }

  typename SmallCholesky<kDof>::Rows gram_;
  std::array<double, kDof> gradient_;
  SmallCholesky<kDof> cholesky_;
  double damping_ = 0;
};

/// The lengths' errors after a last step u that is so small that its effect on them is linear.
template <int kDof>
void takeErrors(const StringLinearisation<kDof>& line, const std::array<double, kDof>& u, PoseSolution& out) {
  const int strings = static_cast<int>(out.length_error.size());
  double sum = 0;
  for (int i = 0; i < strings; ++i) {
    double e = line.error[i];
    for (int a = 0; a < kDof; ++a) e -= line.column[a][i] * u[a];
    out.length_error[i] = e;
    sum += e * e;
  }
  out.residual = std::sqrt(sum / strings);
}

}  // namespace

StringKinematics::StringKinematics(const DeviceDef& def)
    : strings_(static_cast<int>(def.strings.size())), padded_((strings_ + 3) / 4 * 4), dof_(def.dof) {
  double knots = 0, shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < strings_; ++i) {
    const StringDef& s = def.strings[i];
    for (int c = 0; c < 3; ++c) {
      exit_[c][i] = s.p_BE[c];
      knot_[c][i] = s.p_GK[c];
      knot_per_opening_[c][i] = s.dp_GK[c];
    }
    knots += s.p_GK.squaredNorm();
    shortest = std::min(shortest, (s.p_BE - s.p_GK).norm());
  }
  for (int i = strings_; i < padded_; ++i) exit_[0][i] = 1e3;  // any length that is not zero
  // Knots in one point resist no turn; the rank test says so, if r is not zero.
  if (dof_ >= 6) radius_ = std::max(1e-6, std::sqrt(knots / strings_));
  curvature_length_ = dof_ >= 6 ? std::min(radius_, shortest) : shortest;
}

template <int kDof>
PoseSolution StringKinematics::solve(const StringVector& measured, const GripPose& guess, const PoseSettings& settings,
                                     const StringVector& nearby, GripPose& pose_nearby) const noexcept {
  PoseSolution out;
  out.pose = guess;
  out.length_error = StringVector::Constant(strings_, std::nan(""));
  out.residual = std::nan("");
  Lane target{};
  for (int i = 0; i < strings_; ++i) target[i] = measured[i];

  StringLinearisation<kDof> line;
  DampedStep<kDof> damped;
  std::array<double, kDof> u{};
  GripPose best = guess, candidate = guess;
  const double tolerance = settings.step_tolerance * curvature_length_;
  // Below this sum of squares two residuals differ by rounding only [m²].
  const double last_bits = 32 * std::numeric_limits<double>::epsilon() * curvature_length_;
  const double rounding = strings_ * (last_bits * last_bits);
  double best_cost = std::numeric_limits<double>::infinity();

  while (out.iterations < settings.max_iterations) {
    ++out.iterations;
    line.evaluate(*this, candidate);
    const double cost = line.compare(target, strings_, padded_);
    if (cost <= best_cost * (1 + 1e-9) + rounding) {
      best = candidate;
      best_cost = cost;
      damped.accept(line, padded_);
    } else if (!std::isfinite(cost) && !std::isfinite(best_cost)) {
      return out;
    } else {
      damped.refuse();
    }
    if (!damped.solve(u)) break;
    const double step = limitStep<kDof>(u, kLargestTurn * radius_, kLargestShift * curvature_length_);
    candidate = moved<kDof>(best, u, radius_);
    if (step <= tolerance && damped.nearlyFree() && best_cost == cost) {
      out.status = PoseStatus::kConverged;
      break;
    }
  }
  const bool converged = out.status == PoseStatus::kConverged;
  if (!converged) {
    out.status = PoseStatus::kIterationLimit;
    line.evaluate(*this, best);
    line.compare(target, strings_, padded_);
    u.fill(0);
  }
  out.pose = pose_nearby = converged ? candidate : best;
  takeErrors<kDof>(line, u, out);
  if (converged && &nearby != &measured) {
    for (int i = 0; i < strings_; ++i) line.error[i] += measured[i] - nearby[i];
    damped.solve(line, line.error, padded_, u);
    limitStep<kDof>(u, kLargestTurn * radius_, kLargestShift * curvature_length_);
    pose_nearby = moved<kDof>(best, u, radius_);
  }
  return out;
}

PoseSolution StringKinematics::solvePose(const StringVector& measured, const GripPose& guess, const PoseSettings& settings) const noexcept {
  GripPose same;
  return solvePose(measured, guess, measured, same, settings);
}

PoseSolution StringKinematics::solvePose(const StringVector& measured, const GripPose& guess, const StringVector& nearby,
                                         GripPose& pose_nearby, const PoseSettings& settings) const noexcept {
  switch (dof_) {
    case 3:
      return solve<3>(measured, guess, settings, nearby, pose_nearby);
    case 7:
      return solve<7>(measured, guess, settings, nearby, pose_nearby);
    default:
      return solve<6>(measured, guess, settings, nearby, pose_nearby);
  }
}

StringVector StringKinematics::lengths(const GripPose& pose) const noexcept {
  StringLinearisation<7> line;
  line.evaluate(*this, pose);
  StringVector l(strings_);
  for (int i = 0; i < strings_; ++i) l[i] = line.length[i];
  return l;
}

Eigen::VectorXd StringKinematics::singularValues(const GripPose& pose) const {
  return haptic::singularValues(scaledStructure(pose));
}

StructureMatrix StringKinematics::scaledStructure(const GripPose& pose) const noexcept {
  StructureMatrix A(strings_, dof_);
  const auto take = [&](auto& line) {
    line.evaluate(*this, pose);
    for (int c = 0; c < dof_; ++c) std::copy_n(line.column[static_cast<std::size_t>(c)].begin(), strings_, A.data() + c * strings_);
  };
  if (dof_ == 7) {
    StringLinearisation<7> line;
    take(line);
  } else {
    StringLinearisation<6> line;
    take(line);
  }
  return A;
}

StructureMatrix StringKinematics::structure(const GripPose& pose) const noexcept {
  StructureMatrix A = scaledStructure(pose);
  for (int c = 3; c < std::min(dof_, 6); ++c) A.col(c) *= radius_;
  return A;
}

}  // namespace haptic
