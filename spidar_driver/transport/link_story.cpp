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
  const int board = trouble_board_.load();
  const std::string now = std::to_string(board);
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
      return whatHappened(DeviceCause::kForgets, board, 0) + ": switch its power off and on, then check its cable";
  }
  const WireFinding cause = this->cause();
  if (cause == WireFinding::kNone) return {};
  const std::string happened = whatHappened(causeOf(cause), cause_board_.load(), 1e-3 * stall_ms_.load());
  if (cause == WireFinding::kStalled) return happened;
  return happened + "; the boards were taught anew" + (proven_.load() ? " and obey" : "");
}

}  // namespace haptic
