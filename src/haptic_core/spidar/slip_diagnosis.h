/// Which string is wrong, when the lengths contradict each other? Evidence gathered over a motion.
///
/// n strings measure dof < n numbers; a wrong length shows along one direction of the n - dof dimensional
/// space of residuals. At one pose two strings may have nearly the same direction there (median 7°, one pose
/// in twenty below 0.6°, in the devices with 8 strings and 6 degrees of freedom), and linearising at the
/// wrong pose turns it: 2 mm turn a grip of 22.5 mm by 0.15 rad. Hence one hypothesis per string, *string j
/// is off by δ_j*, each with a pose of its own, solved with the length corrected by δ_j. At that pose the
/// residual e is small when the hypothesis holds, so that linear is exact: with H = A (AᵀA)⁻¹ Aᵀ and w = 1 -
/// H_jj,
///   δ_j += -e_j / w,    unexplained r_j = |e|² - e_j² / w.
/// A true hypothesis leaves r_j at the encoders' noise and δ_j at one value while the grip moves; a wrong one
/// does not:
///   J_j = mean over the last 0.1 s of  r_j + w (δ_j - mean δ_j)².
/// Strings whose J is within a factor of the least cannot be told apart (yet); with one redundant string the
/// second term alone decides. Cost: n warm solves a tick (8 µs for 8 strings), only while there is doubt.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// How much evidence SlipDiagnosis needs to name a string.
struct DiagnosisSettings {
  double memory_s = 0.1;  ///< time constant of the evidence [s]
  double least_time_s =
      0.05;          ///< evidence younger than this decides nothing: a string needs motion to differ
  double ratio = 9;  ///< J over the least J from which a string is out of the question
  double noise = 1;  ///< J at which a hypothesis is as good as any, in encoder steps squared
};

/// Finds the string whose length is wrong, from evidence over a motion.
class SlipDiagnosis {
 public:
  /// For a device of this arrangement.
  SlipDiagnosis(const DeviceDef& def, const DiagnosisSettings& settings);

  void forget() noexcept;  ///< (in realtime) there is no doubt
  bool open() const { return time_ > 0; }  ///< there is a doubt
  /// (in realtime) One more reading in doubt: lengths as measured [m]. `start`: the pose before the doubt,
  /// for the first.
  void add(const StringVector& length, const StringKinematics& kinematics, const GripPose& start,
           double elapsed) noexcept;

  int best() const { return best_; }  ///< -1: no doubt
  double offset(int string) const {
    return belief_[string].offset;
  }                                                         ///< its length as measured minus as it is [m]
  std::uint32_t candidates() const { return candidates_; }  ///< bit per string that may be the one
  bool clear() const;                                       ///< one candidate is left, on enough evidence
  double time() const { return time_; }                     ///< since the doubt began [s]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.time_), visit(s.evidence_), visit(s.best_), visit(s.candidates_);
    for (int j = 0; j < s.strings_; ++j) visit(s.belief_[j]);
  }

 private:
  struct Belief {
    GripPose pose;
    double offset = 0;                                        ///< δ_j [m]
    double unexplained = 0, weight = 0, sum = 0, square = 0;  ///< filtered r, w, w δ, w δ²
    template <class Self, class Visit>
    static void eachField(Self& s, Visit&& visit) {
      visit(s.pose), visit(s.offset), visit(s.unexplained), visit(s.weight), visit(s.sum), visit(s.square);
    }
    double cost() const { return unexplained + (weight > 0 ? square - sum * sum / weight : 0); }
  };
  void rank() noexcept;

  DiagnosisSettings settings_;
  int strings_;
  double step_ = 0;
  std::array<Belief, kMaxStrings> belief_;
  double time_ = 0, evidence_ = 0;  ///< evidence_: filtered 1
  int best_ = -1;
  std::uint32_t candidates_ = 0;
};

}  // namespace haptic
