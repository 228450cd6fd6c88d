/// A cube that falls flat onto the floor and leaves it again, beside the exact solution of its equation of motion.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "blocks.h"
#include "haptic_core/contact/pressure_law.h"

namespace haptic::scenes {

constexpr double kBounceStep = 1e-3;  ///< [s]
constexpr double kBounceEdge = 0.1;   ///< [m]

/// A cube that falls flat onto the floor.
struct Bounce {
  PressureLaw law;
  double damping;  ///< ζ of the linear law, or c [s/m] of Hunt–Crossley
  double mass;     ///< [kg]
  double k_eff;    ///< k A [N/m]

  double omega() const { return std::sqrt(k_eff / mass); }
  double b() const { return 2 * damping * std::sqrt(k_eff * mass); }  ///< [N·s/m]

  double force(double depth, double rate) const {
    if (depth <= 0) return 0;
    const double elastic = k_eff * depth;
    return std::max(0.0, law == PressureLaw::kLinear ? elastic + b() * rate : elastic * (1 + damping * rate));
  }

  WorldDef make(double height, Attempts attempts = Attempts::kAll, MakeComparator comparator = nullptr) const {
    WorldDef def;
    def.name = "bounce";
    def.settings.step = kBounceStep;
    def.settings.pressure_law = law;
    def.settings.attempts = attempts;
    def.settings.comparator = comparator;
    ContactMaterial& m = def.settings.default_material;
    const double area = kBounceEdge * kBounceEdge;
    m.stiffness = k_eff / area;
    m.damping = b() / area;
    m.dissipation = damping;
    m.mu_static = m.mu_dynamic = 0;
    def.articulations.push_back(floorBox());
    const Pose X_WC(Vector3(0, 0, kBounceEdge / 2 + height));
    def.articulations.push_back(freeBox("cube", Vector3::Constant(kBounceEdge), mass, X_WC));
    return def;
  }

  /// Speed at the height of first touch on the way up, 0 if it stays, and the time in contact; Runge–Kutta at 1/4000 of the
  /// contact's time.
  /// The force of either law may end, held at 0, before the bodies part: from there the flight is free.
  std::array<double, 2> exactExit(double approach) const {
    const double h = M_PI / omega() / 4000;
    double d = 0, v = approach, t = 0;  // depth and its rate
    const auto acceleration = [&](double depth, double rate) { return kGravity - force(depth, rate) / mass; };
    d = 1e-9 * approach * h;
    while (d > 0 && t < 100 / omega()) {
      const double a1 = acceleration(d, v), a2 = acceleration(d + 0.5 * h * v, v + 0.5 * h * a1),
                   a3 = acceleration(d + 0.5 * h * (v + 0.5 * h * a1), v + 0.5 * h * a2),
                   a4 = acceleration(d + h * (v + 0.5 * h * a2), v + h * a3);
      d += h * (v + h / 6 * (a1 + a2 + a3));
      v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
      t += h;
    }
    if (d > 0) return {0, t};  // it stays
    return {std::sqrt(v * v - 2 * kGravity * d), t};  // d < 0 by less than a step
  }
};

/// Speed at the height of first touch after one bounce from `height`; 0: it does not leave.
inline double exitSpeed(const Bounce& bounce, double height, Attempts attempts, MakeComparator comparator) {
  World world(bounce.make(height, attempts, comparator));
  bool touched = false;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    touched |= world.report().contacts > 0;
    const double gap = world.linkPose(1).p.z() - kBounceEdge / 2, v = world.linkTwist(1).linear.z();
    if (touched && gap > 0 && v > 0 && world.report().contacts == 0) return std::sqrt(v * v + 2 * kGravity * gap);
  }
  return 0;
}

/// The largest error over heights that differ by when, within a step, the cube touches.
inline double worstExit(const Bounce& bounce, Attempts attempts = Attempts::kAll, MakeComparator comparator = nullptr) {
  constexpr int kPhases = 16;
  double worst = 0;
  for (int i = 0; i < kPhases; ++i) {
    const double fall = 0.045 + kBounceStep * i / kPhases;  // [s]
    const double height = 0.5 * kGravity * fall * fall, approach = kGravity * fall;
    const double exact = bounce.exactExit(approach)[0], speed = exitSpeed(bounce, height, attempts, comparator);
    worst = std::max(worst, std::abs(speed - exact) / approach);
  }
  return worst;
}

}  // namespace haptic::scenes
