/// Do two boards answer for each other's motors?
///
/// Ids that were set the wrong way round, or plugs of two boards that were exchanged: string i's counter is that of the motor of string p(i),
/// the string in the same place on the other board. Each counter tells the truth about a string, of another length per count and
/// another length at the calibration, so the lengths of the exchanged boards follow from what was measured:
///     l_p(i) = L_p(i) + (c_p(i)/c_i) (m_i - L_i),
/// m measured, L at the calibration, c the lengths per count. SlipDiagnosis weighs such lengths against strings that measure wrong. A device
/// whose boards are mirror images of each other measures mirrored motions: they contradict each other once the grip has moved by millimetres.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// Motors of a board by its model: B5M has eight, those with force sensors three, others four.
inline int motorsOf(const std::string& model) { return model == "B5M" ? 8 : !model.empty() && model.back() == 'F' ? 3 : 4; }

/// Bit per string of the two boards that are exchanged; 0: none are.
struct ExchangedBoards {
  std::uint32_t a = 0, b = 0;
};

/// The pairs of boards of a device that may be exchanged.
class BoardExchange {
 public:
  static constexpr int kMostPairs = 6;  ///< of four boards; a device with more is not searched further

  explicit BoardExchange(const DeviceDef& def) : strings_(static_cast<int>(def.strings.size())) {
    for (int i = 0; i < strings_; ++i) per_count_[i] = def.strings[static_cast<std::size_t>(i)].length_per_count;
    length_ = StringVector::Zero(strings_);
    int first_a = 0;
    for (std::size_t a = 0; a < def.boards.size(); first_a += motorsOf(def.boards[a++])) {
      int first_b = first_a + motorsOf(def.boards[a]);
      for (std::size_t b = a + 1; b < def.boards.size(); first_b += motorsOf(def.boards[b++])) {
        const int motors = std::min(motorsOf(def.boards[a]), strings_ - first_b);
        if (def.boards[a] == def.boards[b] && motors > 0 && pairs_ < kMostPairs)
          pair_[pairs_++] = {first_a, first_b, motors};
      }
    }
  }

  int pairs() const noexcept { return pairs_; }
  ExchangedBoards boards(int pair) const noexcept {
    const Pair& p = pair_[pair];
    const std::uint32_t strings = (1u << p.motors) - 1;
    return {strings << p.first_a, strings << p.first_b};
  }

  /// (in realtime) Lengths at the calibration, L [m].
  void calibrate(const StringVector& length) noexcept { length_ = length; }

  /// (in realtime) The lengths of the strings if that pair of boards is exchanged [m].
  StringVector exchanged(int pair, const StringVector& measured) const noexcept {
    StringVector out = measured;
    const auto put = [&](int i, int p) { out[p] = length_[p] + per_count_[p] / per_count_[i] * (measured[i] - length_[i]); };
    for (int m = 0; m < pair_[pair].motors; ++m) {
      const int i = pair_[pair].first_a + m, p = pair_[pair].first_b + m;
      put(i, p), put(p, i);
    }
    return out;
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.length_);
  }

 private:
  struct Pair {
    int first_a = 0, first_b = 0, motors = 0;  ///< strings i and p(i) = first_b + i - first_a
  };
  int strings_, pairs_ = 0;
  Pair pair_[kMostPairs];
  double per_count_[kMaxStrings] = {};  ///< [m]
  StringVector length_;
};

}  // namespace haptic
