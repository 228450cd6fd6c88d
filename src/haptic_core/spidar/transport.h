/// The wire of a device: drive commands out, encoder counts in, one transaction per tick.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// Motor voltages until the next exchange.
struct DriveCommand {
  std::array<double, kMaxStrings> voltage{};  ///< [V] per channel, sign included; 0 = no current
};

/// What became of an exchange.
enum class LinkStatus : std::uint8_t {
  kOk,            ///< new counts of every board
  kStale,         ///< not of every board; the others' are the last ones
  kSilent,        ///< a board is silent, or being taught anew: currents are zero
  kDisconnected,  ///< the line is gone
  kRestarted,     ///< a counter started anew: the strings' lengths are lost
  kUnguarded,     ///< new counts, but no second process could turn the motors off if this one ended: currents are zero
};

/// New counts of every board came.
inline bool bringsCounts(LinkStatus status) { return status == LinkStatus::kOk || status == LinkStatus::kUnguarded; }

/// A wire's finding about its boards, from the tick that finds it until they are in step again.
enum class WireFinding : std::uint8_t {
  kNone,
  kStalled,          ///< no board's fault: this program stood still
  kSilent,           ///< a board does not answer
  kRestarted,        ///< its counters started anew
  kPowerLost,        ///< it lost its power
  kOtherBoard,       ///< another model answers
  kTableSpoilt,      ///< it cuts its packets short
  kWrongMode,        ///< it is not in the mode in which it follows currents
  kCurrentsIgnored,  ///< the currents that it measures are not those that it was told
  kForgets,          ///< it keeps nothing that it is taught
  kAnswersLost,      ///< it loses one command in five
  kNoise,            ///< bytes come without end
  kOldCounts,        ///< its answers bring counts of cycles ago
  kCountsWild,       ///< it answers with counts that no motor can have made
};

/// What one exchange brought. `counts` are unwrapped; boards answer before they execute, so they belong to the
/// instant `stamp_ns` and the tensions of the command before.
struct DeviceSample {
  std::array<std::int64_t, kMaxStrings> counts{};  ///< by string, as wide as they ever get
  std::int64_t stamp_ns = 0;      ///< steady clock at the latch of the oldest counts; 0: as the exchange began (simulated)
  std::uint32_t age_ticks = 0;    ///< the oldest counts answer the question of so many exchanges ago; 0: of this one
  std::uint32_t age_us = 0;       ///< from that latch to the end of this exchange [µs]
  std::uint16_t lost = 0;         ///< exchanges that, as this one found, stay without an answer of some board
  std::uint32_t buttons = 0;      ///< bit per grip button
  LinkStatus status = LinkStatus::kOk;  ///< of all boards together
  WireFinding finding = WireFinding::kNone;  ///< why the boards are being brought into step, or the finding of this exchange
  std::int8_t board = -1;         ///< id of the board that the finding is about; for sentences alone, not recorded

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.counts), visit(s.stamp_ns), visit(s.age_ticks), visit(s.age_us), visit(s.lost), visit(s.buttons), visit(s.status);
    visit(s.finding), visit(s.board);
  }
};

/// Status and finding of a sample in one byte, as recordings keep them; those of before have no finding.
inline std::uint8_t linkByte(const DeviceSample& sample) noexcept {
  return static_cast<std::uint8_t>(static_cast<unsigned>(sample.status) | static_cast<unsigned>(sample.finding) << 4);
}
/// Status and finding out of such a byte.
inline void takeLinkByte(std::uint8_t byte, DeviceSample& sample) noexcept {
  sample.status = static_cast<LinkStatus>(byte & 0xF);
  sample.finding = static_cast<WireFinding>(byte >> 4);
}

/// The wire of a device: drive commands out, encoder counts in.
/// Implemented by the twin (core), the UART boards and the USB amplifiers (spidar_driver).
class Transport {
 public:
  virtual ~Transport() = default;
  /// (in realtime: no heap, no lock; I/O is the transport's own) Hands over `command`, returns the counts.
  /// Never throws; without an answer the sample has the last counts, their age, and a status other than kOk.
  virtual DeviceSample exchange(const DriveCommand& command) noexcept = 0;
  virtual void zeroDrive() noexcept = 0;   ///< all currents to zero, at once; called on every way out
  virtual double maxRateHz() const = 0;    ///< highest rate the wire carries [Hz]
  /// (in realtime) Where the grip truly was at the last latch, for measurements of errors; null: hardware, unknown.
  virtual const Pose* truth() const noexcept { return nullptr; }
};

}  // namespace haptic
