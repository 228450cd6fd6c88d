/// One run of the report: a scene, a simulator, a step. States at the sample times, and what the steps cost.
#pragma once
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/world/world.h"
#include "peer_world.h"
#include "report_scene.h"

namespace haptic::report {

struct RunResult {
  std::string status = "ok";    ///< ok, diverged, refused
  std::string reason;           ///< why not ok
  double time_reached = 0;      ///< simulated [s]
  long steps = 0;
  double setup_s = 0;
  std::vector<double> cpu_s;    ///< CPU time of each repetition of the whole run [s]
  /// CPU time of single steps [s]: median over the repetitions of each repetition's quantile. The first step is left out.
  double step_p50 = 0, step_p99 = 0, step_p999 = 0, step_max = 0;
  /// Ours: median over the steps that computed a contact, which bodies in flight and islands that stand do not; 0: there were none.
  double step_touching_p50 = 0;
  long allocations = 0;         ///< heap allocations of all steps of the first repetition
  long iterations = 0, unconverged = 0;             ///< of the implicit solve, over the run
  int iterations_worst = 0, evaluations_worst = 0;  ///< of any step
  /// Ours: energy that the ledger gained without a source over the largest energy exchanged, or over what lifts the bodies by
  /// a millionth of the scene's size and speeds them up by a millionth of their energy where less is exchanged.
  double energy_gain = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::pair<std::string, double>> measures;  ///< of the scene's own
  std::vector<Sample> samples;
};

/// What the report needs of a simulator: ours and the peers'. `scene` outlives it.
class Simulator {
 public:
  virtual ~Simulator() = default;
  virtual void step() = 0;
  virtual BodyState body(int link) const = 0;
  virtual Wrench onHand(int i) const = 0;
  virtual bool finite() const { return true; }
  virtual const World* world() const { return nullptr; }
};

struct Method {
  Choice choice;
  std::optional<peers::PeerSettings> peer;  ///< unset: ours
};

/// Runs it once with sampling and then again, timed alone, until `budget_s` of CPU time or nine repetitions are used. A run that would take
/// more than twice `limit_s` of CPU time, by the share that is done, fails once it has used a tenth of that (0: none does).
RunResult runCase(const Scene& scene, const Method& method, double budget_s, double limit_s = 0);

/// A simulator at the start of a scene, with steps of h [s]. `def`: what it was made of. Throws SetupError.
std::unique_ptr<Simulator> makeSimulator(const Scene& scene, const Method& method, double h, WorldDef& def);

/// The exact solution at the sample times.
std::vector<Sample> exactSamples(const Scene& scene);

}  // namespace haptic::report
