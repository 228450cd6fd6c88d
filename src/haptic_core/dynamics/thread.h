/// A screw's thread: a slide x that follows a turn θ, x = l θ, and the friction of the flanks that carry the axial force F between them.
///
/// On the cylinder of the pitch radius r the flank climbs by the lead angle α, tan α = |l|/r; its normal is inclined by β_n to the plane
/// along the helix and across it, tan β_n = tan β cos α, β half of the angle between the flanks. A flank that carries the normal force N
/// rubs by μ N along the helix, s = 1 where it moves its load along F (it climbs), −1 against F:
///   F = N (cos β_n cos α − s μ sin α),   friction's torque on the turn = μ N r/cos α   (from its power, μ N times r θ'/cos α).
/// A thread that stands takes every torque between those of s = 1 and s = −1, so that it locks where μ > tan α cos β_n. Together with
/// l F this is the torque of textbooks, F r (tan α ± μ')/(1 ∓ μ' tan α) with μ' = μ/cos β_n (Shigley, Mechanical Engineering Design,
/// section 8-2).
#pragma once
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/dynamics/articulation_def.h"

namespace haptic {

/// Angles and friction of a thread.
class Thread {
 public:
  /// Of a slide that follows a turn.
  explicit Thread(const JointDef& slide)
      : lead_(slide.mimic_multiplier), radius_(slide.thread_radius), friction_(slide.thread_friction) {
    const double slope = radius_ > 0 ? std::abs(lead_) / radius_ : 0, cos2 = 1 / (1 + slope * slope);
    const auto [sine, cosine] = elementary::sinCos(slide.thread_flank);
    cos_ = std::sqrt(cos2);
    sin_ = slope * cos_;
    cos_flank_ = cosine / std::sqrt(cosine * cosine + sine * sine * cos2);
  }
  bool climbs(double force, double rate) const { return (force > 0) == (lead_ * rate > 0); }  ///< the turn moves its load along F
  /// Torque of friction on the turn by a unit of axial force [m].
  double lever(bool climbs) const {
    return friction_ * radius_ / (cos_ * (cos_flank_ * cos_ + (climbs ? -friction_ : friction_) * sin_));
  }
  double lockingFriction() const { return sin_ / cos_ * cos_flank_; }       ///< μ above which no axial force turns it [1]
  bool turns() const { return friction_ * sin_ < cos_flank_ * cos_; }       ///< false: no torque moves a load along
  /// Work on the slide over that of the turn, which moves a load along [1].
  double efficiency() const { return std::abs(lead_) / (std::abs(lead_) + lever(true)); }

 private:
  double lead_, radius_, friction_;           ///< way per turn by a radian [m]; r; μ
  double cos_ = 1, sin_ = 0, cos_flank_ = 1;  ///< of α; of β_n
};

}  // namespace haptic
