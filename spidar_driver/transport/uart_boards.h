/// The motor boards on the UART bus as a device's wire: one CURRENT cycle per exchange.
///
/// exchange, as sent:   for each board  CURRENT(digits) + padding      (the padding is the reply's time slot)
///           received:  for each board  position[n] velocity[n] force[f], from before this command
///           at times:  BOARD_INFO behind the cycle, the mark of answer_ledger.h
///
/// Wire time of a cycle at 2 Mbaud: 5 µs per byte sent; one B5M 61 bytes, 305 µs, 3.28 kHz; two B3M 74 bytes,
/// 370 µs, 2.70 kHz; the device file may state less. A higher rate is refused at set-up; exchanges that come
/// sooner wait for their slot.
/// Deviation from the reference host: BOARD_INFO comes behind some cycles, not each (it only woke a Windows driver).
///
/// An answer is stamped with the instant its question went over the wire, however late it comes: a slow wire shows as age.
/// Failure modes, all bounded in time: a lost or unsound answer leaves the last counts, growing older; when those of any
/// board would become older than `silent_after_s` the drive of all boards is zero, since the rest of the strings would pull
/// the grip away, and the boards are brought back into step (bus_restart.h), one step per exchange; so they are when they
/// lose half of the commands or say that they started anew. A port that is gone is reported at once and opened again by
/// another thread. Every loop here is bounded.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/answer_ledger.h"
#include "spidar_driver/transport/board_bus.h"
#include "spidar_driver/transport/board_memory.h"
#include "spidar_driver/transport/bus_restart.h"
#include "spidar_driver/transport/count_unwrapper.h"
#include "spidar_driver/transport/line_recovery.h"
#include "spidar_driver/transport/link_story.h"
#include "spidar_driver/transport/reply_stream.h"
#include "spidar_driver/transport/uart_settings.h"

namespace haptic {

class UartBoards : public Transport, public LinkReporter {
 public:
  using OpenLink = haptic::OpenLink;

  /// Opens the line, finds and matches the boards, turns their drive off, measures the wire. `where` names the port in
  /// messages. Throws SetupError: line, boards or rate do not fit.
  UartBoards(const DeviceDef& device, const UartSettings& settings, const std::string& where, OpenLink open);
  ~UartBoards() override;  ///< zero currents, then closes

  DeviceSample exchange(const DriveCommand& command) noexcept override;
  /// From exchange's thread, or when that has ended.
  void zeroDrive() noexcept override;
  double maxRateHz() const override { return max_rate_hz_; }

  LinkReport linkReport() const noexcept override { return story_.report(); }
  std::string describe() const override;
  std::string trouble() const override { return story_.trouble(); }
  const std::vector<FoundBoard>& boards() const { return boards_; }
  double cycleSeconds() const { return static_cast<double>(cycle_ns_) * 1e-9; }

 private:
  using Cause = LinkStory::Cause;
  /// Whether the line goes on after a step of the exchange.
  enum class Line : unsigned char { kFine, kGone };
  /// What is known of one board.
  struct BoardState {
    std::uint64_t exchange = 0; ///< whose question its counts answer
    std::int64_t stamp_ns = 0;  ///< latch of its counts
    bool fresh = false;         ///< new since the last sample that had new counts of all
    double lost = 0;            ///< share of the last questions without an answer
    BoardMemory memory;         ///< whether it takes in what it is told
  };

  void layOutCycle();
  void awaitBoards();
  void adoptConnection() noexcept;
  void disconnect() noexcept;
  void restart(Cause cause) noexcept;
  void endProbation(std::int64_t now_ns) noexcept;
  Line stepRestart(std::int64_t patience_ns) noexcept;
  void waitForWire() noexcept;
  bool markDue() const noexcept;
  bool expired(std::int64_t at_ns) const noexcept;
  std::int64_t patience(const BoardState& board) const noexcept;
  Line send(const DriveCommand& command) noexcept;
  void encodeCycle(const DriveCommand& command, bool usable) noexcept;
  Line drain() noexcept;
  Line collect() noexcept;
  int hear(std::int64_t deadline_ns) noexcept;
  void takeReply(const std::uint8_t* bytes, int size) noexcept;
  void takeAnswer(int board, const std::uint8_t* bytes, int size) noexcept;
  void takeMark(int board, const std::uint8_t* bytes, int size) noexcept;
  void dropMark() noexcept;
  const std::vector<std::uint8_t>& chooseMark() noexcept;
  bool takePositions(int board, const std::uint8_t* bytes, int size, std::int64_t stamp_ns) noexcept;
  void judge() noexcept;
  bool allFresh() const noexcept;
  DeviceSample sample() noexcept;
  int boardOf(int id) const noexcept;

  const DeviceDef device_;
  const UartSettings settings_;
  const std::string where_;
  LinkStory story_;        // outlives recovery_, which tells it what it meets
  LineRecovery recovery_;
  std::vector<FoundBoard> boards_;
  std::vector<std::uint8_t> zero_cycle_, lesson_, cycle_;
  std::array<std::vector<std::uint8_t>, kMaxBoards> mark_;  ///< bytes of the mark BOARD_INFO, per board
  std::array<std::array<std::vector<std::uint8_t>, 2>, kMaxBoards> memory_mark_;  ///< and of GET_PARAM, in turns
  std::array<int, kMaxBoards> cycle_offset_{}, first_channel_{};
  std::size_t cycle_bytes_ = 0;  ///< without the mark
  std::int64_t byte_ns_ = 0, cycle_ns_ = 0, slot_ns_ = 0, wait_ns_ = 0, period_ns_ = 0, silent_ns_ = 0, mark_wire_ns_ = 0;
  double max_rate_hz_ = 0;

  // State of the exchange, of its thread alone.
  std::unique_ptr<Connection> connection_;
  BusRestart restart_;
  bool restarting_ = false, armed_ = false, counters_restarted_ = false;
  Cause pending_ = Cause::kNone;  ///< found while hearing; acted upon at the end of the exchange
  ReplyStream stream_;
  AnswerLedger ledger_;
  std::array<BoardState, kMaxBoards> board_{};
  std::array<CountUnwrapper, kMaxStrings> counter_;
  std::int64_t sent_ns_ = 0, wire_free_ns_ = 0, heard_ns_ = 0, looked_ns_ = 0, last_mark_ns_ = 0, last_lesson_ns_ = 0;  // asked or answered
  std::int64_t delay_ns_ = 0, fastest_ns_ = 0;  ///< of the wire beyond its bytes' own time: mean, and what it can do at best
  std::int64_t ready_ns_ = 0;  ///< since when the boards are in step
  std::int64_t last_pull_ns_ = 0;  ///< a string was told more than its least tension; 0: not since the last restart
  int relapses_ = 0;           ///< restarts in a row, each soon after the one before
  std::uint64_t exchanges_ = 0, foreign_seen_ = 0;
  int lost_now_ = 0, next_mark_ = 0;
  int mark_param_ = -1;        ///< parameter that the mark on its way asks for; -1: it is BOARD_INFO
  int mark_reply_bytes_ = kInfoBytes;
  bool waited_ = false;  ///< the last read waited: what it brought came just now
};

}  // namespace haptic
