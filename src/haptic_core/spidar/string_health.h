/// Does every string still tell the truth, and is no motor too hot? Judged once per tick.
///
/// Three judges, for three times in which a length can go wrong:
///   within a tick            CountScreen     spikes are refused, slips of an encoder are measured and
///   corrected in 3 ms and more         the residual    lengths that contradict each other: the force is
///   reduced at once in 0.05 s to 0.3 s       SlipDiagnosis   which string it is, from the motion; then no
///   force
/// A string that hangs loose measures too long and does not pull; what grows slowly is therefore never
/// corrected.
#pragma once
#include <cstdint>

#include "haptic_core/spidar/count_screen.h"
#include "haptic_core/spidar/slip_diagnosis.h"
#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// Limits from which strings are doubted and motors count as hot.
struct HealthSettings {
  /// Rms of the length errors that makes a string doubtful [m]: 10 times the encoder's own, twice what hard use brings (boards
  /// that read at different instants). One string shows √((1 - h_ii) / n) of its error, 3 to 25 %, depending on the pose: a
  /// limit twice as high leaves slips of a millimetre unseen. Raise it for a device whose exits were never calibrated (a
  /// millimetre each), else it alarms.
  double residual_limit = 0.05e-3;
  double residual_time_s = 0.003;  ///< for so long before the state changes: a single bad sample is no fault
  double doubt_end_s = 0.2;        ///< without contradiction for so long, the doubt is over
  double decide_s = 0.3;           ///< a doubt that lasts so long ends in a fault, with or without a name
  double break_factor = 40;        ///< residual over limit at which there is no waiting and no force
  int most_corrections = 3;  ///< slips corrected until a calibration; one more is a fault: the errors add up
  /// Two slips of a string within so long are one string that sticks, whose next slip is to come: a fault [s]. Corrected one by one, a
  /// string that sticks until it is a millimetre off is in FAULT after 0.52 s in place of 0.3.
  double sticks_s = 1;
  ScreenSettings screen;        ///< of the first judge
  DiagnosisSettings diagnosis;  ///< of the third
  /// Motors: heat is ((t / t_cont)² low-passed over heat_time_s), 1 = the heat that the winding bears for ever. The
  /// sources state no continuous tension, so it is taken as a share of the greatest.
  double continuous_share = 0.5;
  double heat_time_s = 20;          ///< low-pass of the heat [s]: the winding's time constant
  double hot = 1.0, too_hot = 1.1;  ///< the wrench fades from the first to zero at the second
};

/// How far the strings are believed.
enum class StringVerdict : unsigned char {
  kTrue,
  kDoubtful,  ///< lengths contradict each other: little force
  kNamed,     ///< for so long, or so clearly, that it is known which string it is: no force
  kBroken,    ///< they contradict each other so much that no pose can be trusted
};

/// Judges every string and every motor of a device, once a tick.
class StringHealth {
 public:
  StringHealth(const DeviceDef& def, const HealthSettings& settings);  ///< for a device of this arrangement

  void forget() noexcept;  ///< (in realtime) after a calibration or a recovery
  void forgetMotion() noexcept { screen_.forget(); }  ///< (in realtime) after a gap: the next lengths do not follow the last

  /// (in realtime) Judges the lengths [m] of one reading, `elapsed` [s] after the last, and replaces what
  /// cannot be; `pose` is the last one. A slip that was corrected is in `slip`: the length at count 0 must
  /// follow.
  CountScreen::Verdict screen(StringVector& length, const StringKinematics& kinematics, const GripPose& pose,
                              double elapsed) noexcept;
  double slip() const { return screen_.slip(); }  ///< of `suspect`, measured minus true [m]

  /// (in realtime) Judges the residual of a pose that was solved from `length`; `last` is the pose before.
  StringVerdict judge(const PoseSolution& solution, const StringVector& length,
                      const StringKinematics& kinematics, const GripPose& last, double h) noexcept;

  /// (in realtime) Adds one tick of tensions; returns the share of the wrench that the hottest motor allows.
  double heat(const StringVector& tension, double h) noexcept;

  /// The last lengths contradicted each other: the pose may be wrong, long before it is known which string it is. The force
  /// is limited from this very reading on.
  bool contradicted() const { return residual_time_ > 0; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.residual_time_), visit(s.quiet_time_), visit(s.suspect_error_), visit(s.hottest_), visit(s.suspect_);
    visit(s.hottest_motor_), visit(s.corrections_), visit(s.since_correction_), visit(s.corrected_);
    visit(s.suspects_), visit(s.named_), visit(s.reduced_);
    visit(s.heat_), visit(s.screen_), visit(s.diagnosis_);
  }

  int suspect() const { return suspect_; }                ///< -1: none
  double suspectError() const { return suspect_error_; }  ///< measured minus true length of the suspect [m]
  std::uint32_t suspects() const { return suspects_; }    ///< bit per string that may be the one
  int corrections() const { return corrections_; }        ///< slips corrected since the last calibration
  int hottestMotor() const { return hottest_motor_; }     ///< index of its string

 private:
  void suspect(int string, double error, std::uint32_t among) noexcept;

  HealthSettings settings_;
  int strings_;
  StringVector continuous_, heat_;
  CountScreen screen_;
  SlipDiagnosis diagnosis_;
  double residual_time_ = 0, quiet_time_ = 0, suspect_error_ = 0, hottest_ = 0, since_correction_ = 0;  // [s], [m]
  int suspect_ = -1, hottest_motor_ = 0, corrections_ = 0, corrected_ = -1;
  std::uint32_t suspects_ = 0;
  bool named_ = false, reduced_ = false;  ///< since the doubt began: a string was named, the force was reduced
};

}  // namespace haptic
