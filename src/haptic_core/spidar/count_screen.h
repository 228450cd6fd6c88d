/// Judges new counts: are they a motion, a misread number, or an encoder that slipped?
///
/// A grip has mass: from one tick to the next its strings follow the motion of before, up to an acceleration.
/// With the lengths y, their rates w and the time T since the last lengths that were believed,
///   ν = y - y₀ - w T,   S = cov ν = (σ² + κ²) 1 + (a T²)² A Aᵀ + (τ w)(τ w)ᵀ,
/// where σ is the encoder's step, κ = (max |w| T)² / 2 min y the bend of the lengths' way (a string that is
/// passed at speed w turns), a an acceleration that hands reach and τ the jitter of the instant at which the
/// boards read. That string i alone is off, by s, explains ν at the cost νᵀ S⁻¹ ν - (S⁻¹ν)_i² / (S⁻¹)_ii with
/// s = (S⁻¹ν)_i / (S⁻¹)_ii; that the grip was hit, at the cost under an acceleration thirty times as large.
/// Costs are distributed as χ²: what costs too much is not what happened.
///
/// A string that is off is not believed: its length is taken from the others and from the motion. When the
/// next reading goes on from there as everything moved before, the encoder slipped, and by how much is known.
/// When it is back where the motion leads, the reading was a spike. When neither becomes clear within four
/// readings, the counters no longer tell lengths. This needs no redundant string, and tells strings apart
/// that are parallel in the space of residuals. It sees what happens within a tick or two; what grows slowly
/// is SlipDiagnosis' business. Cost: nothing to speak of while the strings move smoothly, else two
/// factorisations of n × n (2 µs for 8).
#pragma once
#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// Limits by which CountScreen tells motion from misreadings and slips.
struct ScreenSettings {
  double least_change = 0.25e-3;  ///< deviations below are motion or noise [m]
  double least_slip = 0.4e-3;     ///< a smaller one cannot be told from a blow [m]
  double acceleration = 60;       ///< of the grip, standard deviation [m/s²]; a hand reaches 50, strings 200
  double impact = 50;             ///< times that: the grip was hit, or let go under force
  double jitter = 3;              ///< of the instant of reading [periods]; a busy host
  double largest_slip = 25e-3;    ///< more than that is no slip of a drum or a wheel: the counter is lost [m]
  int patience = 4;               ///< readings until a doubt must be settled
};

/// Screens the encoder counts of one device: motion, misreading or slip.
class CountScreen {
 public:
  /// What became of a reading.
  enum class Verdict : unsigned char {
    kMotion,    ///< believed
    kReplaced,  ///< string `suspect` is off: its length was replaced, the pose is good
    kHeld,      ///< several strings are off: these lengths make no pose
    kSlipped,   ///< the encoder of `suspect` slipped by `slip`; the length was corrected by it
    kLost,      ///< the counters no longer tell lengths; `suspect` is off most
  };

  CountScreen(const DeviceDef& def, const ScreenSettings& settings);  ///< for a device of this arrangement

  void forget() noexcept;  ///< (in realtime) the next lengths are believed as they are
  /// (in realtime) Judges the lengths [m] of one reading, `elapsed` [s] after the last; `pose` is the last
  /// one. Replaces lengths that are not believed.
  Verdict judge(StringVector& length, const StringKinematics& kinematics, const GripPose& pose,
                double elapsed) noexcept;

  int suspect() const { return suspect_; }  ///< string of the last verdict that was not kMotion; -1: none
  double slip() const { return shift_; }    ///< its length as measured minus as it is [m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.known_), visit(s.since_), visit(s.shift_), visit(s.doubts_), visit(s.suspect_), visit(s.single_);
    visit(s.before_), visit(s.rate_), visit(s.read_);
  }

 private:
  struct Explanation {
    bool smooth = false, one = false, moved = false;  ///< a motion like before; one string off; a blow
    int string = 0;
    double shift = 0;  ///< of that string [m]
    double cost = 0;   ///< of a motion like before [1]
  };
  Explanation explain(const StringVector& deviation, const StructureMatrix& A, double elapsed) const noexcept;
  Verdict settle(StringVector& length, const Explanation& found, bool persists) noexcept;
  void believe(const StringVector& length) noexcept;

  ScreenSettings settings_;
  int strings_;
  double step_ = 0;             ///< coarsest encoder step [m]; quantisation makes 0.71 of it in ν
  StringVector before_, rate_;  ///< [m], [m/s]; believed
  StringVector read_;           ///< in doubt: the reading before [m]
  int known_ = 0;               ///< readings that before_ and rate_ come from, up to two
  double since_ = 0, shift_ = 0;
  int doubts_ = 0, suspect_ = -1;
  bool single_ = false;  ///< the doubt is about one string
};

}  // namespace haptic
