#include "haptic_core/spidar/count_screen.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStrings, kMaxStrings>;

constexpr double kSigmas = 6;  // bounds of what chance brings in ten hours of ticks

/// Largest χ² of n numbers that chance brings: mean and kSigmas standard deviations.
double likelyCost(int n) {
  return n + kSigmas * std::sqrt(2.0 * n);
}

}  // namespace

CountScreen::CountScreen(const DeviceDef& def, const ScreenSettings& settings)
    : settings_(settings), strings_(static_cast<int>(def.strings.size())) {
  for (const StringDef& string : def.strings) step_ = std::max(step_, std::fabs(string.length_per_count));
  before_ = rate_ = read_ = StringVector::Zero(strings_);
}

void CountScreen::forget() noexcept {
  known_ = doubts_ = 0;
  since_ = shift_ = 0;
  suspect_ = -1;
  single_ = false;
}

void CountScreen::believe(const StringVector& length) noexcept {
  if (known_ > 0) rate_ = (length - before_) / since_;
  before_ = length;
  known_ = std::min(2, known_ + 1);
  since_ = 0;
  doubts_ = 0;
}

CountScreen::Explanation CountScreen::explain(const StringVector& deviation, const StructureMatrix& A,
                                              double elapsed) const noexcept {
  const double way = rate_.cwiseAbs().maxCoeff() * elapsed;
  const double bend = way * way / (2 * before_.minCoeff());
  const double variance = step_ * step_ + bend * bend;
  const Square AAt = A.lazyProduct(A.transpose());
  const StringVector late = settings_.jitter * elapsed * rate_;
  const auto covariance = [&](double acceleration) -> Square {
    const double reach = acceleration * elapsed * since_;
    Square S = reach * reach * AAt;
    S += late.lazyProduct(late.transpose());
    S.diagonal().array() += variance;
    return S;
  };
  Explanation found;
  const Eigen::LLT<Square> hand(covariance(settings_.acceleration));
  Square inverse = Square::Identity(strings_, strings_);
  hand.solveInPlace(inverse);
  const StringVector white = inverse.lazyProduct(deviation);
  found.cost = deviation.dot(white);
  double saved = -1;
  for (int i = 0; i < strings_; ++i) {
    const double gain = white[i] * white[i] / inverse(i, i);
    if (gain <= saved) continue;
    saved = gain;
    found.string = i;
  }
  found.shift = white[found.string] / inverse(found.string, found.string);
  const bool one = found.cost - saved <= likelyCost(strings_ - 1);
  // One string that is off by less than what counts as a deviation is a motion that the model does not know, not a fault.
  found.smooth = found.cost <= likelyCost(strings_) || (one && std::fabs(found.shift) < settings_.least_change);
  found.one = !found.smooth && one;
  StringVector whitened = deviation;
  const Eigen::LLT<Square> blow(covariance(settings_.impact * settings_.acceleration));
  blow.matrixL().solveInPlace(whitened);
  found.moved = whitened.squaredNorm() <= likelyCost(strings_);
  return found;
}

/// Verdict on lengths that are odd, or were before. `found` explains how they deviate from the believed ones;
/// `persists`: since the reading before, they moved as everything did before the doubt.
CountScreen::Verdict CountScreen::settle(StringVector& length, const Explanation& found,
                                         bool persists) noexcept {
  const bool first = doubts_ == 0;
  ++doubts_;
  if (!first && persists && single_ && std::fabs(shift_) >= settings_.least_slip) {
    if (std::fabs(shift_) > settings_.largest_slip) return Verdict::kLost;
    // The first reading is nearest to the last believed one: its estimate is kept.
    length[suspect_] -= shift_;
    believe(length);
    return Verdict::kSlipped;
  }
  if (found.smooth || (found.moved && !(first && found.one))) {  // a spike is over, or the grip was hit
    believe(length);
    return Verdict::kMotion;
  }
  suspect_ = found.string;
  shift_ = found.shift;
  single_ = found.one;
  if (doubts_ >= settings_.patience) return Verdict::kLost;
  if (!single_) return Verdict::kHeld;
  length[suspect_] -= shift_;
  return Verdict::kReplaced;
}

CountScreen::Verdict CountScreen::judge(StringVector& length, const StringKinematics& kinematics,
                                        const GripPose& pose, double elapsed) noexcept {
  since_ += elapsed;
  if (known_ < 2 || !(elapsed > 0)) {
    believe(length);
    return Verdict::kMotion;
  }
  const StringVector deviation = length - before_ - since_ * rate_;
  if (doubts_ == 0 && deviation.cwiseAbs().maxCoeff() <= settings_.least_change) {
    believe(length);
    return Verdict::kMotion;
  }
  const StructureMatrix A = kinematics.scaledStructure(pose);
  const Explanation found = explain(deviation, A, since_);
  bool persists = false;
  if (doubts_ > 0) {
    const Explanation onward = explain(length - read_ - elapsed * rate_, A, elapsed);
    persists = onward.smooth && onward.cost < found.cost;
  }
  read_ = length;
  return settle(length, found, persists);
}

}  // namespace haptic
