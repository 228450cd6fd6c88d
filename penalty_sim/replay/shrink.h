/// A recorded session that shows a fault, reduced to the least ticks, bodies and parameters that still show it.
///
/// Each attempt is a session of its own: the loop's memory at a later tick (loop/session.h), fewer ticks, fewer bodies (World::exchange),
/// one parameter at its plain value. It is replayed from its start, and kept where the fault is there again. Ticks go first: a flag that
/// one step raises needs that step alone. Bodies go by halves, then by ever smaller groups (Zeller, Hildebrandt, IEEE TSE 28, 2002, ddmin
/// without complements). The result is a least one of this order, not the least of all.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "replay/recorded_session.h"
#include "scene/scene_file.h"

namespace haptic {

/// A session that can be run, and made smaller.
struct ShrinkAttempt {
  SessionStart start;             ///< with the devices' definitions
  SceneDef scene;                 ///< with the bodies that there are
  std::vector<LoopEvent> events;  ///< in order
  std::vector<TickInput> ticks;
  std::vector<TickHash> hashes;   ///< as recorded; of other bodies they mean nothing

  std::size_t links() const;
};

/// What an attempt must show.
struct Fault {
  std::string name;  ///< in words
  /// Index of the first tick by which the fault is there; −1: it is not.
  std::function<int(const ShrinkAttempt&)> first;
  bool bodies_stay = false;  ///< fewer bodies would be another fault
  bool end_unknown = false;  ///< `first` knows the last tick alone: a test from outside
};

/// The fault called `name`: of kStepFlagWords or kDeviceFlagWords, "stopped", "difference" or "late"; empty: the worst that the attempt
/// shows. Throws SetupError: no such name, or nothing wrong.
Fault faultNamed(const std::string& name, const ShrinkAttempt& whole);

struct Shrunk {
  ShrinkAttempt attempt;
  std::vector<std::string> plain;  ///< parameters that stand at their plain values
  int attempts = 0;
};

/// Throws SetupError where `whole` does not show the fault.
Shrunk shrink(const ShrinkAttempt& whole, const Fault& fault);

/// Of a recorded session. Throws SetupError, as ReplayRun does.
ShrinkAttempt attemptOf(const RecordedSession& session);
/// A bag that is replayed like any other; hashes are those of a replay, or as recorded. Throws SetupError.
void writeAttempt(const ShrinkAttempt& attempt, const RecordedSession& like, bool recorded_hashes, const std::string& path);

}  // namespace haptic
