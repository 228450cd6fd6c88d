// What a Spidar remembers from tick to tick, as numbers, and what may be tuned while it runs.
#include <cmath>
#include <cstring>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace {

constexpr int kPoseNumbers = 12;

void put(std::vector<double>& out, const double* numbers, int n) { out.insert(out.end(), numbers, numbers + n); }

void put(std::vector<double>& out, const Pose& X) {
  put(out, X.R.data(), 9);
  put(out, X.p.data(), 3);
}

void take(const double*& in, double* numbers, int n) {
  std::memcpy(numbers, in, static_cast<std::size_t>(n) * sizeof(double));
  in += n;
}

void take(const double*& in, Pose& X) {
  take(in, X.R.data(), 9);
  take(in, X.p.data(), 3);
}

}  // namespace

std::vector<double> Spidar::save() const {
  std::vector<double> out;
  save(out);
  return out;
}

void Spidar::save(std::vector<double>& out) const {
  const int n = kinematics_.strings();
  out.assign({static_cast<double>(n),
              distribution_.ruleLambda(),
              max_force_,
              max_torque_,
              static_cast<double>(state_),
              calibrated_ ? 1.0 : 0.0,
              zero_current_ ? 1.0 : 0.0,
              enabled_ ? 1.0 : 0.0,
              opening_rate_,
              ramp_,
              heat_share_,
              since_counts_,
              since_pose_,
              static_cast<double>(pose_stamp_ns_),  // whole up to 2⁵³ ns, 104 days
              static_cast<double>(cause_),
              fade_.load(),
              solution_.residual,
              solution_.pose.opening,
              static_cast<double>(solution_.iterations),
              static_cast<double>(solution_.status)});
  for (const StringDef& string : def_.strings) put(out, string.p_BE.data(), 3);  // a calibration may have moved them
  put(out, solution_.pose.X_BG);
  put(out, twist_.vector().data(), 6);
  put(out, asked_.vector().data(), 6);
  put(out, zero_length_.data(), n);
  put(out, length_.data(), n);
  put(out, solution_.length_error.data(), n);
  put(out, told_.data(), n);
  health_.save(out);
  freshness_.save(out);
  out.resize(out.size() + 2 * static_cast<std::size_t>(n));
  distribution_.saveActiveSet(out.data() + out.size() - 2 * n);
}

/// The exits as a calibration left them, three numbers per string.
void Spidar::placeExits(const double* numbers) {
  bool moved = false;
  for (StringDef& string : def_.strings) {
    const Vector3 p_BE(numbers[0], numbers[1], numbers[2]);
    moved = moved || p_BE != string.p_BE;
    string.p_BE = p_BE;
    numbers += 3;
  }
  if (!moved) return;
  kinematics_ = StringKinematics(def_);
  distribution_ = TensionDistribution(def_, kinematics_);
}

void Spidar::restore(const std::vector<double>& memory) {
  const int n = kinematics_.strings();
  constexpr int kHead = 20;
  const std::size_t expected = kHead + 3 * n + kPoseNumbers + 12 + 4 * n + StringHealth::numbers(n) +
                               Freshness::kMemoryNumbers + 2 * n;
  if (memory.size() != expected || memory[0] != n) {
    throw SetupError(def_.name, "the saved memory is of another device or version", "use the description it was saved with");
  }
  placeExits(memory.data() + kHead);
  const double* in = memory.data() + 1;
  distribution_.setRuleLambda(*in++);
  max_force_ = *in++;
  max_torque_ = *in++;
  state_ = static_cast<DeviceState>(static_cast<int>(*in++));
  calibrated_ = *in++ != 0;
  zero_current_ = *in++ != 0;
  enabled_ = *in++ != 0;
  opening_rate_ = *in++;
  ramp_ = *in++;
  heat_share_ = *in++;
  since_counts_ = *in++;
  since_pose_ = *in++;
  pose_stamp_ns_ = static_cast<std::int64_t>(*in++);
  cause_ = static_cast<unsigned>(*in++);
  fade_ = *in++;
  solution_.residual = *in++;
  solution_.pose.opening = *in++;
  solution_.iterations = static_cast<int>(*in++);
  solution_.status = static_cast<PoseStatus>(static_cast<int>(*in++));
  in += 3 * n;  // the exits, placed above
  take(in, solution_.pose.X_BG);
  take(in, twist_.angular.data(), 3);
  take(in, twist_.linear.data(), 3);
  take(in, asked_.torque.data(), 3);
  take(in, asked_.force.data(), 3);
  take(in, zero_length_.data(), n);
  take(in, length_.data(), n);
  solution_.length_error.resize(n);
  take(in, solution_.length_error.data(), n);
  take(in, told_.data(), n);
  in = freshness_.restore(health_.restore(in));
  distribution_.restoreActiveSet(in);  // a guess that may decide the last bit
  distribution_.setStructure(kinematics_.scaledStructure(solution_.pose));
}

void Spidar::tune(const Tuning& tuning) {
  const auto checked = [this](const char* what, double value, double low, double high) {
    if (value >= low && value <= high) return;
    std::ostringstream is, give;
    is << what << " is " << value;
    give << "give " << low << " to " << high;
    throw SetupError(def_.name, is.str(), give.str());
  };
  // Below 1e-6 tensions jump at the border of what can be presented; above 1 a strong wrench loses half of itself.
  checked("lambda", tuning.lambda, 1e-6, 1);
  checked("max_force [N]", tuning.max_force, 1e-3, def_.max_force);
  checked("max_torque [N·m]", tuning.max_torque, 1e-5, def_.max_torque);
  distribution_.setRuleLambda(tuning.lambda);
  max_force_ = tuning.max_force;
  max_torque_ = tuning.max_torque;
}

}  // namespace haptic
