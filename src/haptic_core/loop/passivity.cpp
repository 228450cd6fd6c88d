#include "haptic_core/loop/passivity.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kSolidSphere = 0.4;  ///< moment of inertia over m r²

}  // namespace

void PassivityController::observe(const StringVector& stretch) noexcept {
  if (settings_.mode == PassivityMode::kOff) return;
  if (in_strings_.tension.size() == stretch.size()) energy_ += in_strings_.tension.dot(stretch);
  before_ = in_strings_;
  in_strings_ = next_;
  lowest_ = std::min(lowest_, energy_);
}

void PassivityController::hold(const Wrench& F_achieved_B, const StringVector& tension) noexcept {
  next_.F_B = F_achieved_B;
  next_.tension = tension;
}

Twist PassivityController::response(const Wrench& F_B, double dt) const noexcept {
  const double inertia = kSolidSphere * grip_mass_ * settings_.radius * settings_.radius;
  return {dt / inertia * F_B.torque, dt / grip_mass_ * F_B.force};
}

Wrench PassivityController::act(const Wrench& F_B, const Twist& V_BG, double h) noexcept {
  acting_ = false;
  if (settings_.mode != PassivityMode::kAct) return F_B;
  const auto push = [&](const Wrench& F) { return 0.5 * h * power(F, response(F, h)); };
  // The velocity now, and when F_B will begin to act.
  const Twist V_now = V_BG + response(before_.F_B, 0.5 * h), V = V_now + response(in_strings_.F_B, h);
  const double left = energy_ - power(in_strings_.F_B, V_now) * h - push(in_strings_.F_B);
  const double deficit = power(F_B, V) * h + push(F_B) - left;
  if (deficit <= 0) return F_B;
  acting_ = true;
  const double r2 = kSolidSphere * settings_.radius * settings_.radius;
  const double speed2 = r2 * V.angular.squaredNorm() + V.linear.squaredNorm();
  // α h speed2 = deficit; compared as products so that a grip at rest divides by nothing.
  const double alpha =
      deficit < settings_.max_damping * h * speed2 ? deficit / (h * speed2) : settings_.max_damping;
  Wrench F{F_B.torque - alpha * r2 * V.angular, F_B.force - alpha * V.linear};
  // The largest share s with s p + s² q ≤ left, or, where there is none, the one that gives least.
  const double p = power(F, V) * h, q = push(F);
  if (p + q > left && q > 0) {
    const double root2 = p * p + 4 * q * left;
    F = F * std::clamp((root2 >= 0 ? -p + std::sqrt(root2) : -p) / (2 * q), 0.0, 1.0);
  }
  dissipated_ += (power(F_B, V) - power(F, V)) * h;
  return F;
}

}  // namespace haptic
