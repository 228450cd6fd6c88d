#include "spidar_driver/transport/link_story.h"

namespace haptic {

void LinkStory::say(const std::string& text) {
  std::lock_guard<std::mutex> lock(said_mutex_);
  said_ = text;
}

LinkReport LinkStory::report() const noexcept {
  const auto read = [this](Counter c) { return counters_[c].load(std::memory_order_relaxed); };
  LinkReport r;
  r.cycles = read(kCycles);
  r.stale = read(kStale);
  r.lost = read(kLost);
  r.late = read(kLate);
  r.doubled = read(kDoubled);
  r.foreign_bytes = read(kForeign);
  r.refused_counts = read(kRefused);
  r.restarts = read(kRestarts);
  r.retaught = read(kRetaught) - 1;  // the first time is the opening
  r.reconnects = read(kReconnects);
  r.over_rate = read(kOverRate);
  r.bad_commands = read(kBadCommands);
  r.clamped = read(kClamped);
  r.stalls = read(kStalls);
  r.unguarded = read(kUnguarded);
  r.guard_stalls = guard_stalls_.load(std::memory_order_relaxed);
  r.silent_boards = silent_boards_.load(std::memory_order_relaxed);
  r.delay_us = delay_us_.load(std::memory_order_relaxed);
  r.jitter_us = jitter_us_.load(std::memory_order_relaxed);
  return r;
}

std::string LinkStory::trouble() const {
  {
    std::lock_guard<std::mutex> lock(said_mutex_);
    if (!said_.empty()) return said_;
  }
  const std::string now = std::to_string(trouble_board_.load()),
                    then = "board " + std::to_string(cause_board_.load());
  switch (static_cast<BusRestart::Trouble>(trouble_.load())) {
    case BusRestart::Trouble::kNone:
      break;
    case BusRestart::Trouble::kSilentBoard:
      return "board " + now + " does not answer: check its power and cable";
    case BusRestart::Trouble::kOtherBoard:
      return "another board than before answers as id " + now + ": restart the driver";
    case BusRestart::Trouble::kNoisy:
      return "bytes come that nobody asked for: check cable, ground and baud rate";
    case BusRestart::Trouble::kForgets:
      return "board " + now +
             " loses step again as soon as it is taught: switch its power off and on, then check its cable";
  }
  const std::string again = std::string("; the boards were taught anew") + (proven_.load() ? " and obey" : "");
  switch (static_cast<Cause>(cause_.load())) {
    case Cause::kNone:
    case Cause::kOpened:
      return {};
    case Cause::kSilent:
      return then + " was silent" + again;
    case Cause::kLossy:
      return then + " lost one command in five" + again;
    case Cause::kRestarted:
      return then + " started anew or its counter jumped: its lengths are lost, calibrate" + again;
    case Cause::kOtherBoard:
      return then + " answered as another model" + again;
    case Cause::kPowerLost:
      return then + " had lost its power: check its supply, calibrate" + again;
    case Cause::kDisobeys:
      return then + " answered and did not obey" + again;
    case Cause::kStalled:
      return "the loop stood still for " + std::to_string(stall_ms_.load()) +
             " ms, this machine was busy or the driver was stopped: spidar_latency says what to change";
    case Cause::kFlood:
      return "bytes came without end" + again;
  }
  return {};
}

}  // namespace haptic
