/// Does every string still tell the truth, and is no motor too hot? Judged once per tick.
///
/// n strings measure dof < n numbers, so a wrong length contradicts the others. If string i alone is wrong by
/// δ, the residual of the least-squares pose is e = -(1 - H)_{·i} δ with H = A (AᵀA)⁻¹ Aᵀ; hence δ_i = -e_i /
/// (1 - h_ii), and the string whose single error explains most of |e|², e_i² / (1 - h_ii), is the suspect.
/// Where two strings are redundant in the same direction the data cannot tell them apart; the verdict then
/// names one of the two.
#pragma once
#include <vector>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

struct HealthSettings {
  /// Rms of the length errors that makes a string doubtful [m]: 20 times the encoder's own. One string shows
  /// √((1 - h_ii) / n) of its error, 3 to 25 %, depending on the pose. Raise it for a device whose exits were
  /// never calibrated (a millimetre each), else it alarms.
  double residual_limit = 0.1e-3;
  double residual_time_s = 0.003;  ///< for so long before it counts: a single bad sample is no fault
  double break_factor = 20;        ///< residual over limit at which there is no waiting and no force
  double max_string_speed = 10;    ///< [m/s]; a hand reaches 3, an electrical fault moves faster
  /// Motors: heat is ((t / t_cont)² low-passed over heat_time_s), 1 = what the winding bears for ever. The
  /// sources state no continuous tension, so it is taken as a share of the greatest.
  double continuous_share = 0.5;
  double heat_time_s = 20;
  double hot = 1.0, too_hot = 1.1;  ///< the wrench fades from the first to zero at the second
};

enum class StringVerdict : unsigned char { kTrue, kDoubtful, kBroken };

class StringHealth {
 public:
  StringHealth(const DeviceDef& def, const HealthSettings& settings);

  void forget() noexcept;  ///< (in realtime) after a calibration or a recovery

  /// (in realtime) Compares counts with those of the tick before. Returns the string that moved faster than a
  /// string can, or -1; a wrapped or corrupted counter does that.
  int findJump(const std::array<std::int64_t, kMaxStrings>& counts, double elapsed) noexcept;

  /// (in realtime) Judges the residual of a pose.
  StringVerdict judge(const PoseSolution& solution, const StringKinematics& kinematics, double h) noexcept;

  /// (in realtime) Adds one tick of tensions; returns the share of the wrench that the hottest motor allows.
  double heat(const StringVector& tension, double h) noexcept;

  /// Memory, for Spidar::save and restore: appends to `out`; reads from `in` and returns what follows.
  void save(std::vector<double>& out) const;
  const double* restore(const double* in) noexcept;

  int suspect() const { return suspect_; }                ///< -1: none
  double suspectError() const { return suspect_error_; }  ///< measured minus true length of the suspect [m]
  double hottest() const { return hottest_; }             ///< 1 = for ever
  int hottestMotor() const { return hottest_motor_; }

 private:
  void findSuspect(const PoseSolution& solution, const StringKinematics& kinematics) noexcept;

  HealthSettings settings_;
  int strings_;
  StringVector step_, continuous_, heat_;
  std::array<std::int64_t, kMaxStrings> last_counts_{};
  bool have_counts_ = false;
  double residual_time_ = 0, suspect_error_ = 0, hottest_ = 0;
  int suspect_ = -1, hottest_motor_ = 0;
};

}  // namespace haptic
