#include "haptic_core/spidar/string_health.h"

#include <algorithm>
#include <cmath>

namespace haptic {

StringHealth::StringHealth(const DeviceDef& def, const HealthSettings& settings)
    : settings_(settings),
      strings_(static_cast<int>(def.strings.size())),
      continuous_(strings_),
      heat_(StringVector::Zero(strings_)),
      screen_(def, settings.screen),
      diagnosis_(def, settings.diagnosis) {
  for (int i = 0; i < strings_; ++i) continuous_[i] = settings.continuous_share * def.strings[i].max_tension;
}

void StringHealth::forget() noexcept {
  screen_.forget();
  diagnosis_.forget();
  residual_time_ = quiet_time_ = 0;
  corrections_ = 0;
  named_ = reduced_ = false;
  suspect(-1, 0, 0);
}

void StringHealth::suspect(int string, double error, std::uint32_t among) noexcept {
  suspect_ = string;
  suspect_error_ = error;
  suspects_ = among;
}

CountScreen::Verdict StringHealth::screen(StringVector& length, const StringKinematics& kinematics,
                                          const GripPose& pose, double elapsed) noexcept {
  using Verdict = CountScreen::Verdict;
  Verdict verdict = screen_.judge(length, kinematics, pose, elapsed);
  since_correction_ += elapsed;
  if (verdict == Verdict::kSlipped) {
    const bool sticks = corrections_ > 0 && screen_.suspect() == corrected_ && since_correction_ < settings_.sticks_s;
    if (++corrections_ > settings_.most_corrections || sticks) verdict = Verdict::kLost;
    corrected_ = screen_.suspect();
    since_correction_ = 0;
  }
  if (verdict == Verdict::kSlipped || verdict == Verdict::kLost) {
    suspect(screen_.suspect(), screen_.slip(), 1u << screen_.suspect());
    diagnosis_.forget();
    reduced_ = false;
  }
  return verdict;
}

StringVerdict StringHealth::judge(const PoseSolution& solution, const StringVector& length,
                                  const StringKinematics& kinematics, const GripPose& last,
                                  double h) noexcept {
  const double share = solution.residual / settings_.residual_limit;
  const bool high = !(share <= 1);  // so too for a residual that is no number
  residual_time_ = high ? residual_time_ + h : 0;
  quiet_time_ = high ? 0 : quiet_time_ + h;
  if (high || diagnosis_.open()) diagnosis_.add(length, kinematics, last, h);
  // Lengths that agree again prove nothing: at another pose the same slip may not show. Once the force was reduced, only the
  // time to decide ends the doubt.
  if (diagnosis_.open() && quiet_time_ > settings_.doubt_end_s && !reduced_) diagnosis_.forget();
  if (!diagnosis_.open()) return StringVerdict::kTrue;
  const bool broken = !(share <= settings_.break_factor);
  // Half a tick of slack: sums of h must not decide by rounding.
  const bool lasts = residual_time_ >= settings_.residual_time_s - 0.5 * h;
  if (!broken && !lasts && diagnosis_.time() < settings_.decide_s) return StringVerdict::kTrue;
  // A name once found stays: the motors' later forces are no evidence.
  if (!named_) suspect(diagnosis_.best(), diagnosis_.offset(diagnosis_.best()), diagnosis_.candidates());
  named_ = named_ || diagnosis_.clear();
  if (broken) return StringVerdict::kBroken;
  reduced_ = true;
  return named_ || diagnosis_.time() >= settings_.decide_s ? StringVerdict::kNamed : StringVerdict::kDoubtful;
}

double StringHealth::heat(const StringVector& tension, double h) noexcept {
  hottest_ = 0;
  for (int i = 0; i < strings_; ++i) {
    const double load = tension[i] / continuous_[i];
    heat_[i] += h / settings_.heat_time_s * (load * load - heat_[i]);
    if (heat_[i] <= hottest_) continue;
    hottest_ = heat_[i];
    hottest_motor_ = i;
  }
  return std::min(1.0, std::max(0.0, (settings_.too_hot - hottest_) / (settings_.too_hot - settings_.hot)));
}

}  // namespace haptic
