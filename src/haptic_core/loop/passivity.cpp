#include "haptic_core/loop/passivity.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kSolidSphere = 0.4;  ///< moment of inertia over m r²

/// The energy held back, per count's length [N]. A pull of 1 N over one count: more reserve takes force from the first
/// touch for longer, half of it let 1 hand of 4000 give two samples' energy (bench loop).
constexpr double kReservedPull = 1;

}  // namespace

void PassivityController::start(const StringVector& length) noexcept {
  counted_ = smooth_ = length;
  advance_ = StringVector::Zero(length.size());
}

void PassivityController::observe(const StringVector& length) noexcept {
  if (settings_.mode == PassivityMode::kOff) return start(length);
  const StringVector smooth_before = smooth_;
  for (int i = 0; i < length.size(); ++i) {
    smooth_[i] = std::clamp(smooth_[i] + advance_[i], length[i] - 0.5 * quantum_[i], length[i] + 0.5 * quantum_[i]);
  }
  advance_ = smooth_ - smooth_before;
  counted_energy_ += in_strings_.tension.dot(length - counted_);
  smooth_energy_ += in_strings_.tension.dot(advance_);
  counted_ = length;
  energy_ = std::min(counted_energy_, smooth_energy_);
  before_ = in_strings_;
  in_strings_ = next_;
  lowest_ = std::min(lowest_, energy_);
}

double PassivityController::reserve() const noexcept { return quantum_.size() > 0 ? kReservedPull * quantum_.maxCoeff() : 0; }

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
  const double left = energy_ - reserve() - power(in_strings_.F_B, V_now) * h - push(in_strings_.F_B);
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
