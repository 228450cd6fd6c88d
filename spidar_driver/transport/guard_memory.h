/// What a driver and its motor guard share: memory made by the driver and mapped by both, and a socket each.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// Bytes that turn all motors off: zero lead and one cycle, on the longest bus (8 boards of 8 motors) some 700; then those
/// that reach boards whose length tables are spoilt, 1.3 kB.
inline constexpr std::size_t kMaxZeroDrive = 4096;

struct GuardMemory {
  std::atomic<std::uint64_t> beats{0};   ///< driver → guard: counts exchanges
  std::atomic<bool> armed{false};        ///< driver → guard: currents other than zero are on
  std::atomic<std::uint64_t> stalls{0};  ///< guard → driver: how often it took the motors over
  std::atomic<std::uint64_t> looks{0};   ///< guard → driver: counts looks at the beats; a guard that does not look guards nobody
  std::int64_t stall_ns = 0;             ///< a heartbeat older than this is a stalled loop
  std::uint32_t zero_drive_bytes = 0;    ///< for boards in step: a driver that only stalled goes on at once
  std::uint32_t zero_any_bytes = 0;      ///< with what follows them in zero_drive, for boards in whatever state
  std::uint8_t zero_drive[kMaxZeroDrive] = {};
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "shared between processes");

/// Descriptors that the guard finds open: the driver's standard error, the motors' port, one end of a pair of sockets of which
/// each end hangs up when the process of the other has ended, and the memory above.
enum GuardDescriptor : int { kGuardWords = 2, kGuardPort = 3, kGuardLife = 4, kGuardMemory = 5 };

/// The guard's first byte on kGuardLife; any other one is the errno of a guard that could not start.
inline constexpr char kGuardReady = 0;

}  // namespace haptic
