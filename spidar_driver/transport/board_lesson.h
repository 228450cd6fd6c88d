/// Does a board keep the lengths that it is taught? Two lessons take turns, and a board shows which one it has.
///
/// A length table that is spoilt may cut CURRENT short: such a board answers every question, looks sound and takes in no current.
/// So the lesson, SET_CMDLEN for every board, goes out every kEveryNs, in the idle time of the wire when all answers are here: a
/// table is wrong for no longer than that, whichever of its bytes is wrong. What remains is a board that cannot be taught, because
/// its table cuts SET_CMDLEN short as well. The two lessons differ in the length of BOARD_INFO, 1 or kLongInfoBytes, and the question
/// behind a lesson asks twice, the second time within the longer length (`lessonQuestion`): a board that was taught 1 answers twice,
/// else once. One that answers both lessons alike has not taken one of them in. A board that never told them apart (another firmware)
/// proves nothing and is not accused. An answer may be lost: two contradictions in a row count.
///
/// No current is changed for it, so it is not felt. It replaces a question that was hidden in a current, up to 1.2 N of force on the hand.
#pragma once
#include <cstdint>

#include "spidar_driver/transport/board_bus.h"

namespace haptic {

class BoardLesson {
 public:
  enum Kind : unsigned char { kShort, kLong };
  static constexpr int kInfoBytes[2] = {1, kLongInfoBytes};  ///< length of BOARD_INFO that a lesson teaches
  /// Longest time for which a table may be spoilt, less an exchange or two [ns]. A lesson takes 90 us of wire for a B5M, 180 us for B3M,
  /// half a percent where the cycles leave no idle time.
  static constexpr std::int64_t kEveryNs = 25000000;

  void begin() noexcept { *this = BoardLesson(); }  ///< (in realtime) the boards were brought into step

  /// (in realtime) So many answers came to the question behind that lesson. False: it does not keep what it is taught.
  bool take(Kind kind, int answers) noexcept {
    if (seen_ && kind != kind_) {
      const bool alike = answers == answers_;
      alike_ = alike ? alike_ + 1 : 0;
      apart_ = alike ? 0 : apart_ + 1;
      tells_ = tells_ || apart_ >= kKnown;
    }
    seen_ = true;
    kind_ = kind;
    answers_ = answers;
    return !(tells_ && alike_ >= kContradictions);
  }
  bool doubtful() const { return tells_ && alike_ > 0; }  ///< it is asked again before other boards are

 private:
  static constexpr int kContradictions = 2, kKnown = 3;
  Kind kind_ = kShort;
  bool seen_ = false, tells_ = false;
  int answers_ = 0, alike_ = 0, apart_ = 0;
};

}  // namespace haptic
