#include "haptic_core/spidar/device_twin.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"

namespace haptic {

DeviceTwin::DeviceTwin(const DeviceDef& def, const TwinSettings& settings)
    : def_(def), settings_(settings), kinematics_(def), home_length_(kinematics_.lengths(GripPose{})) {
  if (!(settings_.period > 0) || settings_.substeps < 1)
    throw SetupError("twin of " + def_.name, "has no positive period or substeps",
                     "set period > 0 s and substeps >= 1");
  tension_ = StringVector::Zero(kinematics_.strings());
  inertia_ = 0.4 * def_.grip_mass * def_.grip_radius * def_.grip_radius;  // of a solid sphere
}

void DeviceTwin::place(const GripPose& pose) noexcept {
  grip_ = pose;
  V_BG_ = Twist{};
  opening_rate_ = 0;
}

void DeviceTwin::latch(DeviceSample& sample) noexcept {
  const StringVector length = kinematics_.lengths(grip_);
  for (int i = 0; i < kinematics_.strings(); ++i)
    sample.counts[i] = settings_.first_count +
                       static_cast<std::int64_t>(
                           std::llround((length[i] - home_length_[i]) / def_.strings[i].length_per_count));
  latched_ = grip_;
}

void DeviceTwin::inject(const TwinFault& fault) noexcept {
  fault_ = fault;
  faulty_ = true;
  fault_time_ = 0;
  fault_count_ = answered_.counts[fault.string];
}

bool DeviceTwin::pulls(int string) const noexcept {
  const bool loose = fault_.kind == TwinFaultKind::kSlack || fault_.kind == TwinFaultKind::kBreak;
  return !(faulty_ && loose && fault_.string == string);
}

void DeviceTwin::latchFault(DeviceSample& sample) noexcept {
  constexpr double kSagTime = 0.05;  // a hand that moves in at 0.1 m/s gains 5 mm in it
  const double step = def_.strings[fault_.string].length_per_count;
  const auto counts = [&](double length) { return static_cast<std::int64_t>(std::llround(length / step)); };
  std::int64_t& count = sample.counts[fault_.string];
  fault_time_ += settings_.period;
  switch (fault_.kind) {
    case TwinFaultKind::kSlack:
      count += counts(fault_.size * std::min(1.0, fault_time_ / kSagTime));
      break;
    case TwinFaultKind::kSlip:
    case TwinFaultKind::kJump:
      count += counts(fault_.size);
      break;
    case TwinFaultKind::kStuck:
      count = fault_count_;
      break;
    case TwinFaultKind::kBreak:
      count = fault_count_ - counts(fault_.size * fault_time_);
      break;
    case TwinFaultKind::kSilence: {
      sample = answered_;
      ++sample.age_ticks;
      sample.age_us += static_cast<std::uint32_t>(1e6 * settings_.period);
      sample.lost = 1;
      sample.status = LinkStatus::kStale;
      break;
    }
  }
}

Wrench DeviceTwin::handForce(double time, double& on_opening) noexcept {
  Wrench F;
  on_opening = 0;
  if (!settings_.hand) return F;
  const GripPose goal = taken_target_.active ? taken_target_.pose : settings_.path.at(time - path_start_);
  F.force = settings_.hand_stiffness * (goal.X_BG.p - grip_.X_BG.p) - settings_.hand_damping * V_BG_.linear;
  const Vector3 angle = vectorFromRotation(Quaternion(goal.X_BG.R * grip_.X_BG.R.transpose()));
  F.torque = settings_.hand_rotational_stiffness * angle - settings_.hand_rotational_damping * V_BG_.angular;
  on_opening =
      settings_.hand_stiffness * (goal.opening - grip_.opening) - settings_.hand_damping * opening_rate_;
  return F;
}

void DeviceTwin::substep(double h) noexcept {
  const StructureMatrix A = kinematics_.structure(grip_);
  for (int i = 0; i < kinematics_.strings(); ++i) {
    // A motor can only pull: a voltage of the wrong sign leaves the string slack.
    const double wanted =
        pulls(i) ? std::max(0.0, command_.voltage[i] / def_.strings[i].volt_per_newton) : 0.0;
    const double lag = settings_.motor_time_constant;
    tension_[i] = lag > 0 ? tension_[i] + (wanted - tension_[i]) * (1 - elementary::exp(-h / lag)) : wanted;
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDof, 1> f = A.transpose() * tension_;
  Wrench strings;
  strings.force = f.head<3>();
  if (def_.dof >= 6) strings.torque = f.segment<3>(3);
  double hand_on_opening = 0;
  const Wrench hand = handForce(time_, hand_on_opening);
  Wrench total = strings + hand;
  total.force -= def_.grip_damping * V_BG_.linear;
  total.force.z() -= def_.grip_mass * settings_.gravity;

  V_BG_.linear += total.force * (h / def_.grip_mass);
  grip_.X_BG.p += h * V_BG_.linear;
  if (def_.dof >= 6) {
    V_BG_.angular += total.torque * (h / inertia_);
    const Quaternion q = rotationFromVector(h * V_BG_.angular) * Quaternion(grip_.X_BG.R);
    grip_.X_BG.R = q.normalized().toRotationMatrix();
  }
  if (def_.dof == 7) {
    // Two half grips moving apart by the opening: reduced mass m/4.
    opening_rate_ += (f[6] + hand_on_opening) * (h / (0.25 * def_.grip_mass));
    grip_.opening += h * opening_rate_;
  }
  const double share = 1.0 / settings_.substeps;
  string_wrench_ += strings * share;
  hand_wrench_ += hand * share;
  time_ += h;
}

DeviceSample DeviceTwin::exchange(const DriveCommand& command) noexcept {
  target_.read(taken_target_);
  DeviceSample sample;
  time_ = static_cast<double>(ticks_) * settings_.period;
  latch(sample);
  if (faulty_) latchFault(sample);
  answered_ = sample;
  command_ = command;
  string_wrench_ = hand_wrench_ = Wrench{};
  for (int i = 0; i < settings_.substeps; ++i) substep(settings_.period / settings_.substeps);
  ++ticks_;
  return sample;
}

}  // namespace haptic
