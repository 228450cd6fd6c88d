#include "haptic_core/loop/passivity.h"

#include <algorithm>

namespace haptic {

void PassivityController::observe(const Vector3& rotation, const Vector3& translation) noexcept {
  if (settings_.mode == PassivityMode::kOff) return;
  energy_ -= held_.torque.dot(rotation) + held_.force.dot(translation);
  lowest_ = std::min(lowest_, energy_);
}

Wrench PassivityController::act(const Wrench& F_B, const Twist& V_BG, double h) noexcept {
  acting_ = false;
  if (settings_.mode != PassivityMode::kAct) return F_B;
  const double deficit = power(F_B, V_BG) * h - energy_;  // E after the tick is -deficit
  const double r2 = settings_.radius * settings_.radius;
  const double speed2 = r2 * V_BG.angular.squaredNorm() + V_BG.linear.squaredNorm();
  if (deficit <= 0 || speed2 <= 0) return F_B;
  // α h speed2 = deficit; compared as products so that a grip at rest divides by nothing.
  const double alpha =
      deficit < settings_.max_damping * h * speed2 ? deficit / (h * speed2) : settings_.max_damping;
  acting_ = true;
  dissipated_ += alpha * speed2 * h;
  return {F_B.torque - alpha * r2 * V_BG.angular, F_B.force - alpha * V_BG.linear};
}

void PassivityController::reset() noexcept {
  held_ = Wrench{};
  energy_ = lowest_ = dissipated_ = 0;
  acting_ = false;
}

}  // namespace haptic
