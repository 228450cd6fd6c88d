#include "haptic_core/spidar/spidar.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace {

// Where a calibration's pose lies farther from a sound one than this, the grip is not where the user says: a hand that holds it
// at home is off by a few millimetres. Who asks again within kMeant means it.
constexpr double kFarFromJig = 0.01, kTurnedFromJig = 0.35;  // [m], [rad]
constexpr double kMeant = 10;                                // [s]
// A grip that is pushed stands where force and hand agree, not where the user says: a calibration there makes the strings contradict each
// other as soon as it moves.
constexpr double kPushedFromJig = 0.5e-3, kPushTurnedFromJig = 0.02;  // [m], [rad]

}  // namespace

const char* toString(DeviceState state) {
  switch (state) {
    case DeviceState::kUncalibrated:
      return "UNCALIBRATED";
    case DeviceState::kReady:
      return "READY";
    case DeviceState::kEnabled:
      return "ENABLED";
    case DeviceState::kReduced:
      return "REDUCED";
    case DeviceState::kFault:
      return "FAULT";
  }
  return "FAULT";
}

Spidar::Spidar(const DeviceDef& def, const SpidarSettings& settings)
    : def_(def),
      settings_(settings),
      velocity_memory_(1 / (2 * M_PI * settings.velocity_cutoff_hz)),
      kinematics_(def),
      distribution_(def, kinematics_),
      health_(def, settings.health),
      freshness_(settings.freshness),
      still_(def),
      steady_lengths_(def),
      max_force_(def.max_force),
      max_torque_(def.max_torque) {
  const int n = kinematics_.strings();
  zero_length_ = StringVector::Zero(n);
  length_ = StringVector::Constant(n, std::nan(""));
  told_ = StringVector::Zero(n);
  solution_.length_error = StringVector::Constant(n, std::nan(""));
  solution_.residual = std::nan("");
  distribution_.solve(Wrench{});
}

void Spidar::ask(const DeviceRequests& requests) noexcept {
  requests_.recover = requests_.recover || requests.recover;
  if (requests.enable >= 0) requests_.enable = requests.enable;
  if (!requests.calibrate) return;
  requests_.calibrate = true;
  requests_.jig = requests.jig;
}

void Spidar::restoreCalibration(const StringVector& zero_length, const GripPose& guess) noexcept {
  zero_length_ = zero_length;
  startAt(guess);
}

void Spidar::adopt(const Calibration& calibration, const GripPose& guess) {
  if (calibration.p_BE.size() != def_.strings.size())
    throw SetupError("calibration", "has " + std::to_string(calibration.p_BE.size()) + " strings, " + def_.name +
                     " has " + std::to_string(def_.strings.size()), "calibrate this device");
  def_ = calibration.applied(def_);
  kinematics_ = StringKinematics(def_);
  distribution_ = TensionDistribution(def_, kinematics_);
  distribution_.solve(Wrench{});
  restoreCalibration(calibration.zero_length, guess);
}

void Spidar::startAt(const GripPose& pose) noexcept {
  solution_ = PoseSolution{};
  solution_.pose = pose;
  solution_.length_error = StringVector::Zero(kinematics_.strings());
  steady_ = pose;
  steady_lengths_.forget();
  twist_ = Twist{};
  opening_rate_ = 0;
  health_.forget();
  still_.forget();
  calibrated_ = true;
  doubted_ = false;
  beginAnew(settings_.enable_ramp_s);  // the pose is another one: so may the wrench be
  if (state_ == DeviceState::kUncalibrated) state_ = DeviceState::kReady;
}

DeviceRequests Spidar::takeRequests(const DeviceSample& sample) noexcept {
  DeviceRequests requests = requests_;
  requests.calibrate = requests_.calibrate && bringsCounts(sample.status);
  requests_.calibrate = requests_.calibrate && !requests.calibrate;
  requests_.recover = false;
  requests_.enable = -1;
  return requests;
}

/// A sound pose that lies far from the jig's says that the grip is not there; under force, one that is not at it.
bool Spidar::mayCalibrate(const GripPose& jig) const noexcept {
  const bool sound = poseValid() && !doubted_ && state_ != DeviceState::kFault && state_ != DeviceState::kReduced &&
                     !health_.contradicted() && health_.corrections() == 0;
  const bool pushed = presents() && asked_.force.norm() > kRestForce;
  if (!sound || (refusal_ > 0 && !pushed)) return true;
  const double turned = def_.dof == 3 ? 0 : vectorFromRotation(Quaternion(jig.X_BG.R * pose().R.transpose())).norm();
  return (pose().p - jig.X_BG.p).norm() <= (pushed ? kPushedFromJig : kFarFromJig) &&
         turned <= (pushed ? kPushTurnedFromJig : kTurnedFromJig);
}

void Spidar::follow(const DeviceRequests& requests, const DeviceSample& sample) noexcept {
  const bool may_calibrate = mayCalibrate(requests.jig);
  recovered_ = requests.recover && (state_ == DeviceState::kFault || state_ == DeviceState::kReduced);
  if (recovered_) {
    state_ = calibrated_ ? DeviceState::kReady : DeviceState::kUncalibrated;
    zero_current_ = false;
    enabled_ = false;  // who recovers says that the cause is gone, not that a hand is ready for force
    health_.forget();
    still_.forget();
    freshness_.forgetLosses();
  }
  if (requests.calibrate && !may_calibrate) refusal_ = kMeant;
  if (requests.calibrate && may_calibrate) {
    const StringVector length = kinematics_.lengths(requests.jig);
    for (int i = 0; i < kinematics_.strings(); ++i)
      zero_length_[i] = length[i] - static_cast<double>(sample.counts[i]) * def_.strings[i].length_per_count;
    startAt(requests.jig);
    refusal_ = 0;
  }
  if (requests.enable >= 0) {
    enabled_ = requests.enable == 1;
    waits_ = false;  // somebody has asked, or does not want it
  }
  if (requests.enable == 0) interrupted_ = false;
  if (requests.recover || requests.enable == 1) stopped_ = false;
  if (stopped_) flags_ |= kStopped;
  if (!held_) flags_ |= kReleased;
  if ((!enabled_ || !held_) && presents()) state_ = DeviceState::kReady;
}

void Spidar::stop() noexcept {
  enabled_ = interrupted_ = false;
  stopped_ = true;
  requests_ = {};  // earlier requests must not act later
}

void Spidar::name(const CauseRow& row) noexcept {
  cause_ = row.cause;
  cause_flags_ = flags_;
  late_s_ = clock_.lateBy();
}

void Spidar::enterFault(const CauseRow& row, bool zero_current) noexcept {
  const bool lost = row.loses_lengths && calibrated_;
  if (state_ != DeviceState::kFault || lost) name(row);
  state_ = DeviceState::kFault;
  zero_current_ = zero_current_ || zero_current;
  doubted_ = true;
  if (row.loses_lengths) calibrated_ = false;
}

/// Applies the table's consequence to the force.
void Spidar::obey(const CauseRow& row) noexcept {
  const bool latched = state_ == DeviceState::kFault || state_ == DeviceState::kReduced;
  // A state that `recover` left is entered again while its cause is there; a pause lasts as long as its own cause.
  const Consequence what = presents() || recovered_ || interrupted_ ? row.presenting : row.idle;
  paused_ = what == Consequence::kPause;
  interrupted_ = paused_ && (interrupted_ || presents());
  switch (what) {
    case Consequence::kSay:
      break;
    case Consequence::kPause:
      enabled_ = enabled_ && state_ != DeviceState::kReduced;  // only a sound device comes back by itself
      if (presents()) state_ = DeviceState::kReady;
      break;
    case Consequence::kReduce:
      if (state_ != DeviceState::kEnabled) break;
      state_ = DeviceState::kReduced;
      name(row);
      return;
    case Consequence::kRest:
    case Consequence::kStop:
      return enterFault(row, what == Consequence::kStop);
  }
  if (latched && state_ != DeviceState::kReady) return;  // its cause stands
  name(row);
  cause_flags_ = 0;
}

/// A silence has lasted, whoever made it: what the device was asked before it, this tick's requests included, is not what a person
/// wants now. The state is READY, or the FAULT that the table has found.
void Spidar::awaitPerson() noexcept {
  if (!clock_.forceWaits() || !enabled_) return;
  enabled_ = interrupted_ = false;
  waits_ = true;
  absence_s_ = clock_.absence();
  asleep_ = clock_.late() && clock_.asleep();
  endAtOnce();
  if (presents()) state_ = DeviceState::kReady;
}

/// Counts → lengths. False: they make no pose.
bool Spidar::takeLengths(const DeviceSample& sample, double elapsed) noexcept {
  for (int i = 0; i < kinematics_.strings(); ++i)
    length_[i] = zero_length_[i] + static_cast<double>(sample.counts[i]) * def_.strings[i].length_per_count;
  switch (health_.screen(length_, kinematics_, solution_.pose, elapsed)) {
    case CountScreen::Verdict::kMotion:
      return true;
    case CountScreen::Verdict::kReplaced:
      flags_ |= kCountRefused;
      return true;
    case CountScreen::Verdict::kHeld:
      flags_ |= kCountRefused;
      return false;
    case CountScreen::Verdict::kSlipped:
      flags_ |= kEncoderJump;
      zero_length_[health_.suspect()] -= health_.slip();
      return true;
    case CountScreen::Verdict::kLost:
      break;
  }
  flags_ |= kEncoderJump;
  signs_ |= kCountersLost;
  return false;
}

/// The invariant: see freshness.h.
void Spidar::checkFreshness(const DeviceSample& sample, bool plausible, double h, const TimeLost& lost) noexcept {
  freshness_.take(sample, plausible, h);
  if (!bringsCounts(sample.status)) flags_ |= kSampleStale;
  const bool silent = sample.status == LinkStatus::kSilent || sample.status == LinkStatus::kDisconnected;
  const bool answered = bringsCounts(sample.status) && freshness_.carriesForce(1e-6 * sample.age_us, h);
  clock_.take(sample, silent || (!answered && !freshness_.carriesForce(h)), h, lost);
  if (answered && calibrated_ && !freshness_.carriesForce(h)) signs_ |= kCountsRefusedLong;
  if (clock_.linkLost()) flags_ |= kLinkLost;
  if (clock_.late() && !clock_.silenceIsTheirs()) flags_ |= kLoopLate;
  if (clock_.silenceLasts()) signs_ |= kSilenceLasts;
  if (freshness_.lossy()) flags_ |= kAnswersLost;
  if (freshness_.failing()) signs_ |= kAnswersFailing;
  if (sample.status == LinkStatus::kUnguarded) flags_ |= kUnguarded;
}

/// A rate above the wire's, and a delay that leaves no stable wall: once force is on, a fifth of slack keeps little of it.
void Spidar::checkWire(double h) noexcept {
  // A thousandth of jitter is no other rate.
  if (h * def_.max_rate_hz <= 0.999) {
    flags_ |= kOverRate;
    if (settings_.refuse_over_rate) signs_ |= kRateRefused;
  }
  stable_stiffness_ = freshness_.stableStiffness(def_.grip_damping, def_.delay_s, h);
  const double share = stable_stiffness_ / freshness_.leastStiffness();
  if (share < 1) flags_ |= kDelayTooLong;
  if (share < 0.8) signs_ |= kForceRefused;
}

void Spidar::updatePose(const PoseSolution& solved, const GripPose& steady, double h) noexcept {
  const Pose &X0 = steady_.X_BG, &X1 = steady.X_BG;
  // Angle of R1 R0ᵀ from its skew part: exact to θ³/6, and θ < 0.1 rad per tick.
  const Matrix3 turn = X1.R * X0.R.transpose();
  const Vector3 theta =
      0.5 * Vector3(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
  const double gain = 1 - velocity_memory_.over(h);
  twist_.angular += gain * (theta / h - twist_.angular);
  twist_.linear += gain * ((X1.p - X0.p) / h - twist_.linear);
  opening_rate_ += gain * ((steady.opening - steady_.opening) / h - opening_rate_);
  solution_ = solved;
  steady_ = steady;
}

/// False: no pose can be trusted.
bool Spidar::checkResidual(const PoseSolution& solved, const GripPose& last, double h) noexcept {
  const StringVerdict verdict = health_.judge(solved, length_, kinematics_, last, h);
  if (verdict != StringVerdict::kTrue) flags_ |= kResidualHigh;
  if (verdict == StringVerdict::kNamed) signs_ |= kStringNamed;
  if (verdict == StringVerdict::kBroken) signs_ |= kLengthsBroken;
  return verdict != StringVerdict::kBroken;
}

/// Time [s] since `last_ns`, by the stamps of the counts where there are any: ticks may come late.
double Spidar::elapsedSince(std::int64_t last_ns, const DeviceSample& sample, double since, double h) const noexcept {
  if (last_ns <= 0 || sample.stamp_ns <= 0) return since;
  return std::max(0.25 * h, 1e-9 * static_cast<double>(sample.stamp_ns - last_ns));
}

void Spidar::watchCounters(const DeviceSample& sample, double elapsed) noexcept {
  still_.take(sample.counts, elapsed);
  if (!presents()) still_.forgetForce();
  if (presents() && still_.stuckUnder(achievedWrench().force, elapsed)) flags_ |= kCountersStill;
  if (still_.frozen()) flags_ |= kCountersFrozen;
  if (const std::uint32_t some = still_.boardStill()) {
    flags_ |= kSomeCountersStill;
    if (state_ != DeviceState::kFault) still_strings_ = some;
  }
}

void Spidar::sense(const DeviceSample& sample, double h, const TimeLost& lost) noexcept {
  flags_ = 0;
  signs_ = 0;
  pose_is_new_ = false;
  buttons_ = sample.buttons;
  // The exchange of this sample sent the last drive; its counts answer the drive of age_ticks before.
  currentless_ = zero_drives_ > 0 && (currentless_ || (bringsCounts(sample.status) && zero_drives_ > sample.age_ticks));
  refusal_ = std::max(0.0, refusal_ - h);
  follow(takeRequests(sample), sample);
  if (refusal_ > 0) flags_ |= kCalibrationRefused;
  since_counts_ += h;
  since_pose_ += h;
  if (sample.status == LinkStatus::kRestarted) flags_ |= kCounterRestarted;
  bool plausible = bringsCounts(sample.status);
  if (plausible) {
    const double elapsed = elapsedSince(counts_stamp_ns_, sample, since_counts_, h);
    const bool stood = freshness_.tooLong(since_counts_) || freshness_.tooLong(lost.seconds);
    if (stood || freshness_.gap(pose_stamp_ns_, sample.stamp_ns)) {  // the way back into force is a ramp
      flags_ |= kSampleStale;
      endAtOnce();
      told_.setZero();
      health_.forgetMotion();
      still_.forget();
    }
    watchCounters(sample, elapsed);
    plausible = !calibrated_ || (takeLengths(sample, elapsed) && takePose(sample, elapsed));
    plausible = plausible && !(flags_ & kCountRefused);  // a pose without one string is a pose, but not a fresh count of it
    since_counts_ = 0;
    counts_stamp_ns_ = sample.stamp_ns;
  }
  checkFreshness(sample, plausible, h, lost);
  checkWire(h);
  obey(diagnose(flags_ | signs_, sample.status, sample.finding));
  awaitPerson();
  if (waits_) flags_ |= kForceWaits;
  if (enabled_ && held_ && state_ == DeviceState::kReady && !paused_ && !(flags_ & kDelayTooLong) && freshness_.carriesForce(h)) {
    state_ = DeviceState::kEnabled;
    rise_s_ = std::max(rise_s_, settings_.enable_ramp_s);
  }
}

/// False: these counts make no pose. What one reading does is the screen's business (takeLengths); lengths that contradict
/// each other for longer are followed at a reduced force until it is known which string it is.
bool Spidar::takePose(const DeviceSample& sample, double elapsed) noexcept {
  if (health_.corrections() > 0) flags_ |= kStringCorrected;
  const GripPose last = solution_.pose;
  const double since_pose = elapsedSince(pose_stamp_ns_, sample, since_pose_, elapsed);
  GripPose steady;
  const PoseSolution solved = kinematics_.solvePose(length_, last, steady_lengths_.read(length_, since_pose), steady);
  if (!checkResidual(solved, last, elapsed)) return false;
  if (solved.status != PoseStatus::kConverged) {
    flags_ |= kPoseNotConverged;
    return false;
  }
  updatePose(solved, steady, since_pose);
  since_pose_ = 0;
  pose_is_new_ = true;
  pose_stamp_ns_ = sample.stamp_ns;
  return true;
}

}  // namespace haptic
