/// A block on a platform that a hand leads up and down: the scene, and its motion by other means.
///
/// The block is a mass on a spring k A d (1 + c ḋ) that only presses, on a platform z = a sin ωt: one equation, integrated here by
/// Runge's and Kutta's method of fourth order at a thousandth of the step. Its mean force over a step follows from the speeds at the ends.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "blocks.h"

namespace haptic::scenes {

struct Shaken {
  static constexpr double kStep = 1e-3;                                      ///< [s]
  static constexpr double kSide = 0.1, kMass = 1;                            ///< of the block [m], [kg]
  static constexpr double kDissipation = DefaultMaterial::kDissipation;      ///< [s/m]
  double k = 0, frequency = 0, share = 0;  ///< stiffness [N/m³], of the platform [Hz], its largest acceleration over g

  double omega() const { return 2 * M_PI * frequency; }
  double amplitude() const { return share * kGravity / (omega() * omega()); }   ///< [m]
  double place(double t) const { return amplitude() * elementary::sin(omega() * t); }  ///< of the platform's upper face [m]
  double speed(double t) const { return amplitude() * omega() * elementary::cos(omega() * t); }
  double depthAtRest() const { return kMass * kGravity / (k * kSide * kSide); }

  /// Means over the steps of the block's normal force, and at their ends [N].
  struct Forces {
    std::vector<double> mean, end;
  };
  Forces exact(int steps) const {
    constexpr int kFine = 1000;
    const auto force = [&](double t, double z, double v) {
      const double d = place(t) - z, rate = speed(t) - v;
      return k * kSide * kSide * std::max(0.0, d) * std::max(0.0, 1 + kDissipation * rate);
    };
    const auto acceleration = [&](double t, double z, double v) { return force(t, z, v) / kMass - kGravity; };
    Forces found;
    double z = -depthAtRest(), v = speed(0);
    const double h = kStep / kFine;
    for (int i = 0; i < steps; ++i) {
      const double v_start = v;
      for (int j = 0; j < kFine; ++j) {
        const double t = (static_cast<double>(i) * kFine + j) * h;
        const double a1 = acceleration(t, z, v), v2 = v + h / 2 * a1;
        const double a2 = acceleration(t + h / 2, z + h / 2 * v, v2), v3 = v + h / 2 * a2;
        const double a3 = acceleration(t + h / 2, z + h / 2 * v2, v3), v4 = v + h * a3;
        const double a4 = acceleration(t + h, z + h * v3, v4);
        z += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
        v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
      }
      found.mean.push_back(kMass * (kGravity + (v - v_start) / kStep));
      found.end.push_back(force((i + 1) * kStep, z, v));
    }
    return found;
  }

  /// Link 0 is the platform, which the only pointer holds, link 1 the block.
  WorldDef scene(const WorldSettings& settings) const {
    WorldDef def;
    def.settings = settings;
    def.settings.step = kStep;
    def.settings.default_material.stiffness = k;
    def.settings.default_material.dissipation = kDissipation;
    const Twist V{Vector3::Zero(), Vector3(0, 0, speed(0))};
    def.articulations.push_back(freeBox("platform", Vector3(0.4, 0.4, 0.1), 1, Pose(Vector3(0, 0, -0.05)), V));
    def.articulations.push_back(freeBox("block", Vector3::Constant(kSide), kMass, Pose(Vector3(0, 0, kSide / 2 - depthAtRest())), V));
    PointerDef hand;
    hand.articulation = 0;
    hand.link = 0;
    def.pointers.push_back(hand);
    return def;
  }
  /// Makes step `i`, from 0; returns the normal force that the world reports [N].
  double step(int i, World& world) const {
    const double t = (i + 1) * kStep;
    world.setPointerTarget(0, Pose(Vector3(0, 0, -0.05 + place(t))), {Vector3::Zero(), Vector3(0, 0, speed(t))});
    world.step();
    double N = 0;
    for (int c = 0; c < world.contactCount(); ++c) N += world.contact(c).normal_force;
    return N;
  }
  /// Error of a step's force, relative.
  static double errorOf(double is, double should) { return std::abs(is - should) / std::max(should, 0.1 * kMass * kGravity); }
};

}  // namespace haptic::scenes
