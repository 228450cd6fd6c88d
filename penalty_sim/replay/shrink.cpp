#include "replay/shrink.h"

#include <haptic_msgs/flag_words.h>

#include <algorithm>
#include <numeric>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/world.h"
#include "replay/replay_run.h"
#include "scene/scene_bodies.h"

namespace haptic {
namespace {

constexpr double kMostOfWork = 0.9;  // of a late tick's counted work that a reduced one still does [1]

/// Runs an attempt; `after` is told the index of each tick and ends the run by `false`.
void run(const ShrinkAttempt& attempt, const std::function<bool(std::size_t, SessionReplay&, const TickHash&)>& after) {
  SessionReplay replay(attempt.scene.world, attempt.start);
  std::size_t event = 0;
  for (std::size_t t = 0; t < attempt.ticks.size(); ++t) {
    for (; event < attempt.events.size() && attempt.events[event].tick <= attempt.ticks[t].tick; ++event) {
      replay.apply(attempt.events[event].command);
    }
    const TickHash hash = replay.tick(attempt.ticks[t]);
    if (!after(t, replay, hash)) return;
  }
}

using Shows = std::function<bool(std::size_t, SessionReplay&, const TickHash&)>;

/// A fault that one tick shows.
Fault faultOfTick(const std::string& name, const std::function<Shows(const ShrinkAttempt&)>& shows) {
  return {name, [shows](const ShrinkAttempt& attempt) {
            int first = -1;
            const Shows here = shows(attempt);
            run(attempt, [&](std::size_t t, SessionReplay& replay, const TickHash& hash) {
              if (here(t, replay, hash)) first = static_cast<int>(t);
              return first < 0;
            });
            return first;
          }};
}

Fault stepFlag(unsigned flag, const std::string& name) {
  return faultOfTick(name, [flag](const ShrinkAttempt&) -> Shows {
    return [flag](std::size_t, SessionReplay& replay, const TickHash&) { return (replay.world().report().flags & flag) != 0; };
  });
}

Fault deviceFlag(unsigned flag, const std::string& name) {
  return faultOfTick(name, [flag](const ShrinkAttempt&) -> Shows {
    return [flag](std::size_t, SessionReplay& replay, const TickHash&) {
      for (int i = 0; i < replay.loop().handCount(); ++i) {
        if (replay.loop().hand(i).device().flags() & flag) return true;
      }
      return false;
    };
  });
}

Fault stopped() {
  return faultOfTick("the world stopped", [](const ShrinkAttempt&) -> Shows {
    return [](std::size_t, SessionReplay& replay, const TickHash&) { return !replay.world().report().finite; };
  });
}

Fault difference() {
  Fault fault = faultOfTick("a replay that differs", [](const ShrinkAttempt& attempt) -> Shows {
    return [&attempt](std::size_t t, SessionReplay&, const TickHash& hash) {
      return attempt.hashes[t].parts > 0 && !(hash == attempt.hashes[t]);
    };
  });
  fault.bodies_stay = true;
  return fault;
}

/// The first tick that others were lost before: the step that took the time is the one before it. It cannot be timed again, so the work
/// that it counts stands for its time.
Fault late(const ShrinkAttempt& whole) {
  double work = -1, before = 0;
  run(whole, [&](std::size_t t, SessionReplay& replay, const TickHash&) {
    if (t > 0 && whole.ticks[t].lost_periods > 0) work = before;
    before = replay.world().report().work;
    return work < 0;
  });
  return faultOfTick("a missed deadline", [work](const ShrinkAttempt& attempt) -> Shows {
    return [work, &attempt, before = -1.0](std::size_t t, SessionReplay& replay, const TickHash&) mutable {
      const bool shown = work >= 0 && before >= kMostOfWork * work && attempt.ticks[t].lost_periods > 0;
      before = replay.world().report().work;
      return shown;
    };
  });
}

/// What a session shows, of one run.
struct Seen {
  unsigned step = 0, device = 0;  // flags
  bool stopped = false, different = false, late = false;
};

Seen seenIn(const ShrinkAttempt& whole) {
  Seen seen;
  run(whole, [&](std::size_t t, SessionReplay& replay, const TickHash& hash) {
    seen.step |= replay.world().report().flags;
    for (int i = 0; i < replay.loop().handCount(); ++i) seen.device |= replay.loop().hand(i).device().flags();
    seen.stopped = seen.stopped || !replay.world().report().finite;
    seen.different = seen.different || (whole.hashes[t].parts > 0 && !(hash == whole.hashes[t]));
    seen.late = seen.late || (t > 0 && whole.ticks[t].lost_periods > 0);
    return true;
  });
  return seen;
}

/// The worst first: what stopped, what differs, warnings, what was late, notes of the step.
std::string worstOf(const Seen& seen) {
  if (seen.stopped) return "stopped";
  if (seen.different) return "difference";
  for (const FlagGrade grade : {FlagGrade::kWarning, FlagGrade::kNote}) {
    for (const FlagWords& words : kStepFlagWords) {
      if (words.grade == grade && (seen.step & words.flag)) return words.name;
    }
    for (const FlagWords& words : kDeviceFlagWords) {
      if (grade == FlagGrade::kWarning && words.grade == grade && (seen.device & words.flag)) return words.name;
    }
    if (seen.late) return "late";
  }
  throw SetupError("the session", "shows no fault: no flag, no missed deadline, no difference",
                   "say --test COMMAND, which ends with 0 where the fault is there");
}

/// The attempt begun before its tick `index`.
ShrinkAttempt begunAt(const ShrinkAttempt& from, std::size_t index) {
  if (index == 0) return from;
  SessionReplay replay(from.scene.world, from.start);
  ShrinkAttempt later = from;
  std::vector<int> origins(from.start.hands.size());
  std::iota(origins.begin(), origins.end(), 0);
  std::size_t event = 0;
  const auto applyBefore = [&](std::uint64_t tick) {
    for (; event < from.events.size() && from.events[event].tick <= tick; ++event) {
      const LoopCommand& command = from.events[event].command;
      replay.apply(command);
      if (command.is<DropHand>()) origins.erase(origins.begin() + command.hand);
      const auto* const change = std::get_if<ChangeBodies>(&command.kind);
      if (change) later.scene = withBodies(later.scene, unpackBodies(*change->packed));
    }
  };
  for (std::size_t t = 0; t < index; ++t) {
    applyBefore(from.ticks[t].tick);
    replay.tick(from.ticks[t]);
  }
  applyBefore(from.ticks[index].tick);
  LoopMemory memory = roomFor(from.start, from.start.world_state.size());
  remember(replay.loop(), from.ticks[index].tick, memory);
  std::array<int, kMaxHands> hands{};
  std::copy(origins.begin(), origins.end(), hands.begin());
  later.start = startedAt(from.start, memory, hands);
  const auto offset = static_cast<std::ptrdiff_t>(index);
  later.events.assign(from.events.begin() + static_cast<std::ptrdiff_t>(event), from.events.end());
  later.ticks.assign(from.ticks.begin() + offset, from.ticks.end());
  later.hashes.assign(from.hashes.begin() + offset, from.hashes.end());
  return later;
}

ShrinkAttempt endedAfter(const ShrinkAttempt& from, std::size_t count) {
  ShrinkAttempt shorter = from;
  shorter.ticks.resize(count);
  shorter.hashes.resize(count);
  const std::uint64_t last = from.ticks[count - 1].tick;
  shorter.events.erase(std::remove_if(shorter.events.begin(), shorter.events.end(), [&](const LoopEvent& e) { return e.tick > last; }),
                       shorter.events.end());
  return shorter;
}

/// The attempt without the trees of these links. Throws SetupError where a hand holds one.
ShrinkAttempt without(const ShrinkAttempt& from, const std::vector<std::string>& names) {
  ChangedScene changed{from.scene, {}, {}};
  std::vector<int> kept(from.scene.world.articulations.size());
  std::iota(kept.begin(), kept.end(), 0);
  for (const std::string& name : names) {
    ChangedScene next = withoutModel(changed.scene, name);
    std::vector<int> composed;
    for (const int index : next.kept) composed.push_back(kept[static_cast<std::size_t>(index)]);
    kept = composed;
    changed.scene = std::move(next.scene);
  }
  ShrinkAttempt smaller = from;
  smaller.scene = changed.scene;
  SessionReplay replay(from.scene.world, from.start);
  ChangeBodies change;
  *change.packed = packBodies(changed.scene.world, kept);
  replay.apply({change});
  LoopMemory memory = roomFor(from.start, from.start.world_state.size());
  remember(replay.loop(), from.start.first_tick, memory);
  std::array<int, kMaxHands> hands{};
  std::iota(hands.begin(), hands.end(), 0);
  smaller.start = startedAt(from.start, memory, hands);
  return smaller;
}

/// The attempt with another definition of as many bodies.
ShrinkAttempt withDefinition(const ShrinkAttempt& from, const WorldDef& def) {
  ShrinkAttempt plain = from;
  plain.scene.world = def;
  std::vector<int> kept(plain.scene.world.articulations.size());
  std::iota(kept.begin(), kept.end(), 0);
  plain.start.bodies = packBodies(plain.scene.world, kept);
  return plain;
}

/// Tries attempts and keeps those that still show the fault.
class Search {
 public:
  Search(const ShrinkAttempt& whole, const Fault& fault) : fault_(fault) { result_.attempt = whole; }

  bool keep(const std::function<ShrinkAttempt(const ShrinkAttempt&)>& make) {
    ++result_.attempts;
    try {
      ShrinkAttempt smaller = make(result_.attempt);
      if (smaller.ticks.empty() || fault_.first(smaller) < 0) return false;
      result_.attempt = std::move(smaller);
      return true;
    } catch (const SetupError&) {  // a body that a hand holds, a state that no longer fits
      return false;
    }
  }

  void shortenTicks() {
    const int first = fault_.first(result_.attempt);
    if (first < 0) throw SetupError("the session", "does not show this fault: " + fault_.name, "see ./run replay and ./run report");
    result_.attempt = endedAfter(result_.attempt, static_cast<std::size_t>(first) + 1);
    for (std::size_t without = 0, with = result_.attempt.ticks.size(); fault_.end_unknown && with - without > 1;) {
      const std::size_t middle = without + (with - without) / 2;
      (keep([&](const ShrinkAttempt& from) { return endedAfter(from, middle); }) ? with : without) = middle;
    }
    const std::size_t last = result_.attempt.ticks.size() - 1;
    for (std::size_t back = 0; back < last; back = 2 * back + 1) {
      if (keep([&](const ShrinkAttempt& from) { return begunAt(from, last - back); })) return;
    }
  }

  void dropBodies() {
    for (std::size_t size = result_.attempt.scene.world.articulations.size() / 2; size > 0; size /= 2) {
      for (std::size_t begin = 0; begin < result_.attempt.scene.world.articulations.size();) {
        const auto& trees = result_.attempt.scene.world.articulations;
        std::vector<std::string> names;
        for (std::size_t a = begin; a < std::min(trees.size(), begin + size); ++a) {
          if (!held(static_cast<int>(a))) names.push_back(trees[a].links.front().name);
        }
        if (names.empty() || !keep([&](const ShrinkAttempt& from) { return without(from, names); })) begin += size;
      }
    }
  }

  void dropEvents() {
    for (std::size_t i = 0; i < result_.attempt.events.size();) {
      const bool gone = keep([i](const ShrinkAttempt& from) {
        ShrinkAttempt fewer = from;
        fewer.events.erase(fewer.events.begin() + static_cast<std::ptrdiff_t>(i));
        return fewer;
      });
      if (!gone) ++i;
    }
  }

  void makePlain() {
    const std::vector<double> untuned = World(result_.attempt.scene.world).tuning().numbers();
    if (untuned != result_.attempt.start.world_tuning) {
      plain("tuning", [&](const ShrinkAttempt& from) {
        ShrinkAttempt plain = from;
        plain.start.world_tuning = untuned;
        return plain;
      });
    }
    const auto define = [&](const char* name, const std::function<void(WorldDef&)>& edit) {
      WorldDef edited = result_.attempt.scene.world;
      edit(edited);
      if (fingerprint(edited) == fingerprint(result_.attempt.scene.world)) return;
      plain(name, [&](const ShrinkAttempt& from) { return withDefinition(from, edited); });
    };
    define("no drive paths", [](WorldDef& def) { def.joint_paths.clear(); });
    define("no forces between links", [](WorldDef& def) { def.forces.clear(); });
    define("no loops", [](WorldDef& def) { def.loops.clear(); });
    define("no friction", [](WorldDef& def) {
      for (ArticulationDef& articulation : def.articulations) {
        for (LinkDef& link : articulation.links) {
          for (CollisionDef& collision : link.collisions) collision.material.mu_static = collision.material.mu_dynamic = 0;
        }
      }
    });
  }

  Shrunk take() { return std::move(result_); }

 private:
  bool held(int articulation) const {
    const auto& pointers = result_.attempt.scene.world.pointers;
    return std::any_of(pointers.begin(), pointers.end(), [&](const PointerDef& p) { return p.articulation == articulation; });
  }
  void plain(const char* name, const std::function<ShrinkAttempt(const ShrinkAttempt&)>& make) {
    if (keep(make)) result_.plain.emplace_back(name);
  }

  const Fault& fault_;
  Shrunk result_;
};

}  // namespace

std::size_t ShrinkAttempt::links() const {
  std::size_t count = 0;
  for (const ArticulationDef& articulation : scene.world.articulations) count += articulation.links.size();
  return count;
}

Fault faultNamed(const std::string& name, const ShrinkAttempt& whole) {
  if (name.empty()) return faultNamed(worstOf(seenIn(whole)), whole);
  if (name == "stopped") return stopped();
  if (name == "difference") return difference();
  if (name == "late") return late(whole);
  std::string known = "stopped, difference, late";
  for (const FlagWords& words : kStepFlagWords) {
    if (name == words.name) return stepFlag(words.flag, words.text);
    known += std::string(", ") + words.name;
  }
  for (const FlagWords& words : kDeviceFlagWords) {
    if (name == words.name) return deviceFlag(words.flag, words.text);
    known += std::string(", ") + words.name;
  }
  throw SetupError("--fault " + name, "is no fault", "there are: " + known);
}

Shrunk shrink(const ShrinkAttempt& whole, const Fault& fault) {
  Search search(whole, fault);
  search.shortenTicks();
  if (!fault.bodies_stay) {
    search.dropBodies();
    search.dropEvents();
    search.makePlain();
  }
  return search.take();
}

ShrinkAttempt attemptOf(const RecordedSession& session) {
  const ReplayRun run(session);
  ShrinkAttempt attempt{session.start, run.scene(), session.events, session.ticks, session.hashes};
  for (std::size_t i = 0; i < attempt.start.hands.size(); ++i) attempt.start.hands[i].def = run.devices()[i];
  return attempt;
}

}  // namespace haptic
