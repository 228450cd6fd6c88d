#include "haptic_bridge/run_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace haptic {
namespace {

// Below this nothing was exchanged that a relative gain could be measured against [J]: a gram lifted by 0.1 mm.
constexpr double kLeastEnergy = 1e-6;
// Figures of wrenches begin after the first second: the force fades in.
constexpr std::int64_t kSettling = 1000000000;  // [ns]
// The grip's range in which the pose's accuracy is stated.
constexpr double kStatedReach = 0.03;  // [m]
constexpr double kStatedAngle = 0.5;   // [rad]
// The full-presentation area: with this λ a wrench that the bounds admit is met to λ·|t|, some 1e-6 N.
constexpr double kExactLambda = 1e-7, kExactError = 1e-4;  // [1], [N]

/// Lines `figure demo.NAME VALUE UNIT`. A figure that the run did not measure has no line; its name is kept.
struct FigureLines {
  std::string text, unmeasured;

  void add(const std::string& name, double value, const char* unit) {
    if (std::isnan(value)) {
      unmeasured += " demo." + name;
      return;
    }
    char number[32];
    std::snprintf(number, sizeof(number), "%.6g", value);
    text += "figure demo." + name + " " + number + " " + unit + "\n";
  }
  void add(const char* name, std::uint64_t value) {
    text += std::string("figure demo.") + name + " " + std::to_string(value) + " 1\n";
  }
};

/// Ratio of two root mean squares [%]; NaN where nothing was asked.
double percent(double part2, double whole2) { return whole2 > 0 ? 100 * std::sqrt(part2 / whole2) : std::nan(""); }

}  // namespace

double percentile(std::vector<float>& values, double p) {
  if (values.empty()) return std::nan("");
  const auto rank = static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

void TickTimes::reserve(std::size_t ticks) {
  for (auto* v : {&tick, &io, &lateness}) v->reserve(ticks);
}

void TickTimes::add(const TickSample& sample) {
  tick.push_back(1e-3f * static_cast<float>(sample.tick_ns));
  io.push_back(1e-3f * static_cast<float>(sample.io_ns));
  lateness.push_back(1e-3f * static_cast<float>(sample.lateness_ns));
}

void TickTimes::clear() {
  for (auto* v : {&tick, &io, &lateness}) v->clear();
}

RunFigures::RunFigures(std::uint64_t ticks) { times_.reserve(ticks); }

void RunFigures::add(const TickSample& sample) {
  ++ticks_;
  if (sample.lost_periods > 0) ++missed_;
  times_.add(sample);
  if (ticks_ == 1) first_ns_ = sample.start_ns;
  const bool settled = sample.start_ns - first_ns_ > kSettling;
  for (int i = 0; i < sample.hands; ++i)
    addHand(sample.hand[i], i < static_cast<int>(exact_.size()) ? exact_[i].get() : nullptr, settled, asked_[i]);
  addEnergy(sample.step.energy);
}

RunFigures::Exact::Exact(const DeviceDef& def) : name(def.name), kinematics(def), distribution(def, kinematics) {
  distribution.setLambda(kExactLambda);
}

bool RunFigures::Exact::presents(const HandSample& hand) {
  GripPose pose;
  pose.X_BG = hand.X_BG;
  pose.opening = hand.opening;
  distribution.setStructure(kinematics.scaledStructure(pose));
  return distribution.solve(hand.F_asked_B).error < kExactError;
}

void RunFigures::setDevices(const std::vector<DeviceDef>& devices) {
  bool same = devices.size() == exact_.size();
  for (std::size_t i = 0; same && i < devices.size(); ++i) same = devices[i].name == exact_[i]->name;
  if (same) return;
  exact_.clear();
  for (const DeviceDef& def : devices) exact_.push_back(std::make_unique<Exact>(def));
}

void RunFigures::addPoseError(const HandSample& hand) {
  const Pose &measured = hand.X_BG, &truth = hand.X_BG_true;
  if (truth.p.norm() > kStatedReach || vectorFromRotation(Quaternion(truth.R)).norm() > kStatedAngle) return;
  position_error_ = std::fmax(position_error_, (measured.p - truth.p).norm());
  rotation_error_ =
      std::fmax(rotation_error_, vectorFromRotation(Quaternion(measured.R * truth.R.transpose())).norm());
}

void RunFigures::addHand(const HandSample& hand, Exact* exact, bool settled, Asked& asked) {
  contact_force_ = std::max(contact_force_, hand.pointer_force);
  if (hand.over_clamp) ++clamps_exceeded_;
  simulated_ = simulated_ || hand.simulated;
  if (hand.simulated && hand.calibrated) addPoseError(hand);
  if (hand.strings_known && settled && asked.known) {
    all_.add(hand.F_strings_B, asked.F_B);
    if (asked.presentable) inside_.add(hand.F_strings_B, asked.F_B);
  }
  asked.F_B = hand.F_asked_B;
  asked.known = true;
  const bool asks = hand.F_asked_B.force.squaredNorm() + hand.F_asked_B.torque.squaredNorm() > 0;
  asked.presentable = asks && hand.state == DeviceState::kEnabled && exact && exact->presents(hand);
}

void RunFigures::WrenchError::add(const Wrench& done, const Wrench& asked) {
  ++ticks;
  force_error2 += (done.force - asked.force).squaredNorm();
  force2 += asked.force.squaredNorm();
  torque_error2 += (done.torque - asked.torque).squaredNorm();
  torque2 += asked.torque.squaredNorm();
}

double RunFigures::WrenchError::force() const { return percent(force_error2, force2); }
double RunFigures::WrenchError::torque() const { return percent(torque_error2, torque2); }

/// gain = max over t of [E(t) - E(0) - W_hand(t) + D(t)]⁺ over the largest energy exchanged so far.
void RunFigures::addEnergy(const EnergyLedger& e) {
  const double stored = e.total();
  const double dissipated = e.damping + e.friction;
  if (!energy_known_) {
    first_energy_ = stored - e.external + dissipated;
    first_potential_ = e.potential;
    energy_known_ = true;
  }
  for (const double part : {std::fabs(e.external), dissipated, e.kinetic, e.elastic, e.tangential,
                            std::fabs(e.potential - first_potential_)}) {
    exchanged_ = std::max(exchanged_, part);
  }
  const double excess = stored - e.external + dissipated - first_energy_;
  if (exchanged_ > kLeastEnergy) gain_ = std::max(gain_, excess / exchanged_);
}

std::string RunFigures::text() {
  FigureLines lines;
  lines.add("ticks", ticks_);
  lines.add("missed_ticks", missed_);
  lines.add("tick_us_p50", percentile(times_.tick, 0.5), "us");
  lines.add("tick_us_p99", percentile(times_.tick, 0.99), "us");
  lines.add("tick_us_max", percentile(times_.tick, 1), "us");
  lines.add("io_us_p50", percentile(times_.io, 0.5), "us");
  lines.add("lateness_us_p50", percentile(times_.lateness, 0.5), "us");
  lines.add("lateness_us_p99", percentile(times_.lateness, 0.99), "us");
  lines.add("pose_error_um_max", 1e6 * position_error_, "um");
  lines.add("pose_error_mrad_max", 1e3 * rotation_error_, "mrad");
  lines.add("force_error_pct", all_.force(), "%");
  lines.add("torque_error_pct", all_.torque(), "%");
  lines.add("force_error_inside_pct", inside_.force(), "%");
  lines.add("torque_error_inside_pct", inside_.torque(), "%");
  lines.add("inside_pct", 100.0 * static_cast<double>(inside_.ticks) / static_cast<double>(all_.ticks), "%");
  lines.add("contact_force_n_max", contact_force_, "N");
  lines.add("clamps_exceeded", clamps_exceeded_);
  lines.add("energy_gain_rel", gain_, "1");
  lines.add("nodelets_same_process", nodelets_together_ ? 1 : 0);
  if (lines.unmeasured.empty()) return lines.text;
  return lines.text + "not measured:" + lines.unmeasured + ": " +
         (simulated_ ? "they begin with a force or torque after the first second, and near the centre\n"
                     : "a real device does not tell its true pose and tensions\n");
}

}  // namespace haptic
