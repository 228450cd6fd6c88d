#include "haptic_core/spidar/string_health.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace haptic {

StringHealth::StringHealth(const DeviceDef& def, const HealthSettings& settings)
    : settings_(settings),
      strings_(static_cast<int>(def.strings.size())),
      step_(strings_),
      continuous_(strings_),
      heat_(StringVector::Zero(strings_)) {
  for (int i = 0; i < strings_; ++i) {
    step_[i] = def.strings[i].length_per_count;
    continuous_[i] = settings.continuous_share * def.strings[i].max_tension;
  }
}

void StringHealth::forget() noexcept {
  have_counts_ = false;
  residual_time_ = suspect_error_ = 0;
  suspect_ = -1;
}

int StringHealth::findJump(const std::array<std::int64_t, kMaxStrings>& counts, double elapsed) noexcept {
  int jumped = -1;
  for (int i = 0; have_counts_ && i < strings_; ++i) {
    const double moved = static_cast<double>(counts[i] - last_counts_[i]) * step_[i];
    if (std::fabs(moved) <= settings_.max_string_speed * elapsed) continue;
    jumped = suspect_ = i;
    suspect_error_ = moved;
  }
  last_counts_ = counts;
  have_counts_ = true;
  return jumped;
}

void StringHealth::findSuspect(const PoseSolution& solution, const StringKinematics& kinematics) noexcept {
  using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxDof, kMaxDof>;
  using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDof, 1>;
  const StructureMatrix A = kinematics.scaledStructure(solution.pose);
  const Normal normal = A.transpose().lazyProduct(A);
  const Eigen::LLT<Normal> factor(normal);
  double most = 0;
  for (int i = 0; i < strings_; ++i) {
    const Row a = A.row(i).transpose();
    const double free = std::max(1e-6, 1 - a.dot(factor.solve(a)));
    const double explained = solution.length_error[i] * solution.length_error[i] / free;
    if (explained <= most) continue;
    most = explained;
    suspect_ = i;
    suspect_error_ = -solution.length_error[i] / free;
  }
}

void StringHealth::save(std::vector<double>& out) const {
  out.insert(out.end(), {have_counts_ ? 1.0 : 0.0, residual_time_, suspect_error_, hottest_,
                         static_cast<double>(suspect_), static_cast<double>(hottest_motor_)});
  for (int i = 0; i < strings_; ++i) out.push_back(heat_[i]);
  for (int i = 0; i < strings_; ++i) out.push_back(static_cast<double>(last_counts_[i]));
}

const double* StringHealth::restore(const double* in) noexcept {
  have_counts_ = *in++ != 0;
  residual_time_ = *in++;
  suspect_error_ = *in++;
  hottest_ = *in++;
  suspect_ = static_cast<int>(*in++);
  hottest_motor_ = static_cast<int>(*in++);
  for (int i = 0; i < strings_; ++i) heat_[i] = *in++;
  for (int i = 0; i < strings_; ++i) last_counts_[i] = static_cast<std::int64_t>(*in++);
  return in;
}

StringVerdict StringHealth::judge(const PoseSolution& solution, const StringKinematics& kinematics,
                                  double h) noexcept {
  const double share = solution.residual / settings_.residual_limit;
  if (share <= 1) {  // not so for a residual that is no number
    residual_time_ = 0;
    return StringVerdict::kTrue;
  }
  residual_time_ += h;
  const bool broken = !(share <= settings_.break_factor);
  // Half a tick of slack: sums of h must not decide by rounding.
  if (!broken && residual_time_ < settings_.residual_time_s - 0.5 * h) return StringVerdict::kTrue;
  findSuspect(solution, kinematics);
  return broken ? StringVerdict::kBroken : StringVerdict::kDoubtful;
}

double StringHealth::heat(const StringVector& tension, double h) noexcept {
  hottest_ = 0;
  for (int i = 0; i < strings_; ++i) {
    const double load = tension[i] / continuous_[i];
    heat_[i] += h / settings_.heat_time_s * (load * load - heat_[i]);
    if (heat_[i] <= hottest_) continue;
    hottest_ = heat_[i];
    hottest_motor_ = i;
  }
  return std::min(1.0, std::max(0.0, (settings_.too_hot - hottest_) / (settings_.too_hot - settings_.hot)));
}

}  // namespace haptic
