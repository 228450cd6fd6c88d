#include "haptic_core/spidar/slip_diagnosis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {
namespace {

using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxDof, kMaxDof>;
using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDof, 1>;

// Below this share of its own error a string does not show at this pose: its offset is left as it is.
constexpr double kBlind = 1e-3;
// Ticks in which the hypotheses only find their poses: Newton's steps from a pose that a slip of 20 mm has
// bent.
constexpr double kSettling_s = 0.005;

}  // namespace

SlipDiagnosis::SlipDiagnosis(const DeviceDef& def, const DiagnosisSettings& settings)
    : settings_(settings), strings_(static_cast<int>(def.strings.size())) {
  for (const StringDef& string : def.strings) step_ = std::max(step_, std::fabs(string.length_per_count));
}

void SlipDiagnosis::forget() noexcept {
  time_ = evidence_ = 0;
  best_ = -1;
  candidates_ = 0;
  belief_.fill(Belief{});
}

void SlipDiagnosis::add(const StringVector& length, const StringKinematics& kinematics, const GripPose& start,
                        double elapsed) noexcept {
  if (time_ == 0)
    for (int j = 0; j < strings_; ++j) belief_[j].pose = start;
  time_ += elapsed;
  const double keep = elementary::exp(-elapsed / settings_.memory_s);
  const bool counts = time_ > kSettling_s;
  if (counts) evidence_ = keep * evidence_ + (1 - keep);
  for (int j = 0; j < strings_; ++j) {
    Belief& b = belief_[j];
    StringVector corrected = length;
    corrected[j] -= b.offset;
    const PoseSolution solved = kinematics.solvePose(corrected, b.pose);
    double unexplained = solved.residual * solved.residual * strings_, share = 0;
    if (solved.status == PoseStatus::kConverged) {
      b.pose = solved.pose;
      const StructureMatrix A = kinematics.scaledStructure(solved.pose);
      const Eigen::LLT<Normal> factor(A.transpose().lazyProduct(A));
      Row half = A.row(j).transpose();
      factor.matrixL().solveInPlace(half);
      share = 1 - half.squaredNorm();
      if (share > kBlind) {
        const double e = solved.length_error[j];
        b.offset -= e / share;
        unexplained = std::max(0.0, unexplained - e * e / share);
      } else {
        share = 0;
      }
    }
    if (!std::isfinite(unexplained)) unexplained = 1;  // a metre squared: this is not what happened
    if (!counts) continue;
    b.unexplained = keep * b.unexplained + (1 - keep) * unexplained;
    b.weight = keep * b.weight + (1 - keep) * share;
    b.sum = keep * b.sum + (1 - keep) * share * b.offset;
    b.square = keep * b.square + (1 - keep) * share * b.offset * b.offset;
  }
  rank();
}

void SlipDiagnosis::rank() noexcept {
  best_ = 0;
  for (int j = 1; j < strings_; ++j)
    if (belief_[j].cost() < belief_[best_].cost()) best_ = j;
  const double least = std::max(belief_[best_].cost(), evidence_ * settings_.noise * step_ * step_);
  candidates_ = 0;
  for (int j = 0; j < strings_; ++j)
    if (belief_[j].cost() <= settings_.ratio * least) candidates_ |= 1u << j;
}

bool SlipDiagnosis::clear() const {
  return time_ >= settings_.least_time_s && best_ >= 0 && candidates_ == 1u << best_;
}

}  // namespace haptic
