/// The wire of a device: drive commands out, encoder counts in, one transaction per tick.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/spidar/device_def.h"

namespace haptic {

struct DriveCommand {
  std::array<double, kMaxStrings> voltage{};  ///< [V] per channel, sign included; 0 = no current
};

enum class LinkStatus : std::uint8_t { kOk, kStale, kSilent, kDisconnected };

/// What one exchange brought. `counts` are unwrapped; boards answer before they execute, so they belong to the
/// instant `stamp_ns` and the tensions of the command before.
struct DeviceSample {
  std::array<std::int64_t, kMaxStrings> counts{};
  std::int64_t stamp_ns = 0;      ///< steady clock at the latch
  std::uint32_t age_ticks = 0;    ///< 0: fresh; n: the counts are those of n exchanges ago
  std::uint32_t buttons = 0;      ///< bit per grip button
  LinkStatus status = LinkStatus::kOk;
};

/// Implemented by the twin (core), the UART boards and the USB amplifiers (spidar_driver).
class Transport {
 public:
  virtual ~Transport() = default;
  /// (in realtime: no heap, no lock; I/O is the transport's own) Hands over `command`, returns the counts.
  /// Never throws; a lost answer is a sample with age > 0 and the last counts.
  virtual DeviceSample exchange(const DriveCommand& command) noexcept = 0;
  virtual void zeroDrive() noexcept = 0;   ///< all currents to zero, at once; called on every way out
  virtual double maxRateHz() const = 0;    ///< highest rate the wire carries [Hz]
};

}  // namespace haptic
