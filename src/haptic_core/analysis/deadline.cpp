#include "haptic_core/analysis/deadline.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/cpu_time.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/work.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr int kWarming = 10;         ///< steps that touch memory for the first time, and count for nothing
constexpr double kPatience = 2;      ///< CPU time after which a run ends [s]: a heap that falls takes seconds for each of its own
constexpr double kHeavy = 0.5;       ///< of the most work: such steps tell the time of a unit, small ones are mostly caches and the clock
/// Of every island: those of the attempt under way, those of implicit Euler, and evaluations that keep the energy. The pass in which the
/// budget ends may take three Newton steps more than the one of each, and the last three take none.
constexpr int kPasses = 2 * stepping::kFewestPasses + stepping::IslandStep::kKeepingEnergy;
constexpr long kFewPairs = 100000;   ///< so many are added up one by one; of more, all are taken for the costliest

struct TimedStep {
  double units, seconds;
};

/// Pairs that may overlap at once.
struct Pairs {
  double count = 0, looks = 0;  ///< looks at all of them [units]
};

/// Of those that `counts`, the costliest, as many as a step has room for.
template <class Counts>
Pairs pairsOf(const Model& model, Counts&& counts) {
  const int shapes = static_cast<int>(model.shapes.size());
  std::vector<double> looks;
  double costliest = 0;
  for (const ModelShape& shape : model.shapes) costliest = std::max(costliest, shape.look);
  if (model.possible_pairs > kFewPairs) {
    looks.assign(static_cast<std::size_t>(model.pair_capacity), 2 * costliest + (model.has_seams ? units::kSeams : 0));
  } else {
    for (int a = 0; a < shapes; ++a) {
      for (int b = a + 1; b < shapes; ++b) {
        if (model.mayCollide(a, b) && counts(a, b)) looks.push_back(model.look(a, b));
      }
    }
    std::sort(looks.begin(), looks.end(), std::greater<>());
    looks.resize(std::min(looks.size(), static_cast<std::size_t>(model.pair_capacity)));
  }
  Pairs pairs;
  for (const double look : looks) pairs.looks += look;
  pairs.count = static_cast<double>(looks.size());
  return pairs;
}

/// That reading the clock twice takes [s].
double clockSeconds() {
  double least = 1;
  for (int i = 0; i < 100; ++i) {
    const double start = cpuSeconds();
    least = std::min(least, cpuSeconds() - start);
  }
  return least;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

double leastWork(const World& world) {
  const Model& model = world.model();
  const HandWork& hands = world.work().hands;
  const auto moves = [&](int shape) {
    const ModelTree& tree = model.trees[static_cast<std::size_t>(model.treeOf(shape))];
    return model.links[static_cast<std::size_t>(model.shapes[static_cast<std::size_t>(shape)].link)].moves && hands.movesByItself(tree);
  };
  double links = 0, unknowns = 0;
  for (const ModelTree* tree : hands.movers) links += tree->model->linkCount(), unknowns += tree->model->nv();
  const Pairs all = pairsOf(model, [](int, int) { return true; });
  const Pairs solved = pairsOf(model, [&](int a, int b) { return moves(a) || moves(b); });
  const double attempt = units::kLink * links + all.looks, sweep = units::kSweep * all.count;
  if (!model.implicit_steps) return units::kStep + 2 * attempt + sweep;
  const double rows = static_cast<double>(hands.movers.size()) + solved.count + static_cast<double>(model.forces.size());
  const double n = unknowns + 6, newton = units::kRow * rows + units::kProduct * n * n * n / 6;
  return units::kStep + attempt + sweep + kPasses * (units::kLink * links + solved.looks + newton);
}

std::string DeadlineReport::text() const {
  if (steps == 0) return "nothing moves, and a step takes no time";
  std::ostringstream out;
  out.precision(3);
  out << 1e6 * median << " µs a step, " << 1e6 * worst << " µs the worst of " << steps << " (" << seen << " units of work); ";
  if (kept()) {
    out << "with a budget of " << budget << " units no step takes more than " << bound() << ", " << 1e6 * seconds()
        << " µs here: a deadline of " << 1e6 * deadline << " µs is kept";
  } else {
    out << "a deadline of " << 1e6 * deadline << " µs is not certain: the work that no budget takes away may take "
        << 1e6 * least * seconds_per_unit << " µs";
  }
  return out.str();
}

DeadlineReport certifyDeadline(const WorldDef& def, double deadline, double seconds, const std::function<void(World&)>& drive) {
  WorldDef copy = def;
  copy.settings.history_steps = 0;
  World world(copy);
  DeadlineReport report;
  report.deadline = deadline;
  report.least = leastWork(world);
  const long steps = kWarming + std::lround(seconds / def.settings.step);
  const double clock = clockSeconds(), began = cpuSeconds();
  std::vector<TimedStep> timed;
  for (long i = 0; i < steps && world.report().finite && (i <= 10 * kWarming || cpuSeconds() - began < kPatience); ++i) {
    drive(world);
    const double start = cpuSeconds();
    world.step();
    if (i < kWarming) continue;
    timed.push_back({world.report().work, std::max(0.0, cpuSeconds() - start - clock)});
    report.seen = std::max(report.seen, timed.back().units);
  }
  if (!(report.seen > 0)) return report;
  std::vector<double> times, per_unit;
  for (const TimedStep& step : timed) {
    times.push_back(step.seconds);
    if (step.units >= kHeavy * report.seen) per_unit.push_back(step.seconds / step.units);
  }
  report.steps = static_cast<long>(times.size());
  report.worst = *std::max_element(times.begin(), times.end());
  report.median = median(std::move(times));
  report.seconds_per_unit = median(std::move(per_unit));
  report.budget = std::max(0.0, deadline / report.seconds_per_unit - report.least);
  return report;
}

}  // namespace haptic
