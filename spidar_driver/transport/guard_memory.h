/// What a driver and its motor guard share: one page, made by the driver, mapped by both.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// Bytes that turn all motors off: zero lead and one cycle. The longest bus (8 boards of 8 motors) needs some
/// 700.
inline constexpr std::size_t kMaxZeroDrive = 2048;

struct GuardMemory {
  std::atomic<std::uint64_t> beats{0};   ///< driver → guard: counts exchanges
  std::atomic<bool> armed{false};        ///< driver → guard: currents other than zero are on
  std::atomic<std::uint64_t> stalls{0};  ///< guard → driver: how often it took the motors over
  std::int64_t stall_ns = 0;             ///< a heartbeat older than this is a stalled loop
  std::uint32_t zero_drive_bytes = 0;
  std::uint8_t zero_drive[kMaxZeroDrive] = {};
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "shared between processes");

/// Descriptors that the guard finds open: the motors' port, a pipe that hangs up when the driver ends, the
/// memory above, and a pipe that says `kGuardReady` and hangs up when the guard ends.
enum GuardDescriptor : int { kGuardPort = 3, kGuardLife = 4, kGuardMemory = 5, kGuardDone = 6 };

/// First byte on kGuardDone; any other one is the errno of a guard that could not start.
inline constexpr char kGuardReady = 0;

}  // namespace haptic
