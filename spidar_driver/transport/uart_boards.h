/// The motor boards on the UART bus as a device's wire: one CURRENT cycle per exchange.
///
/// exchange, as sent:   for each board  CURRENT(digits) + padding      (the padding is the reply's time slot)
///           received:  for each board  position[n] velocity[n] force[f], from before this command
///
/// Wire time of a cycle at 2 Mbaud: 5 µs per byte sent; one B5M 61 bytes, 305 µs, 3.28 kHz; two B3M 74 bytes,
/// 370 µs, 2.70 kHz; the device file may state less. A higher rate is refused at set-up; exchanges that come
/// sooner wait for their slot.
/// Deviation from the reference host: no BOARD_INFO behind each cycle (it only woke a Windows driver).
///
/// Failure modes, all bounded in time: a lost or unsound answer leaves the last counts with age > 0; a board
/// that is silent for `silent_after` exchanges zeroes the drive of all boards, since the rest of the strings
/// would pull the grip away; a port that is gone is reported at once and opened again by another thread.
#pragma once
#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/board_bus.h"
#include "spidar_driver/transport/count_unwrapper.h"
#include "spidar_driver/transport/drive_guard.h"
#include "spidar_driver/transport/link_report.h"
#include "spidar_driver/transport/reply_collector.h"

namespace haptic {

struct UartSettings {
  double rate_hz = 1000;         ///< at which exchange will be called; more than the wire carries is refused
  int baud = 2000000;            ///< of the port; sets the wire time
  double reply_wait_s = 0;       ///< longest wait for answers [s]; 0: 80 % of the period, at least the cycle
  double max_string_speed = 20;  ///< a count that needs more is refused [m/s]; a hand reaches 5
  int silent_after = 20;         ///< exchanges without an answer: 20 ms at 1 kHz, then the drive goes to zero
  double reopen_s = 0.25;        ///< pause between attempts to open a lost port [s]
  bool guard = true;             ///< zero currents by a second process when this one dies or stalls
};

class UartBoards : public Transport, public LinkReporter {
 public:
  using OpenLink = std::function<std::unique_ptr<ByteLink>()>;  ///< throws SetupError

  /// Opens the line, finds and matches the boards, turns their drive off. `where` names the port in messages.
  /// Throws SetupError: line, boards or rate do not fit.
  UartBoards(const DeviceDef& device, const UartSettings& settings, const std::string& where, OpenLink open);
  ~UartBoards() override;  ///< zero currents, then closes

  DeviceSample exchange(const DriveCommand& command) noexcept override;
  /// From exchange's thread, or when that has ended.
  void zeroDrive() noexcept override;
  double maxRateHz() const override { return max_rate_hz_; }

  LinkReport linkReport() const noexcept override;
  std::string describe() const override;
  const std::vector<FoundBoard>& boards() const { return boards_; }
  double cycleSeconds() const { return static_cast<double>(cycle_ns_) * 1e-9; }

 private:
  struct Connection {
    std::unique_ptr<ByteLink> link;
    std::unique_ptr<DriveGuard> guard;
  };
  enum Counter {
    kCycles,
    kLost,
    kLate,
    kUnsound,
    kForeign,
    kRefused,
    kRestarts,
    kReconnects,
    kOverRate,
    kBadCommands,
    kClamped,
    kCounters
  };

  std::unique_ptr<Connection> connect(std::unique_ptr<ByteLink> link);
  void layOutCycle();
  void adoptConnection() noexcept;
  void disconnect() noexcept;
  bool drain() noexcept;
  void waitForWire() noexcept;
  bool send(const DriveCommand& command) noexcept;
  bool collect() noexcept;
  void takeReplies(bool late) noexcept;
  bool takePositions(int board, const std::uint8_t* reply, int size) noexcept;
  DeviceSample sample() noexcept;
  bool silent() const noexcept;
  void count(Counter c, std::uint64_t n = 1) noexcept {
    counters_[c].fetch_add(n, std::memory_order_relaxed);
  }
  void recover();

  const DeviceDef device_;
  const UartSettings settings_;
  const std::string where_;
  const OpenLink open_;
  std::vector<FoundBoard> boards_;
  std::vector<std::uint8_t> zero_cycle_, lesson_, cycle_;
  std::array<int, kMaxBoards> cycle_offset_{}, first_channel_{};
  std::int64_t byte_ns_ = 0, cycle_ns_ = 0, slot_ns_ = 0, latch_ns_ = 0, wait_ns_ = 0;
  double max_rate_hz_ = 0;

  // State of the exchange, of its thread alone.
  std::unique_ptr<Connection> connection_;
  ReplyCollector collector_;
  std::array<CountUnwrapper, kMaxStrings> counter_;
  std::array<std::uint32_t, kMaxBoards> age_{};
  std::array<bool, kMaxBoards> owes_{};
  bool judged_ = true;  ///< the last cycle's replies were taken or dropped
  bool armed_ = false;
  std::int64_t sent_ns_ = 0, wire_free_ns_ = 0, stamp_ns_ = 0;
  std::uint64_t exchanges_ = 0, last_lesson_ = 0;
  bool lesson_due_ = false;

  // Shared with the recovery thread.
  std::array<std::atomic<std::uint64_t>, kCounters> counters_{};
  std::atomic<std::uint32_t> silent_boards_{0};
  std::atomic<Connection*> outgoing_{nullptr}, incoming_{nullptr};
  std::mutex stop_mutex_;
  std::condition_variable stop_signal_;
  bool stop_ = false;
  std::thread recovery_;
};

}  // namespace haptic
