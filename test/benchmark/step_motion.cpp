/// Motions beside velocity Verlet at small steps.
///
/// Error of position: largest distance of the body's origin from the reference's at the end of any step. Force: of the hand,
/// beside the mean of the reference's over the step. Time: CPU time of the stepping thread, mean of a run, median of seven
/// runs; the default method and implicit Euler take turns of ten steps. Dated values are those of commit 46c564e, measured at
/// another hour: machines and hours differ by more than a step's gain, so the same product is also printed with both times
/// over implicit Euler's of the same run.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <ctime>
#include <memory>

#include "../scenes/step_motions.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "step_figures.h"

namespace haptic::bench {
namespace {

using scenes::StepMotion;

constexpr int kRuns = 7, kTurn = 10;

/// At 46c564e: largest error of position [µm], mean step and implicit Euler's [µs].
struct Dated {
  const char* name;
  double error_um, mean_us, euler_us;
  bool product;  ///< its error × time is held to the dated one; else the error alone
};
constexpr Dated kDated[] = {{"slide_1e8", 8.309, 6.71, 4.34, true},      {"spin_1e8", 100.198, 12.92, 7.68, true},
                            {"push_1e8", 55.127, 9.43, 5.92, true},      {"push_1e10", 192.415, 12.62, 7.68, true},
                            {"press_1e8", 0.367, 8.91, 8.49, true},      {"rock_1e8", 36.388, 4.13, 5.09, true},
                            {"rock_1e10", 8955.475, 12.32, 7.76, true},  {"table", 455.055, 10.05, 9.77, false},
                            {"crosses", 941.141, 8.52, 7.62, false},     {"dominoes", 521.724, 119.05, 92.75, false},
                            {"hexagon", 15921.933, 6.29, 10.23, false},  {"stick_slip", 0.689, 6.55, 6.07, false}};

/// Pose of the body and force on the hand at the end of every step.
struct Track {
  std::vector<Vector3> p, F;
};

struct Run {
  Track track;
  std::vector<double> us;      ///< mean step of each run
  double worst_us = 0, evaluations = 0, factorisations = 0, gain = 0;
  int most_evaluations = 0, unconverged = 0, fallbacks = 0;
};

int stepsOf(const StepMotion& motion) { return static_cast<int>(std::lround(motion.seconds / 1e-3)); }

Track reference(const StepMotion& motion) {
  World world(motion.make(verletSettings(1e-3 / motion.fine)));
  Track track;
  for (int i = 0; i < stepsOf(motion); ++i) {
    Vector3 F = Vector3::Zero();
    for (int j = 0; j < motion.fine; ++j) {
      motion.aim(world);
      world.step();
      if (world.pointerCount() > 0) F += world.pointerWrench(0).force / motion.fine;
    }
    track.p.push_back(world.linkPose(motion.link).p);
    track.F.push_back(F);
  }
  return track;
}

void look(const World& world, const StepMotion& motion, Run& run) {
  const StepReport& report = world.report();
  run.track.p.push_back(world.linkPose(motion.link).p);
  run.track.F.push_back(world.pointerCount() > 0 ? Vector3(world.pointerWrench(0).force) : Vector3(Vector3::Zero()));
  run.evaluations += report.evaluations;
  run.factorisations += report.factorisations;
  run.most_evaluations = std::max(run.most_evaluations, report.evaluations);
  run.unconverged += (report.flags & (kNotConverged | kJointsNotConverged)) != 0;
  run.fallbacks += report.fallbacks;
}

std::array<Run, 2> measure(const StepMotion& motion, const std::array<Attempts, 2>& methods) {
  std::array<Run, 2> runs;
  const int steps = stepsOf(motion);
  for (int r = 0; r < kRuns; ++r) {
    std::array<std::unique_ptr<World>, 2> worlds;
    std::array<double, 2> us{}, worst{};
    for (int k = 0; k < 2; ++k) worlds[k] = std::make_unique<World>(motion.make(stepSettings(methods[k])));
    for (int turn = 0; turn < steps; turn += kTurn) {
      for (int k = 0; k < 2; ++k) {
        for (int i = turn; i < std::min(steps, turn + kTurn); ++i) {
          motion.aim(*worlds[k]);
          const double before = 1e6 * cpuSeconds();
          worlds[k]->step();
          const double took = 1e6 * cpuSeconds() - before;
          us[k] += took / steps;
          worst[k] = std::max(worst[k], took);
          if (r == 0) look(*worlds[k], motion, runs[k]);
        }
      }
    }
    for (int k = 0; k < 2; ++k) {
      runs[k].us.push_back(us[k]);
      runs[k].worst_us = r == 0 ? worst[k] : std::min(runs[k].worst_us, worst[k]);
    }
  }
  return runs;
}

/// Largest distance [m]; of forces the root of the mean square as well.
struct Error {
  double largest = 0, rms = 0;
};
Error errorOf(const std::vector<Vector3>& is, const std::vector<Vector3>& should) {
  Error error;
  for (std::size_t i = 0; i < is.size(); ++i) {
    const double off = (is[i] - should[i]).norm();
    error.largest = std::max(error.largest, off);
    error.rms += off * off / static_cast<double>(is.size());
  }
  error.rms = std::sqrt(error.rms);
  return error;
}

/// Geometric mean and largest of ratios.
struct Ratios {
  double log = 0, largest = 0;
  int count = 0;
  void add(double ratio) {
    log += std::log(std::max(ratio, 1e-12));
    largest = std::max(largest, ratio);
    ++count;
  }
  double mean() const { return std::exp(log / std::max(1, count)); }
};

}  // namespace

void runMotions(const char* filter) {
  Ratios product, product_vs_euler, errors;
  std::printf("%-11s %-9s %7s %7s | %5s %4s %5s | %9s %9s %9s | unconverged, fell back\n", "motion", "method", "mean_us", "worst",
              "eval", "most", "fact", "error_um", "F_max_N", "F_rms_N");
  for (const StepMotion& motion : scenes::stepMotions()) {
    if (filter && motion.name.find(filter) == std::string::npos) continue;
    const Track fine = reference(motion);
    const std::array<Run, 2> runs = measure(motion, {Attempts::kAll, Attempts::kImplicitEuler});
    for (int k = 0; k < 2; ++k) {
      const Run& run = runs[k];
      const Error p = errorOf(run.track.p, fine.p), F = errorOf(run.track.F, fine.F);
      const double n = static_cast<double>(run.track.p.size());
      std::printf("%-11s %-9s %7.2f %7.1f | %5.2f %4d %5.2f | %9.3f %9.4f %9.5f | %d %d\n", motion.name.c_str(),
                  k == 0 ? "automatic" : "euler", median(run.us), run.worst_us, run.evaluations / n, run.most_evaluations,
                  run.factorisations / n, 1e6 * p.largest, F.largest, F.rms, run.unconverged, run.fallbacks);
    }
    const double error_um = 1e6 * errorOf(runs[0].track.p, fine.p).largest;
    const double us = median(runs[0].us), euler_us = median(runs[1].us);
    figure("step." + motion.name + ".error_um", error_um, "um");
    figure("step." + motion.name + ".mean_us", us, "us");
    figure("step." + motion.name + ".mean_over_euler", us / euler_us, "1");
    if (motion.aim && !fine.F.empty() && motion.name.compare(0, 2, "pu") == 0) {
      const Error F = errorOf(runs[0].track.F, fine.F);
      figure("step." + motion.name + ".force_err_rms_n", F.rms, "N");
      figure("step." + motion.name + ".force_err_max_n", F.largest, "N");
    }
    for (const Dated& dated : kDated) {
      if (motion.name != dated.name) continue;
      const double error_ratio = error_um / dated.error_um;
      if (!dated.product) {
        errors.add(error_ratio);
        continue;
      }
      product.add(error_ratio * us / dated.mean_us);
      product_vs_euler.add(error_ratio * (us / euler_us) / (dated.mean_us / dated.euler_us));
    }
  }
  if (filter) return;
  figure("step.time_error_over_dated", product.mean(), "1");
  figure("step.time_error_over_dated_max", product.largest, "1");
  figure("step.time_error_vs_euler_over_dated", product_vs_euler.mean(), "1");
  figure("step.time_error_vs_euler_over_dated_max", product_vs_euler.largest, "1");
  figure("step.error_over_dated_max", errors.largest, "1");
}

}  // namespace haptic::bench
