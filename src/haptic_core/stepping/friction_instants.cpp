/// The instants within a step at which friction changes between sticking and sliding: located, and the modes changed there.
#include <algorithm>
#include <cmath>

#include "haptic_core/base/bracket.h"
#include "haptic_core/stepping/implicit_step.h"

namespace haptic {
namespace {

/// An instant is located when the load is this close to the limit, or the slip this small against its start.
constexpr double kLocated = 1e-8;
constexpr int kMostLocations = 12;

/// Power of two slips (translation and spin) in the metric of the friction layer, per its stiffness.
double product(const FrictionMemory& metric, const FrictionMemory& a, const FrictionMemory& b) {
  return metric.area * a.rate_M.dot(b.rate_M) + metric.torsion * a.spin * b.spin;
}

void slide(FrictionMemory& memory) {
  memory.sliding = 1;
  memory.rate_M = memory.slip_M;
  memory.spin = memory.twist;
}

}  // namespace

/// How far a contact is beyond what its mode allows: the load over the static limit, or the slip that has turned
/// around, both relative; negative before. Contacts that slide on have none.
double ImplicitStep::violation(const ImplicitContact& c) const noexcept {
  if (stage_.yielding[c.pair] == Yielding::kNever) return c.force.memory.load - 1;
  if (stage_.yielding[c.pair] != Yielding::kDragged) return -1;
  FrictionMemory start = state_->pairs[c.pair].friction;
  start.rate_M = c.force.inNewAxes(start.rate_M);
  const double size = product(start, start, start);
  return size > 0 ? -product(start, start, c.force.memory) / size : 0;
}

double ImplicitStep::violation() const noexcept {
  double most = -1;
  for (const ImplicitContact& c : stage_.contacts()) most = std::max(most, violation(c));
  return most;
}

double ImplicitStep::violationAtStart() const noexcept {
  double most = -1;
  for (const ImplicitContact& c : stage_.contacts()) {
    if (stage_.yielding[c.pair] == Yielding::kNever) most = std::max(most, state_->pairs[c.pair].friction.load - 1);
  }
  return most;
}

/// Solves up to the first change of friction in (0, s], commits, and changes the modes. < 0: not smooth, or the budget is used up.
double ImplicitStep::locate(double s) noexcept {
  const double low = 0, f_low = violationAtStart();
  if (f_low >= -kLocated) {  // at once
    for (const ImplicitContact& c : stage_.contacts()) {
      FrictionMemory& memory = state_->pairs[c.pair].friction;
      if (stage_.yielding[c.pair] != Yielding::kNever || memory.load < 1 - kLocated) continue;
      slide(memory);
      event_[c.pair] = 1 - left_ / length_;
    }
    forget();
    return 0;
  }
  const int before = used();
  if (!sdirk2(s, left_ - s)) return -1;  // what stops is dragged on
  const int solve = used() - before;
  double t = s, f = violation();
  const bool turns = f > 0;
  Bracket bracket(low, f_low, s, f);
  for (int i = 0; turns && i < kMostLocations && std::abs(f) > kLocated; ++i) {
    t = bracket.guess();
    if (!affords(solve, left_) || !sdirk2(t, left_ - t)) return -1;
    f = violation();
    bracket.take(t, f);
  }
  for (const ImplicitContact& c : stage_.contacts()) violation_[c.pair] = violation(c);
  if (!keepSdirk2(t)) return -1;
  if (turns) changeModes(f - 10 * kLocated, length_ - left_ + t);
  return t;
}

void ImplicitStep::forget() noexcept {
  for (int n = 0; n < stage_.island().tree_count; ++n) state_->last_step[stage_.island().trees[n]] = 0;
}

/// The contacts at their limit slide from now on, those that stopped stick.
void ImplicitStep::changeModes(double least, double elapsed) noexcept {
  forget();
  for (const ImplicitContact& c : stage_.contacts()) {
    FrictionMemory& memory = state_->pairs[c.pair].friction;
    const Yielding mode = stage_.yielding[c.pair];
    if (mode == Yielding::kKeepsLimit || violation_[c.pair] < least) continue;
    event_[c.pair] = elapsed / length_;
    if (mode == Yielding::kNever) {
      slide(memory);
    } else {
      memory.sliding = 0;
      const PairLaw law = model_.law(c.shape_a, c.shape_b, false, false);
      memory.load = law.material.mu_dynamic / law.material.mu_static;
    }
  }
}

}  // namespace haptic
