/// Exact rigid motions that need an integral: solved by classical Runge–Kutta in long double with steps so small that
/// the result is exact to double precision.
#pragma once
#include <array>
#include <cmath>

#include "haptic_core/base/spatial.h"

namespace haptic::report {

/// Angle and speed of a cube of edge `size` that falls about its edge from `start`, before its face touches (the edge
/// holds): θ̈ = -(3 g / (2√2 size)) cos(π/4 + θ), from I = ⅔ m size² about the edge.
struct FallingCube {
  double angle, speed;  ///< [rad], [rad/s]
  static FallingCube at(double time, double size, double start, double g) {
    constexpr int kSteps = 4096;
    const long double h = static_cast<long double>(time) / kSteps, c = 3.0L * g / (2 * std::sqrt(2.0L) * size);
    const auto pull = [c](long double theta) { return -c * std::cos(M_PIl / 4 + theta); };
    long double x = start, v = 0;
    for (int i = 0; i < kSteps; ++i) {
      const long double k1 = pull(x), k2 = pull(x + h / 2 * v), k3 = pull(x + h / 2 * v + h * h / 4 * k1),
                        k4 = pull(x + h * v + h * h / 2 * k2);
      x += h * v + h * h / 6 * (k1 + k2 + k3);
      v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    return {static_cast<double>(x), static_cast<double>(v)};
  }
};

/// Torque-free rotation: Euler's equations and the quaternion's, from the identity.
struct FreeRotation {
  Matrix3 R_WB;
  Vector3 omega_W;  ///< [rad/s]
  static FreeRotation at(double time, const Vector3& inertia, const Vector3& omega_start) {
    using State = std::array<long double, 7>;  // ω in B, quaternion w x y z
    const long double I[3] = {inertia.x(), inertia.y(), inertia.z()};
    const auto rate = [&I](const State& s) {
      return State{(I[1] - I[2]) / I[0] * s[1] * s[2],
                   (I[2] - I[0]) / I[1] * s[2] * s[0],
                   (I[0] - I[1]) / I[2] * s[0] * s[1],
                   (-s[4] * s[0] - s[5] * s[1] - s[6] * s[2]) / 2,
                   (s[3] * s[0] + s[5] * s[2] - s[6] * s[1]) / 2,
                   (s[3] * s[1] + s[6] * s[0] - s[4] * s[2]) / 2,
                   (s[3] * s[2] + s[4] * s[1] - s[5] * s[0]) / 2};
    };
    const auto sum = [](const State& a, const State& b, long double f) {
      State out;
      for (int i = 0; i < 7; ++i) out[i] = a[i] + f * b[i];
      return out;
    };
    // At 5 rad/s and h = 0.05 ms the error is (ωh)⁴/120 per radian: 2e-15 after the 50 rad of ten seconds.
    const long steps = std::max(1L, std::lround(time * 2e4));
    const long double h = static_cast<long double>(time) / steps;
    State s = {omega_start.x(), omega_start.y(), omega_start.z(), 1, 0, 0, 0};
    for (long i = 0; i < steps; ++i) {
      const State k1 = rate(s), k2 = rate(sum(s, k1, h / 2)), k3 = rate(sum(s, k2, h / 2)), k4 = rate(sum(s, k3, h));
      for (int k = 0; k < 7; ++k) s[k] += h / 6 * (k1[k] + 2 * k2[k] + 2 * k3[k] + k4[k]);
    }
    const Quaternion q(static_cast<double>(s[3]), static_cast<double>(s[4]), static_cast<double>(s[5]),
                       static_cast<double>(s[6]));
    FreeRotation out;
    out.R_WB = q.normalized().toRotationMatrix();
    out.omega_W = out.R_WB * Vector3(static_cast<double>(s[0]), static_cast<double>(s[1]), static_cast<double>(s[2]));
    return out;
  }
};

}  // namespace haptic::report
