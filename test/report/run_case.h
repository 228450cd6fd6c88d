/// One run of the report: a scene, a simulator, a step. States at the sample times, and what the steps cost.
#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "peer_world.h"
#include "report_scene.h"

namespace haptic::report {

/// States at one sample time, and what follows from them for all compared bodies together.
struct Sample {
  double time = 0;
  double energy = 0;            ///< kinetic and potential [J]
  Vector3 momentum = Vector3::Zero(), angular_momentum = Vector3::Zero();  ///< about W's origin
  std::vector<Wrench> hands;    ///< on each hand, in W, about the link's origin
  std::vector<BodyState> bodies;
};

struct RunResult {
  std::string status = "ok";    ///< ok, diverged, refused
  std::string reason;           ///< why not ok
  double time_reached = 0;      ///< simulated [s]
  long steps = 0;
  double setup_s = 0;
  std::vector<double> cpu_s;    ///< CPU time of each repetition of the whole run [s]
  double step_p50 = 0, step_p99 = 0, step_max = 0;  ///< wall time of single steps in the first repetition [s]
  long allocations = 0;         ///< heap allocations of all steps of the first repetition
  long iterations = 0, unconverged = 0;             ///< of the implicit solve, over the run
  /// Ours: largest change of the ledger's balance over the largest energy in it. NaN: a peer, or longer than the budget.
  double energy_balance = std::numeric_limits<double>::quiet_NaN();
  std::vector<Sample> samples;
};

struct Method {
  Choice choice;
  std::optional<peers::PeerSettings> peer;  ///< unset: ours
};

/// Runs it once with sampling and then again, timed alone, until `budget_s` of CPU time or nine repetitions are used.
RunResult runCase(const Scene& scene, const Method& method, double budget_s);

/// The exact solution at the sample times.
std::vector<Sample> exactSamples(const Scene& scene);

}  // namespace haptic::report
