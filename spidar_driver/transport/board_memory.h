/// Does a board take in what it is told? It names the parameter that it was asked for before (GET_PARAM).
///
/// One that names the parameter before that has not taken in the question between: its table cuts packets
/// short, and it takes in no current either. As the questions alternate, every second answer of such a board
/// is right by chance. One that names 0 has lost its power. Anything else is a disturbed byte.
#pragma once

namespace haptic {

class BoardMemory {
 public:
  enum class Verdict : unsigned char { kFine, kPowerLost, kDisobeys };
  /// Two parameters that every firmware has, asked for in turns, neither the 0 that a board names after
  /// power-on.
  static constexpr int kParams[2] = {1, 5};

  void begin() noexcept {
    asked_ = -1, remembered_ = right_ = stuck_ = 0;
  }  ///< (in realtime) the boards were brought into step
  int next() const { return asked_ == kParams[0] ? 1 : 0; }       ///< index of the parameter to ask for
  bool answers() const { return has_memory_ || lost_ < kTries; }  ///< it may answer such a question
  bool unproven() const {
    return has_memory_ && remembered_ == 0;
  }  ///< it could have shown that it obeys, and has not
  void lose() noexcept {
    ++lost_, asked_ = -1;
  }  ///< (in realtime) no answer: what the board took in is not known

  /// (in realtime) An answer to the question for `param` named the parameter `named`.
  Verdict take(int param, int named) noexcept {
    const int expected = asked_;
    asked_ = param;
    lost_ = 0;
    if (expected < 0) return Verdict::kFine;
    const bool right = named == expected;
    remembered_ += right;
    has_memory_ = has_memory_ || remembered_ > 1;
    right_ = right ? right_ + 1 : 0;
    if (right_ > 1) stuck_ = 0;
    stuck_ += !right && named == param;
    if (!has_memory_ || right || (named != 0 && stuck_ < 2)) return Verdict::kFine;
    return named == 0 ? Verdict::kPowerLost : Verdict::kDisobeys;
  }

 private:
  static constexpr int kTries = 3;
  int asked_ = -1;           ///< parameter that the last answered question was for; -1: unknown
  int remembered_ = 0;       ///< right answers since the boards were brought into step
  int right_ = 0;            ///< right answers in a row
  int stuck_ = 0;            ///< answers that named the parameter before, until two in a row are right
  int lost_ = 0;             ///< questions in a row without an answer
  bool has_memory_ = false;  ///< it has answered as the firmware does
};

}  // namespace haptic
