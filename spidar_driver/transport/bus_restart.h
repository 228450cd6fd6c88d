/// Brings boards that no longer obey back into step: zero current, silence, lengths, identity, delay.
///
/// A step is bounded in time, so that the real-time thread takes one per exchange; opening a line takes them
/// in a loop.
///   zero      zero currents to whatever id and table (zeroForAnyTable), then 256 zeros, SET_CMDLEN for every
///   board and zero
///             currents; then both once more: a zero may be lost like any other byte, and some board would
///             hold its currents
///   quiet     until nothing has come for longer than any adapter keeps bytes back
///   questions BOARD_INFO, one at a time, each board several times: the right board, and the wire's round
///   trip proof     per board a CURRENT whose last low byte is the header of BOARD_INFO, then a zero one: a
///   board whose table cuts
///             CURRENT short finds that header where it expects one, and answers it. Such a board answers
///             everything and takes in no current; GET_PARAM does not tell
/// About 50 ms and thirteen round trips; 0.5 s at the worst wire that carries a pose at all. A board that
/// does not answer starts it over, with zero currents again.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "spidar_driver/transport/board_bus.h"
#include "spidar_driver/transport/reply_stream.h"

namespace haptic {

class BusRestart {
 public:
  enum class Step : unsigned char { kWorking, kReady, kGone };
  enum class Trouble : unsigned char { kNone, kSilentBoard, kOtherBoard, kNoisy, kForgets };

  /// Set-up. `zero_drive`: bytes that turn all motors off, in a cycle of their own.
  void prepare(const std::vector<FoundBoard>& boards, const std::vector<std::uint8_t>& zero_drive,
               std::int64_t byte_ns);

  void begin() noexcept {
    phase_ = Phase::kZero, sent_ = 0, trouble_ = Trouble::kNone, rest_until_ns_ = 0;
  }  ///< (in realtime)
  /// (in realtime) The same for board `id`, which keeps losing what it is taught: nothing is asked before
  /// that instant.
  void beginAfter(std::int64_t rest_until_ns, int id) noexcept {
    begin();
    rest_until_ns_ = rest_until_ns, trouble_ = Trouble::kForgets, trouble_id_ = id;
  }
  /// (in realtime) Listens until `deadline_ns` at most.
  Step step(ByteLink& link, std::int64_t deadline_ns) noexcept;

  /// Set-up: no force is on, and the kernel may serve a terminal late on a busy machine: answers may take as long as that.
  void bePatient(bool patient) noexcept { patience_ns_ = patient ? kPatient : kUsual; }
  /// Longest time that an answer took while it was patient [ns].
  std::int64_t slowest() const { return slowest_ns_; }
  static constexpr std::int64_t kUsual = 40 * kMs;    ///< for an answer: two bursts of an adapter
  static constexpr std::int64_t kPatient = 500 * kMs; ///< six times the lateness that was seen at a load of ten

  /// Of the wire beyond its bytes' own time [ns]: median and spread of the last questions.
  std::int64_t delay() const { return delay_ns_; }
  std::int64_t jitter() const { return jitter_ns_; }
  bool zeroing() const { return phase_ == Phase::kZero; }  ///< some board may still hold its currents
  Trouble trouble() const { return trouble_; }             ///< what keeps it from being ready
  int troubleBoard() const { return trouble_id_; }         ///< its id

  /// Time on the wire of a question and its reply [ns]: header in the receiver's FIFO, the board's 25 µs, the
  /// reply.
  static std::int64_t questionTime(std::int64_t byte_ns, int reply_bytes = kInfoBytes);

 private:
  enum class Phase : unsigned char { kZero, kQuiet, kAsk, kListen, kProve };
  static constexpr int kRounds = 7;  ///< questions per board; the first, behind zeros, is not timed

  Step zero(ByteLink& link, std::int64_t deadline_ns) noexcept;
  Step quiet(ByteLink& link, std::int64_t deadline_ns) noexcept;
  Step listen(ByteLink& link, std::int64_t deadline_ns) noexcept;
  Step prove(ByteLink& link, std::int64_t deadline_ns) noexcept;
  void take(const std::uint8_t* bytes, int size) noexcept;
  bool hear(ByteLink& link, std::int64_t deadline_ns) noexcept;
  void giveUp(Trouble trouble, int id) noexcept;
  void measure() noexcept;

  std::vector<FoundBoard> boards_;
  std::vector<std::vector<std::uint8_t>> zero_;  ///< messages, each in one write
  std::vector<std::vector<std::uint8_t>> first_question_, question_, proof_;
  ReplyStream stream_;
  Phase phase_ = Phase::kZero;
  Trouble trouble_ = Trouble::kNone;
  int trouble_id_ = -1, sent_ = 0, asked_ = 0, tries_ = 0;
  bool answered_ = false, right_ = false, proof_sent_ = false, rest_sent_ = false;
  int proven_ = 0, currents_ = 0;  ///< boards that have; answers to CURRENT
  std::uint64_t foreign_ = 0;      ///< bytes, before the proof
  std::int64_t byte_ns_ = 5000, since_ns_ = 0, heard_ns_ = 0, rest_until_ns_ = 0, delay_ns_ = 0,
               jitter_ns_ = 0;
  std::int64_t patience_ns_ = kUsual, slowest_ns_ = 0;
  std::array<std::int64_t, kRounds * kMaxBoards> trip_ns_{};
  int trips_ = 0;
};

}  // namespace haptic
