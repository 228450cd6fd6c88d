/// The limit of rigid bodies by the implicit second-order step: tilted cube, top, stick-slip.
#include <cmath>
#include <cstdio>

#include "../scenes/motions.h"
#include "extreme_figures.h"
#include "figure.h"
#include "haptic_core/world/world.h"

namespace haptic::bench {
namespace {

using namespace scenes;

struct Tilt {
  double time_ms = 0, omega_pct = 0, housner = std::nan(""), rest_s = 0, residual = 0;
};

/// The 2 m cube of 1 kg that falls onto its face from 0.1 rad, against the rigid solution (physics.md, section 3).
Tilt tilt(double k, double h, Attempts attempts, double dissipation) {
  constexpr double kTime = 0.2318494, kOmega = 0.7898892;  // at θ = 0.01 rad; ∫dθ/ω of the pendulum on its edge
  CubeParameters c;
  c.size = 2;
  c.mass = 1;
  c.stiffness = k;
  c.tangential = 1;
  c.mu_static = c.mu_dynamic = 10;
  WorldDef def = cubeOnFloor(c, implicitSettings(h, attempts));
  def.settings.default_material.dissipation = dissipation;
  const Matrix3 R = Eigen::AngleAxisd(0.1, Vector3::UnitY()).toRotationMatrix();
  const double corner = std::sqrt(2.0) * std::cos(M_PI / 4 - 0.1);
  def.articulations[1].X_WA = Pose(R, Vector3(0, 0, corner - std::sqrt(0.97 / k)));
  World world(def);
  Tilt result;
  double angle_before = 0.1, omega_before = 0, peak = 0, squares = 0;
  int samples = 0;
  bool measured = false, struck = false;
  for (int i = 1; i * h <= 2 + 1e-12; ++i) {
    stepOnce(world);
    const double angle = std::atan2(-world.linkPose(1).R(2, 0), world.linkPose(1).R(0, 0));
    const double omega = -world.linkTwist(1).angular.y();
    if (!measured && angle < 0.01) {
      measured = true;
      // The root of the cubic through both ends' angles and speeds: its error is h⁴.
      double lo = 0, hi = 1;
      const auto at = [&](double s) {
        const double s2 = s * s, s3 = s2 * s;
        return (2 * s3 - 3 * s2 + 1) * angle_before - (s3 - 2 * s2 + s) * h * omega_before +
               (-2 * s3 + 3 * s2) * angle - (s3 - s2) * h * omega;
      };
      for (int k2 = 0; k2 < 60; ++k2) (at((lo + hi) / 2) > 0.01 ? lo : hi) = (lo + hi) / 2;
      result.time_ms = 1e3 * ((i - 1 + lo) * h - kTime);
      result.omega_pct = 100 * ((omega_before + lo * (omega - omega_before)) / kOmega - 1);
    }
    // After the first impact: the first step in which ω changes no faster than gravity on one edge makes it
    // (twice 3 g/(4 · 2 m) = 3.7 rad/s²), the blow being over.
    peak = std::max(peak, omega);
    if (!struck && angle < 0 && std::abs(omega - omega_before) < 2 * 3.675 * h) {
      struck = true;
      result.housner = omega / peak;
    }
    if (std::abs(omega) > 0.01) result.rest_s = i * h;
    if (i * h > 1.5) {
      squares += omega * omega;
      ++samples;
    }
    angle_before = angle;
    omega_before = omega;
  }
  result.residual = 2.0 / 3.0 * std::sqrt(squares / samples);  // I = m s²/6
  return result;
}

/// Precession [rad/s] and largest drift of the tilt [rad] of the top over 2 s.
struct TopRun {
  double precession = 0, drift = 0;
};
TopRun spin(double k, double h) {
  World world(Top::scene(implicitSettings(h, Attempts::kSdirk2), k));
  TopRun run;
  double angle = 0, last = Top::azimuth(world.linkPose(1));
  const long steps = std::lround(2 / h);
  for (long i = 0; i < steps; ++i) {
    stepOnce(world);
    const double now = Top::azimuth(world.linkPose(1));
    angle += std::remainder(now - last, 2 * M_PI);
    last = now;
    run.drift = std::max(run.drift, std::abs(Top::tilt(world.linkPose(1)) - Top::kTilt));
  }
  run.precession = angle / 2;
  return run;
}

void top() {
  const TopRun coarse = spin(1e10, 1e-3), fine = spin(1e10, 1e-3 / 8);
  figure("rigid.top_precession_err_pct", 100 * std::abs(coarse.precession / Top::kExact - 1), "%");
  figure("rigid.top_precession_err_pct_numerical", 100 * std::abs(coarse.precession / fine.precession - 1), "%");
  figure("rigid.top_tilt_drift_rad", coarse.drift, "rad");
  // The apex of 1e10 N/m3 sinks by 0.3 mm, and the patch of a cone that leans reaches farther to the low side: the weight's
  // lever is 4.6 % shorter, and a start at the rigid rate nutates. Stiffer ones come closer to the rigid top.
  for (double k : {1e10, 1e13, 1e16}) {
    const TopRun run = spin(k, 1e-3);
    std::printf("top: k %.0e N/m3, total error of the precession %+.4f %%, drift %.2e rad\n", k,
                100 * (run.precession / Top::kExact - 1), run.drift);
    if (k == 1e13) figure("rigid.top_tilt_drift_1e13_rad", run.drift, "rad");
  }
}

/// Mean period over 20 s at a step of 10 ms, between the located instants of release.
void stickSlipPeriod() {
  CubeParameters c;
  c.mass = StickSlip::kMass;
  c.stiffness = StickSlip::kStiffness;
  const double h = 1e-2;
  World world(StickSlip::scene(implicitSettings(h, Attempts::kSdirk2)));
  double first = 0, last = 0;
  int releases = 0;
  bool stuck = true;
  for (int i = 0; i < 2000; ++i) {
    const double start = world.time();
    StickSlip::step(world, c.size / 2 - c.restDepth());
    totals.unconverged += (world.report().flags & kNotConverged) != 0;
    const ContactReport& contact = world.contact(0);
    if (stuck && !contact.sticking) {
      last = start + contact.event * h;
      if (releases++ == 0) first = last;
    }
    stuck = contact.sticking;
  }
  const double period = (last - first) / (releases - 1);
  std::printf("stick-slip at 10 ms: %d releases, period %.6f s, first at %.6f s\n", releases, period, first);
  figure("rigid.stickslip_period_err_pct", 100 * std::abs(period / StickSlip::period() - 1), "%");
}

}  // namespace

void rigidLimits() {
  const Tilt euler10 = tilt(4e4, 1e-2, Attempts::kImplicitEuler, 1);
  const Tilt second10 = tilt(1e10, 1e-2, Attempts::kSdirk2, 1);
  figure("tilt.residual_10ms_nms", std::max(euler10.residual, second10.residual), "N.m.s");
  const Tilt rigid = tilt(1e10, 1e-3, Attempts::kSdirk2, 1);
  figure("rigid.tilt_time_err_ms", std::abs(rigid.time_ms), "ms");
  figure("rigid.tilt_omega_err_pct", std::abs(rigid.omega_pct), "%");
  figure("rigid.housner_ratio", rigid.housner, "1");
  figure("rigid.rest_s", rigid.rest_s, "s");
  top();
  stickSlipPeriod();
}

}  // namespace haptic::bench
