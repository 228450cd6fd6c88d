/// Links in a row, hinged about y, in the x–z plane: Lagrange's equations in the links' absolute angles, apart from the algorithms of any
/// simulator, by classical Runge–Kutta in long double.
#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <utility>
#include <vector>

namespace haptic::report {

/// A link along its x axis from hinge to hinge; its joint pulls with stiffness (target − q) − damping q̇ [N·m].
struct PlanarLink {
  double length = 0, mass = 0, centre = 0;     ///< [m], [kg], of its centre of mass from its hinge [m]
  double inertia = 0;                          ///< about y at the centre of mass [kg·m²]
  double stiffness = 0, target = 0, damping = 0;  ///< of its drive
  double start = 0;                            ///< q at time 0, at rest [rad]
};

/// Angle q of a joint about y, from the link before it (the first: from the world's x axis, down is positive).
class PlanarChain {
 public:
  static constexpr int kMost = 8;  ///< links
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1, 0, kMost, 1>;
  PlanarChain(std::vector<PlanarLink> links, double g) : links_(std::move(links)), g_(g) {}

  /// Absolute angles [rad] and their rates at a time [s].
  struct Motion {
    Vector angle, rate;
  };
  /// Goes on from the time before where it can.
  const Motion& at(double time) {
    constexpr double kSteps = 4e4;  // per second: at 100 rad/s the error per radian is (ω h)⁴/120 = 3e-13; 2e4 lose 7e-12 J
    if (time < time_ || time_ == 0) now_ = start(), time_ = 0;
    const long steps = std::lround(std::ceil((time - time_) * kSteps));
    const long double h = steps > 0 ? (static_cast<long double>(time) - time_) / steps : 0;
    for (long i = 0; i < steps; ++i) {
      const Motion k1 = rates(now_), k2 = rates(sum(now_, k1, h / 2)), k3 = rates(sum(now_, k2, h / 2)), k4 = rates(sum(now_, k3, h));
      now_.angle += h / 6 * (k1.angle + 2 * k2.angle + 2 * k3.angle + k4.angle);
      now_.rate += h / 6 * (k1.rate + 2 * k2.rate + 2 * k3.rate + k4.rate);
    }
    time_ = time;
    return now_;
  }

 private:
  Motion start() const {
    Motion m{Vector(links_.size()), Vector::Zero(links_.size())};
    long double angle = 0;
    for (std::size_t i = 0; i < links_.size(); ++i) m.angle[i] = angle += links_[i].start;
    return m;
  }
  static Motion sum(const Motion& a, const Motion& b, long double f) { return {a.angle + f * b.angle, a.rate + f * b.rate}; }

  /// Moment of all that hangs on link i about its hinge, per cosine of its angle [kg·m].
  long double lever(std::size_t i) const {
    long double beyond = 0;
    for (std::size_t k = i + 1; k < links_.size(); ++k) beyond += links_[k].mass;
    return links_[i].mass * static_cast<long double>(links_[i].centre) + links_[i].length * beyond;
  }

  Motion rates(const Motion& m) const {
    const std::size_t n = links_.size();
    Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost> M(n, n);
    Vector force(n), torque(n);
    for (std::size_t i = 0; i < n; ++i) {
      const PlanarLink& a = links_[i];
      const long double q = m.angle[i] - (i ? m.angle[i - 1] : 0), v = m.rate[i] - (i ? m.rate[i - 1] : 0);
      torque[i] = a.stiffness * (a.target - q) - a.damping * v;
      long double beyond = 0;
      for (std::size_t k = i + 1; k < n; ++k) beyond += links_[k].mass;
      M(i, i) = a.inertia + a.mass * static_cast<long double>(a.centre) * a.centre + a.length * static_cast<long double>(a.length) * beyond;
      force[i] = g_ * lever(i) * std::cos(m.angle[i]);
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        const long double share = links_[i].length * lever(j), turn = m.angle[i] - m.angle[j];
        M(i, j) = M(j, i) = share * std::cos(turn);
        force[i] -= share * std::sin(turn) * m.rate[j] * m.rate[j];
        force[j] += share * std::sin(turn) * m.rate[i] * m.rate[i];
      }
      force[i] += torque[i] - (i + 1 < n ? torque[i + 1] : 0);
    }
    return {m.rate, M.ldlt().solve(force)};
  }

  std::vector<PlanarLink> links_;
  long double g_;
  double time_ = 0;
  Motion now_;
};

}  // namespace haptic::report
