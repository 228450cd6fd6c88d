#include <cmath>
#include <cstdio>
#include <functional>

#include "../comparators/velocity_verlet.h"
#include "../core/dynamics/free_rotation_reference.h"
#include "../scenes/motions.h"
#include "dynamics_figures.h"
#include "figure.h"

namespace haptic::bench {
namespace {

using namespace scenes;

WorldSettings verlet(double h) {
  WorldSettings s;
  s.step = h;
  s.comparator = comparators::velocityVerlet;
  return s;
}

/// Least-squares slope of log(error) over log(h).
double order(const std::vector<double>& h, const std::vector<double>& error) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const double n = static_cast<double>(h.size());
  for (std::size_t i = 0; i < h.size(); ++i) {
    const double x = std::log(h[i]), y = std::log(error[i]);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Height and speed at time `end` of a cube that falls flat from 2 mm and bounces once or more.
Vector2 bounce(double h, double end) {
  CubeParameters c;
  c.ratio = 0.1;
  WorldDef def = cubeOnFloor(c, verlet(h), 2e-3);
  def.settings.default_material.dissipation = 1;  // 1 + c ḋ stays positive at these speeds
  World world(def);
  const long steps = std::lround(end / h);
  for (long i = 0; i < steps; ++i) world.step();
  return {world.linkPose(1).p.z(), world.linkTwist(1).linear.z()};
}

/// Largest gain of energy (figures.md, energy.gain_rel) over the largest energy exchanged: a cube that falls flat on the
/// floor and comes to rest. `turning`, which would close the balance by what it is, is left out: n does not turn here.
/// Worst of several heights, so that the touch falls on different shares of a step.
double energyStepError(double h) {
  double worst = 0;
  for (const double height : {2.0e-3, 2.1e-3, 2.2e-3, 2.3e-3, 2.4e-3}) {
    World world(cubeOnFloor(CubeParameters{}, verlet(h), height));
    double error = 0, exchanged = 0, start = 0;
    for (long i = 0; i < std::lround(0.5 / h); ++i) {
      world.step();
      const EnergyLedger& e = world.report().energy;
      const double balance = e.balance() - e.turning;
      if (i == 0) start = balance;
      error = std::max(error, balance - start);
      exchanged = std::max({exchanged, e.kinetic, e.elastic});
    }
    worst = std::max(worst, error / exchanged);
  }
  return worst;
}

double energyTurningGain(double h) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, verlet(h), 0.05);
  def.settings.default_material.dissipation = 0.1;
  def.articulations[1].X_WA.R = Eigen::AngleAxisd(0.9, Vector3(1, 0.4, 0.2).normalized()).toRotationMatrix();
  World world(def);
  double worst = 0, scale = 0;
  for (long i = 0; i < std::lround(1 / h); ++i) {
    world.step();
    const EnergyLedger& e = world.report().energy;
    worst = std::max(worst, -e.turning);
    scale = std::max(scale, e.kinetic);
  }
  return worst / scale;
}

/// Energy that a cube at rest gains [J], and the largest energy exchanged since it was dropped from 10 µm [J].
struct RestGain {
  double gained = 0, exchanged = 0, weight = 0;
};
RestGain energyRestGain() {
  CubeParameters c;
  World world(cubeOnFloor(c, verlet(1e-3), 1e-5));
  RestGain out;
  out.weight = c.mass * kGravity * c.size;
  EnergyLedger first;
  const auto step = [&](int i) {
    world.step();
    const EnergyLedger& e = world.report().energy;
    if (i == 0) first = e;
    out.exchanged = std::max({out.exchanged, std::abs(e.kinetic - first.kinetic), std::abs(e.potential - first.potential),
                              std::abs(e.elastic - first.elastic), std::abs(e.tangential - first.tangential), e.damping + e.friction});
    return e.total();
  };
  double start = 0;
  for (int i = 0; i < 3000; ++i) start = step(i);
  for (int i = 0; i < 10000; ++i) out.gained = std::max(out.gained, step(i + 1) - start);
  return out;
}

struct Fall {
  double time = std::nan(""), omega = std::nan(""), residual = 0;
};

/// The tilted cube until 2 s: when it passes 0.01 rad and how fast, and rms of its angular momentum from 1.5 s.
Fall fall(double h, double k, MakeComparator comparator = comparators::velocityVerlet) {
  WorldSettings settings = verlet(h);
  settings.comparator = comparator;
  World world(scenes::tiltedCube(settings, k));
  Fall out;
  double angle = 0.1, omega = 0, squares = 0;
  long counted = 0;
  const double inertia = 1.0 / 6 * 4;
  for (long i = 0; i < std::lround(2 / h); ++i) {
    world.step();
    const double next = tiltOf(world.linkPose(1)), next_omega = -world.linkTwist(1).angular.y();
    if (std::isnan(out.time) && next < 0.01) {
      const EdgeState before{angle, omega}, after{next, next_omega};
      const double share = passage(before, after, 0.01, h), e = 1e-4;
      out.time = world.time() - h + share * h;
      out.omega = std::abs((between(before, after, share + e, h) - between(before, after, share - e, h)) / (2 * e * h));
    }
    if (world.time() > 1.5) {
      squares += std::pow(inertia * world.linkTwist(1).angular.norm(), 2);
      ++counted;
    }
    angle = next;
    omega = next_omega;
  }
  out.residual = std::sqrt(squares / static_cast<double>(counted));
  return out;
}

struct TopRun {
  double precession = 0, tilt_drift = 0;
};

TopRun spin(double h, double k, double mu) {
  World world(Top::scene(verlet(h), k, mu));
  double turned = 0, before = Top::azimuth(world.linkPose(1));
  double lowest = 1, highest = 0;
  const long steps = std::lround(2 / h);
  for (long i = 0; i < steps; ++i) {
    world.step();
    const double now = Top::azimuth(world.linkPose(1));
    turned += std::remainder(now - before, 2 * M_PI);
    before = now;
    const double tilt = Top::tilt(world.linkPose(1));
    lowest = std::min(lowest, tilt);
    highest = std::max(highest, tilt);
  }
  return {turned / 2, std::max(highest - Top::kTilt, Top::kTilt - lowest)};
}

}  // namespace

void restAndBounce() {
  CubeParameters c;
  World world(cubeOnFloor(c, verlet(1e-3), 1e-5));
  for (int i = 0; i < 3000; ++i) world.step();
  const double depth = c.size / 2 - world.linkPose(1).p.z();
  figure("rest.depth_rel_err", std::abs(depth / c.restDepth() - 1), "1");

  std::vector<double> steps, errors;
  const double end = 0.2;
  const Vector2 reference = bounce(end / 400000, end);
  for (int n : {100, 126, 160, 200, 250, 320, 400, 500, 640, 800, 1000}) {
    steps.push_back(end / n);
    errors.push_back((bounce(end / n, end) - reference).norm());
    std::printf("bounce h %.4g ms error %.3g\n", 1e3 * steps.back(), errors.back());
  }
  figure("bounce.order", order(steps, errors), "1");
  const double whole = energyStepError(1e-3), half = energyStepError(5e-4);
  figure("energy.step_rel", whole, "1");
  figure("energy.step_ratio_on_halving", whole / half, "1");
  figure("energy.turning_rel", energyTurningGain(1e-3), "1");
  const RestGain rest = energyRestGain();
  figure("energy.rest_rel", rest.gained / rest.exchanged, "1");
  figure("energy.rest_of_weight_rel", rest.gained / rest.weight, "1");  // over m g L
}

void tiltedCube() {
  constexpr double kExactTime = 0.2318494, kExactOmega = 0.7898892, k = 4e4;
  const Fall converged = fall(1.0 / 64000, k), finer = fall(1.0 / 128000, k), coarse = fall(1e-3, k);
  std::printf("tilt: converged t %.9f s (change on halving %.1e), omega %.9f\n", converged.time,
              finer.time - converged.time, converged.omega);
  figure("tilt.time_err_ms", 1e3 * std::abs(coarse.time - finer.time), "ms");
  figure("tilt.omega_err_pct", 100 * std::abs(coarse.omega / finer.omega - 1), "%");
  figure("tilt.model_time_err_ms", 1e3 * (finer.time - kExactTime), "ms");
  figure("tilt.model_omega_err_pct", 100 * (finer.omega / kExactOmega - 1), "%");
  figure("tilt.residual_nms", coarse.residual, "N m s");
  figure("tilt.point_residual_nms", fall(1e-3, k, comparators::pointVerlet).residual, "N m s");
  for (const double h : {1e-4, 3e-4, 1e-3, 10e-3 / 3, 1e-2}) {
    const Fall f = fall(h, k);
    std::printf("tilt: h %.4g ms time error %.3g ms, omega error %.3g %%, residual %.3g N m s\n", 1e3 * h,
                1e3 * (f.time - finer.time), 100 * (f.omega / finer.omega - 1), f.residual);
  }
  for (double stiff : {1e5, 1e6, 1e7}) {
    const Fall f = fall(1e-3 * std::sqrt(4e4 / stiff) / 8, stiff);
    std::printf("tilt: k %.0e time error of the model %.5f ms, omega %.5f %%\n", stiff, 1e3 * (f.time - kExactTime),
                100 * (f.omega / kExactOmega - 1));
  }
}

void spinningTop() {
  constexpr double k = 1e13;
  const TopRun coarse = spin(1e-3, k, 10), fine = spin(1e-3 / 16, k, 10);
  figure("top.precession_err_pct", 100 * std::abs(coarse.precession / fine.precession - 1), "%");
  figure("top.tilt_drift_rad", coarse.tilt_drift, "rad");
  figure("top.model_precession_err_pct", 100 * (fine.precession / Top::kExact - 1), "%");
  const TopRun sliding = spin(1e-3, k, 0);
  figure("top.sliding_precession_err_pct", 100 * (sliding.precession / Top::kExactSliding - 1), "%");
}

void freeRotation() {
  for (const double h : {1e-4, 3e-4, 1e-3, 10e-3 / 3, 1e-2}) {
    World world(tumblingBody(verlet(h)));
    const long steps = std::lround(10 / h);
    world.step();
    const double energy = world.report().energy.kinetic;
    double energy_error = 0;
    for (long i = 1; i < steps; ++i) {
      world.step();
      energy_error = std::max(energy_error, std::abs(world.report().energy.kinetic / energy - 1));
    }
    const Quaternion exact = test::freeRotation(Vector3(1, 2, 2.5), Vector3(0.01, 5, 0.01), steps * h);
    const double error = vectorFromRotation(Quaternion(world.linkPose(0).R) * exact.conjugate()).norm();
    std::printf("free: h %.4g ms orientation error %.3g rad, energy error %.3g\n", 1e3 * h, error, energy_error);
    if (h != 1e-3) continue;
    figure("free.orientation_err_rad", error, "rad");
    figure("free.energy_rel_err", energy_error, "1");
  }
  WorldDef def = tumblingBody(verlet(1e-3));
  def.settings.energy_ledger = false;
  World timed(def);
  figure("free.step_ns", 1e9 * secondsPerCall([&](int) { timed.step(); }, 20000), "ns");
}

}  // namespace haptic::bench
