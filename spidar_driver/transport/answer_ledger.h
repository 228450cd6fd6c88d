/// Which question does an answer belong to? Answers carry no number.
///
/// Each board answers its questions in their order, so an answer belongs to the oldest question that is owed one; what is
/// owed is remembered until it is answered or proven lost. A lost answer makes the later ones look older than they are,
/// never fresher. The proof comes from marks: a mark is a question of another kind that is asked behind the commands of a
/// cycle, one at a time, and its answer comes behind all that the boards said before. What is owed from before it is lost;
/// what was answered from after it was a doubled answer, and the credit is taken back.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "spidar_driver/transport/board_model.h"

namespace haptic {

class AnswerLedger {
 public:
  static constexpr std::uint64_t kDepth = 256;  ///< questions on their way: 85 ms at 3 kHz, far beyond the silence limit

  struct Credit {
    bool owed = false;        ///< false: nobody asked; a doubled answer
    std::int64_t sent_ns = 0;
    std::uint64_t exchange = 0;  ///< in which it was asked
  };

  void begin(int boards) noexcept {  ///< (in realtime) forgets all
    boards_ = boards;
    next_.fill(asked_);
    settled_ = asked_;
    marked_ = false;
  }
  /// (in realtime) A cycle of questions goes out, one per board. False: too many are owed.
  bool ask(std::int64_t sent_ns, std::uint64_t exchange) noexcept {
    if (owed() >= static_cast<int>(kDepth)) return false;
    sent_[asked_ % kDepth] = sent_ns;
    exchange_[asked_++ % kDepth] = exchange;
    return true;
  }
  void mark(int board, std::int64_t sent_ns) noexcept {  ///< (in realtime) and a mark behind it
    marked_ = true;
    mark_board_ = board;
    mark_ns_ = sent_ns;
    mark_cycle_ = asked_;
  }

  Credit answer(int board) noexcept {  ///< (in realtime)
    const Credit credit = oldest(board);
    next_[board] += credit.owed;
    return credit;
  }
  /// (in realtime) The oldest question that `board` owes an answer to; not owed: none.
  Credit oldest(int board) const noexcept {
    if (next_[board] == asked_) return {};
    return {true, sent_[next_[board] % kDepth], exchange_[next_[board] % kDepth]};
  }

  struct Settled {
    std::array<int, kMaxBoards> lost{};  ///< answers that will never come, per board
    int doubled = 0;                     ///< answers that were credited to a question not yet answered
    std::uint64_t cycles = 0;            ///< since the mark before
  };
  /// (in realtime) The mark was answered: all from before it is settled.
  Settled settle() noexcept {
    Settled s;
    for (int b = 0; b < boards_; ++b) {
      if (next_[b] > mark_cycle_) s.doubled += static_cast<int>(next_[b] - mark_cycle_);
      if (next_[b] < mark_cycle_) s.lost[b] = static_cast<int>(mark_cycle_ - next_[b]);
      next_[b] = mark_cycle_;
    }
    s.cycles = mark_cycle_ - settled_;
    settled_ = mark_cycle_;
    marked_ = false;
    return s;
  }
  /// Every board has answered what was asked so long after the mark that the mark's own answer must be lost.
  bool overtaken() const noexcept {
    constexpr std::uint64_t kLater = 5;  // cycles; doubled answers run ahead by one or two
    for (int b = 0; b < boards_; ++b)
      if (next_[b] < mark_cycle_ + kLater) return false;
    return marked_;
  }
  void dropMark() noexcept { marked_ = false; }  ///< (in realtime) its answer is lost
  bool marked() const { return marked_; }
  int markBoard() const { return mark_board_; }
  std::int64_t markSent() const { return mark_ns_; }

  int owed() const {  ///< answers, of the board that owes most
    std::uint64_t oldest = asked_;
    for (int b = 0; b < boards_; ++b) oldest = std::min(oldest, next_[b]);
    return static_cast<int>(asked_ - oldest);
  }

 private:
  int boards_ = 0, mark_board_ = 0;
  std::uint64_t asked_ = 0, mark_cycle_ = 0, settled_ = 0;
  std::array<std::uint64_t, kMaxBoards> next_{};  ///< per board: the cycle whose answer comes next
  std::array<std::int64_t, kDepth> sent_{};
  std::array<std::uint64_t, kDepth> exchange_{};
  std::int64_t mark_ns_ = 0;
  bool marked_ = false;
};

}  // namespace haptic
