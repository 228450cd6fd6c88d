/// The sessions of a bag, checked and in the core's terms.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptic_core/loop/session.h"

namespace haptic {

struct RecordedSession {
  std::string scene, scene_file, scene_text;
  std::uint64_t fingerprint = 0, world_hash = 0;
  double rate = 1000, default_density = 0;
  std::string program, build;
  bool same_bits = true;             ///< false: recorded by a version or build that computes other last bits
  std::vector<std::string> links;
  SessionStart start;                ///< without the devices' definitions: those are in `device_texts`
  std::vector<std::string> device_texts;
  std::vector<LoopEvent> events;     ///< in order
  std::vector<TickInput> ticks;      ///< consecutive
  std::vector<TickHash> hashes;      ///< by tick
  std::uint64_t periods = 0;         ///< that the ticks took, those lost included
  struct ClockNote {
    std::size_t ticks;               ///< the first so many were
    double started;                  ///< at this time by ROS's clock, as told by when their message was made [s]
  };
  std::vector<ClockNote> clock;      ///< one per message
};

/// Reads topics recorded/session, recorded/events, recorded/ticks below any namespace. Throws SetupError, one line:
/// no bag, truncated, no recording in it, another format, ticks missing.
std::vector<RecordedSession> readSessions(const std::string& bag);

}  // namespace haptic
