/// The sessions of a bag, checked and in the core's terms.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/loop/session.h"

namespace haptic {

struct RecordedSession {
  std::string scene, scene_file, scene_text;
  std::uint64_t fingerprint = 0, world_hash = 0;
  double rate = 1000, default_density = 0;
  std::string program, build;
  std::vector<std::string> links;
  SessionStart start;                ///< without the devices' definitions: those are in `device_texts`
  std::vector<std::string> device_texts;
  std::vector<LoopEvent> events;     ///< in order
  std::vector<TickInput> ticks;      ///< consecutive
  std::vector<TickHash> hashes;      ///< by tick
};

struct BagOptions {
  bool any_build = false;            ///< read recordings of another build as well: last bits may differ
};

/// Reads topics recorded/session, recorded/events, recorded/ticks below any namespace. Throws SetupError, one line:
/// no bag, truncated, no recording in it, another version or build, ticks missing.
std::vector<RecordedSession> readSessions(const std::string& bag, const BagOptions& options = {});

}  // namespace haptic
