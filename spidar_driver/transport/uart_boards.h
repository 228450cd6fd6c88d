/// The motor boards on the UART bus as a device's wire: one CURRENT cycle per exchange.
///
/// exchange, as sent:   for each board  CURRENT(digits) + padding      (the padding is the reply's time slot)
///           received:  for each board  position[n] velocity[n] force[f], from before this command
///           at times:  BOARD_INFO behind the cycle, the mark of answer_ledger.h
///
/// Wire time of a cycle at 2 Mbaud: 5 µs per byte sent; one B5M 61 bytes, 305 µs, 3.28 kHz; two B3M 74 bytes,
/// 370 µs, 2.70 kHz; the device file may state less. A higher rate is refused at set-up; exchanges that come
/// sooner wait for their slot.
/// Deviation from the reference host: BOARD_INFO comes behind some cycles, not each (it only woke a Windows
/// driver).
///
/// Layout and bytes: board_cycle.h. What answers mean: board_answers.h. Here is the flow of an exchange, and
/// when the boards are brought back into step. Failure modes, all bounded in time: a lost or unsound answer
/// leaves the last counts, growing older; when those of any board would become older than `silent_after_s`
/// the drive of all boards is zero, since the rest of the strings would pull the grip away, and the boards
/// are brought back into step (bus_restart.h), one step per exchange; so they are when they lose half of the
/// commands or say that they started anew. A port that is gone is reported at once and opened again by
/// another thread. Every loop here is bounded.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/board_answers.h"
#include "spidar_driver/transport/board_cycle.h"
#include "spidar_driver/transport/bus_restart.h"
#include "spidar_driver/transport/line_recovery.h"
#include "spidar_driver/transport/link_story.h"
#include "spidar_driver/transport/uart_settings.h"

namespace haptic {

class UartBoards : public Transport, public LinkReporter {
 public:
  using OpenLink = haptic::OpenLink;

  /// Opens the line, finds and matches the boards, turns their drive off, measures the wire. `where` names
  /// the port in messages. Throws SetupError: line, boards or rate do not fit.
  UartBoards(const DeviceDef& device, const UartSettings& settings, const std::string& where, OpenLink open);
  ~UartBoards() override;  ///< zero currents, then closes

  DeviceSample exchange(const DriveCommand& command) noexcept override;
  /// From exchange's thread, or when that has ended.
  void zeroDrive() noexcept override;
  double maxRateHz() const override { return cycle_->max_rate_hz; }

  LinkReport linkReport() const noexcept override { return story_.report(); }
  std::string describe() const override;
  std::string trouble() const override { return story_.trouble(); }
  const std::vector<FoundBoard>& boards() const { return cycle_->boards(); }
  double cycleSeconds() const { return static_cast<double>(cycle_->cycle_ns) * 1e-9; }

 private:
  using Cause = WireFinding;
  /// Whether the line goes on after a step of the exchange.
  enum class Line : unsigned char { kFine, kGone };

  void awaitBoards();
  void adoptConnection() noexcept;
  void disconnect() noexcept;
  void noteStall(std::int64_t now_ns) noexcept;
  void checkGuard(std::int64_t now_ns) noexcept;
  void restart(Cause cause) noexcept;
  void endProbation(std::int64_t now_ns) noexcept;
  Line stepRestart(std::int64_t patience_ns) noexcept;
  void waitForWire() noexcept;
  Line send(const DriveCommand& command) noexcept;
  Line teach() noexcept;
  WireFinding finding() const noexcept;
  void judge() noexcept;
  DeviceSample sample() noexcept;

  const DeviceDef device_;
  const UartSettings settings_;
  const std::string where_;
  LinkStory story_;  // outlives recovery_, which tells it what it meets
  LineRecovery recovery_;
  std::optional<BoardCycle> cycle_;  ///< set-up: as the boards that were found need it
  std::optional<BoardAnswers> answers_;

  // State of the exchange, of its thread alone.
  std::unique_ptr<Connection> connection_;
  BusRestart restart_;
  bool restarting_ = false, armed_ = false;
  bool guarded_ = true;    ///< somebody would turn the motors off if this process ended
  bool guard_wanted_ = false;  ///< another guard has been asked for
  std::int64_t last_exchange_ns_ = 0;
  Cause restart_cause_ = Cause::kNone;
  bool may_hold_ = false;  ///< currents were on when the restart began
  std::int64_t opening_late_ns_ = 0;  ///< longest time that an answer took while the line was opened
  std::int64_t sent_ns_ = 0, wire_free_ns_ = 0;
  std::int64_t ready_ns_ = 0;  ///< since when the boards are in step
  std::int64_t last_pull_ns_ =
      0;              ///< a string was told more than its least tension; 0: not since the last restart
  int relapses_ = 0;  ///< restarts in a row, each soon after the one before
  std::uint64_t exchanges_ = 0;
};

}  // namespace haptic
