// The wrench of a Spidar: limits, gain and law of change, then tensions and drive.
#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace {

// More than this share of the wrench lost to the tensions' bounds is worth a flag; λ alone loses up to 3 %.
constexpr double kPresentableShare = 0.05;
constexpr double kUnfelt = 0.05;  // [N]; a step is felt from about so much on

/// `v` shortened to length `limit`; true when it was longer.
bool clampNorm(Vector3& v, double limit) {
  const double norm = v.norm();
  if (!(norm > limit)) return false;
  v *= limit / norm;
  return true;
}

}  // namespace

Wrench Spidar::withinLimits(Wrench F_G_B) const noexcept {
  clampNorm(F_G_B.force, max_force_);
  clampNorm(F_G_B.torque, max_torque_);
  return F_G_B;
}

void Spidar::beginAnew(double seconds) noexcept {
  rise_s_ = gain_ < 1 && presents() ? std::max(rise_s_, seconds) : seconds;
  gain_ = 0;
}

bool Spidar::presses() const noexcept {
  return asked_.force.norm() > kUnfelt || asked_.torque.norm() > kUnfelt * kinematics_.knotRadius();
}

/// Force that must not act for another tick: STOP, a fault, the dead-man switch, an interruption.
bool Spidar::endsAtOnce() const noexcept {
  return stopped_ || !held_ || paused_ || state_ == DeviceState::kFault || state_ == DeviceState::kUncalibrated;
}

void Spidar::endAtOnce() noexcept {
  gain_ = grasp_ = 0;
  rise_s_ = settings_.enable_ramp_s;  // every way back into force is a ramp
  wanted_ = admitted_ = asked_ = Wrench{};
}

/// Share of the greatest force that state, doubt and heat allow.
double Spidar::allowedShare() const noexcept {
  if (!presents() || endsAtOnce()) return 0;
  const bool doubtful = state_ == DeviceState::kReduced || health_.contradicted();
  return heat_share_ * (doubtful ? std::min(1.0, settings_.reduced_force / max_force_) : 1);
}

/// The gain goes to what is allowed: up by a ramp, down by the release rate.
void Spidar::moveGain(double h) noexcept {
  const double allowed = allowedShare();
  if (heat_share_ < 1) flags_ |= kMotorHot;
  if (gain_ < allowed) {
    gain_ = rise_s_ > 0 ? std::min(allowed, gain_ + h / rise_s_) : allowed;
  } else {
    gain_ = std::max(allowed, gain_ - h * settings_.release_rate / max_force_);
  }
  if (gain_ < 1) flags_ |= kFaded;
}

Wrench Spidar::admit(const Wrench& F_G_B, const ForceSlew& slew, const Twist& moved, double h, double command_age) noexcept {
  Wrench asked = F_G_B;
  if (!asked.allFinite()) {
    flags_ |= kCommandNotFinite;
    asked = Wrench{};
  }
  if (def_.dof == 3 && asked.torque.squaredNorm() > 0) {
    flags_ |= kTorqueIgnored;
    asked.torque.setZero();
  }
  if (asked.force.norm() > max_force_) flags_ |= kForceClamped;
  if (asked.torque.norm() > max_torque_) flags_ |= kTorqueClamped;
  asked = withinLimits(asked);
  bool silent = false;
  if (!(command_age <= settings_.command_age_limit_s)) {
    flags_ |= kCommandStale;
    const double late = (command_age - settings_.command_age_limit_s) / settings_.command_decay_s;
    silent = !(late < 1);
    asked = asked * (silent ? 0 : 1 - late);
  }
  if (endsAtOnce()) {
    endAtOnce();
    flags_ |= kFaded | (heat_share_ < 1 ? kMotorHot : 0u);
    return {};
  }
  moveGain(h);
  if (silent) beginAnew(settings_.enable_ramp_s);
  const Wrench wanted = asked * gain_;
  const double share = allowedShare(), allowed_force = share * max_force_, allowed_torque = share * max_torque_;
  // From beyond what is allowed (a limit that was lowered, a doubt, a release) straight to what is wanted, however that turns.
  Wrench before = wanted_;
  if (asked_.force.norm() > allowed_force) before.force = wanted.force;
  if (asked_.torque.norm() > allowed_torque) before.torque = wanted.torque;
  admitted_ = slew.led(wanted, before, asked_, moved, h);
  clampNorm(admitted_.force, std::max(allowed_force, asked_.force.norm()));
  clampNorm(admitted_.torque, std::max(allowed_torque, asked_.torque.norm()));
  if (admitted_.force != wanted.force || admitted_.torque != wanted.torque) flags_ |= kSlewLimited;
  wanted_ = wanted;
  return admitted_;
}

void Spidar::actuate(const Wrench& F_G_B, double grasp_force, double h, double command_age) noexcept {
  const ForceSlew own{stable_stiffness_, settings_.torque_slew / settings_.force_slew, settings_.force_slew};
  present(admit(F_G_B, own, twist_, h, command_age), grasp_force, h);
}

void Spidar::present(const Wrench& F_G_B, double grasp_force, double h) noexcept {
  // What comes behind the law, a damper, adds nothing beyond what is allowed.
  const double share = allowedShare();
  asked_ = F_G_B;
  clampNorm(asked_.force, std::max(share * max_force_, admitted_.force.norm()));
  clampNorm(asked_.torque, std::max(share * max_torque_, admitted_.torque.norm()));
  if (def_.dof == 7) {
    const double wanted = std::isfinite(grasp_force) ? gain_ * std::clamp(grasp_force, -max_force_, max_force_) : 0;
    const double step = settings_.force_slew * h;
    grasp_ = endsAtOnce() ? 0 : std::clamp(wanted, grasp_ - step, grasp_ + step);
  }
  if (calibrated_) distribution_.setStructure(kinematics_.scaledStructure(solution_.pose));
  const TensionReport& report = distribution_.present(asked_, grasp_);
  achieved_ = report.F_G_B;
  const double size = elementary::hypot(asked_.force.norm(), asked_.torque.norm() / kinematics_.knotRadius());
  if (presents() && report.error > kPresentableShare * size + 0.1) flags_ |= kNotPresentable;
  if (report.at_max) flags_ |= kTensionAtMax;
  heat_share_ = health_.heat(report.tension, h);
  writeDrive(stopped_ || (paused_ && clock_.lostNow()) || (state_ == DeviceState::kFault && (zero_current_ || !restsSafely())), h);
}

/// In a fault: least tensions that leave the hand alone. They do so only at a pose that is known.
bool Spidar::restsSafely() const noexcept {
  const Wrench& F = distribution_.report().F_G_B;
  return poseValid() && F.force.norm() <= kRestForce && F.torque.norm() <= kRestForce * kinematics_.knotRadius();
}

void Spidar::writeDrive(bool zero_current, double h) noexcept {
  const StringVector& tension = distribution_.report().tension;
  drive_ = DriveCommand{};
  zero_drives_ = zero_current ? zero_drives_ + 1 : 0;
  if (zero_current) told_.setZero();
  for (int i = 0; i < kinematics_.strings() && !zero_current; ++i) {
    const StringDef& s = def_.strings[i];
    // Without a pose no tension but the least makes sense; with one, balanced tensions do not push the grip.
    const double wanted = calibrated_ ? tension[i] : s.min_tension;
    const double most = std::min(s.max_tension, std::max(told_[i], s.min_tension) + settings_.tension_slew * h);
    if (wanted > most && most < s.max_tension) flags_ |= kSlewLimited;
    told_[i] = std::min(std::max(wanted, s.min_tension), most);
    drive_.voltage[i] = told_[i] * s.volt_per_newton;
  }
}

}  // namespace haptic
