#include "haptic_core/loop/hand.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {

Hand::Hand(Spidar& device, int pointer, const HandSettings& settings)
    : device_(device),
      pointer_(pointer),
      settings_(settings),
      map_(settings.workspace),
      passivity_(settings.passivity) {
  const auto refuse = [&](const char* name, double value, const char* remedy) {
    throw SetupError(device.def().name, std::string(name) + " is " + std::to_string(value), remedy);
  };
  if (!(settings.workspace.scale > 0)) refuse("workspace scale", settings.workspace.scale, "give a number > 0");
  if (!(settings.force_scale >= 0)) refuse("force scale", settings.force_scale, "give a number >= 0");
  if (!(settings.soft_start_s >= 0)) refuse("soft start", settings.soft_start_s, "give a time >= 0 s");
}

void Hand::sense(const DeviceSample& sample, double h) noexcept {
  device_.sense(sample, h);
  const Pose previous = report_.X_BG;
  report_.valid = device_.calibrated();
  report_.X_BG = device_.pose();
  report_.V_BG = device_.twist();
  report_.opening = device_.opening();
  report_.length = device_.lengths();
  report_.pose_residual = device_.solution().residual;
  if (report_.valid && was_valid_) {
    passivity_.observe(vectorFromRotation(Quaternion(report_.X_BG.R * previous.R.transpose())),
                       report_.X_BG.p - previous.p);
  }
  was_valid_ = report_.valid;
}

void Hand::couple(World& world) noexcept {
  const bool held = clutch_requested_.load(std::memory_order_relaxed);
  if (report_.valid) map_.update(report_.X_BG, report_.V_BG, held && (map_.clutched() || !in_contact_));
  report_.X_WP = map_.X_WP();
  if (report_.valid) world.setPointerTarget(pointer_, map_.X_WP(), map_.V_WP());
}

void Hand::render(const World& world, double h) noexcept {
  const Wrench F_W = world.pointerWrench(pointer_);
  in_contact_ = F_W.force.squaredNorm() + F_W.torque.squaredNorm() > 0;
  if (soft_start_requested_.exchange(false, std::memory_order_relaxed) || !report_.valid) report_.fade = 0;
  report_.F_asked_B = passivity_.act(map_.toGrip(F_W) * (settings_.force_scale * report_.fade), report_.V_BG, h);
  device_.actuate(report_.F_asked_B, 0.0, h);
  passivity_.hold(device_.achievedWrench());
  report_.F_achieved_B = device_.achievedWrench();
  report_.tension = device_.tension().tension;
  report_.port_energy = passivity_.energy();
  report_.device_flags = device_.flags();
  report_.fade = std::min(1.0, report_.fade + (settings_.soft_start_s > 0 ? h / settings_.soft_start_s : 1.0));
}

const DriveCommand& Hand::drive() const noexcept {
  return device_.drive();
}

}  // namespace haptic
