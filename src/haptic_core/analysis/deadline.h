/// Certificate of a deadline: the most work that a step may take under a budget (world/counted_work.h), and the time of that here.
///
/// A step whose budget is used up gives way: islands that wait for a turn wait on, second attempts and iterations are left out,
/// the rest of a swept step, or of an island's that is halved, is done at once. The operation under way ends first, and work that a step
/// cannot do without comes on top. So no step does more than
///
///     budget + least,   least = step + look at everything + sweep + 7 (evaluation + Newton step) of everything,
///
/// with all pairs that may overlap at once, all links that no hand and no motion leads, and matrices without a zero. It is tight for scenes
/// of a few bodies; of many, only few touch at once, and it says that nothing is certain where nothing was ever late. Both are
/// counts; `seconds_per_unit` is measured: the CPU time of a step over its work, in the median of all steps with at least half of the most
/// work. Time that the machine takes from a thread beside its work (interrupts, another program's memory) is not in it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

class World;

/// What a deadline comes to for a scene.
struct DeadlineReport {
  double deadline = 0;          ///< CPU time that a step may take [s]
  double seconds_per_unit = 0;  ///< here, for this scene [s]
  double least = 0;             ///< see above [units]
  double budget = 0;            ///< the most that keeps the deadline [units]; 0: `least` alone takes longer
  long steps = 0;               ///< of the run; 0: nothing has moved in it, and all other values are 0
  double seen = 0;              ///< most work of a step in the run [units]
  double median = 0, worst = 0; ///< CPU time of a step in it [s]

  bool kept() const { return budget > 0; }               ///< a budget keeps it; false as well where nothing moves
  double bound() const { return budget + least; }        ///< [units]
  double seconds() const { return bound() * seconds_per_unit; }  ///< of the bound [s]
  std::string text() const;                              ///< one line for people
};

/// Share of a tick that its step may take: the rest is the device's and the system's.
inline constexpr double kShareOfTick = 0.7;

/// Work of a step beyond its budget at most [units].
double leastWork(const World& world);

/// Runs a copy of the scene for `seconds` of simulated time, or 2 s of CPU time, `drive` before each step: it leads the hands. Throws
/// SetupError as World does.
DeadlineReport certifyDeadline(const WorldDef& def, double deadline, double seconds, const std::function<void(World&)>& drive);

}  // namespace haptic
