/// What a wire has been through since it was opened: for diagnostics.
#pragma once
#include <cstdint>
#include <string>

namespace haptic {

struct LinkReport {
  std::uint64_t cycles = 0;          ///< exchanges sent
  std::uint64_t stale = 0;           ///< exchanges that brought no new counts of some board
  std::uint64_t lost = 0;            ///< answers that never came
  std::uint64_t late = 0;            ///< answers that came after their exchange had given up
  std::uint64_t doubled = 0;         ///< answers that nobody had asked for any more
  std::uint64_t foreign_bytes = 0;   ///< bytes that belong to no answer
  std::uint64_t refused_counts = 0;  ///< readings that no string can have made
  std::uint64_t restarts = 0;        ///< counters that started anew: calibrate again
  std::uint64_t reconnects = 0;      ///< times the port was opened again
  std::uint64_t over_rate = 0;       ///< exchanges asked for before the wire was free; they waited
  std::uint64_t bad_commands = 0;    ///< commands with a value that is not finite; they became zero current
  std::uint64_t clamped = 0;         ///< drive values outside the string's tension range
  std::uint64_t stalls = 0;          ///< times the loop stood still for longer than a board may be silent, with current on
  std::uint64_t retaught = 0;        ///< times the boards were brought back into step
  std::uint64_t unguarded = 0;       ///< times the guard ended or stood still, and the driver turned the motors off
  std::uint64_t guard_stalls = 0;    ///< times the loop stood still and the guard turned the motors off
  std::uint32_t silent_boards = 0;   ///< bit per board id that does not answer now
  std::uint32_t delay_us = 0;        ///< of the wire beyond its bytes' own time, there and back, as measured last [µs]
  std::uint32_t jitter_us = 0;       ///< spread of the questions at opening [µs]
};

/// Implemented by the transports that have a wire.
class LinkReporter {
 public:
  virtual ~LinkReporter() = default;
  virtual LinkReport linkReport() const noexcept = 0;  ///< from any thread; each number is whole by itself
  virtual std::string describe() const = 0;            ///< one line: port, boards, highest rate
  /// From any thread: what the wire has to say now, one sentence that names board and remedy; empty: nothing.
  virtual std::string trouble() const { return {}; }
};

}  // namespace haptic
