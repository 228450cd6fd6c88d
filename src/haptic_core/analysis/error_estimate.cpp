#include "haptic_core/analysis/error_estimate.h"

#include <algorithm>

#include "haptic_core/base/error.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

WorldDef shadowOf(const WorldDef& def) {
  WorldDef shadow = def;
  shadow.settings.history_steps = 0;
  return shadow;
}

/// Every body is stepped by h/2.
WorldDef halved(WorldDef def) {
  def.settings.step *= 0.5;
  def.settings.far_step = 0;
  return def;
}

/// The same state in a world of half the step: all that counts steps counts twice as many.
std::vector<double> inHalfSteps(State state) {
  state.step *= 2;
  for (auto* counts : {&state.turn, &state.as_of}) {
    for (std::uint64_t& count : *counts) count *= 2;
  }
  for (int i = 0; i < state.wrench_count; ++i) state.wrenches[i].end *= 2;
  return state.pack();
}

int orderOf(const Model& model, std::size_t pointers) {
  for (const ModelTree& tree : model.trees) {
    if (tree.has_laws) return 1;
  }
  if (pointers > 0) return 1;  // stages of SDIRK2 see the hand where the step ends
  return model.settings.attempts == Attempts::kImplicitEuler ? 1 : 2;
}

/// Error of the coarser of two results that lie `difference` apart.
double richardson(double difference, int order) { return difference / (1 - std::ldexp(1.0, -order)); }

/// A step of the shadow, to the time `t` [s] after `start` of each hand, which goes on a straight line at constant speed.
void stepTo(World& shadow, const std::vector<PointerState>& start, double t) {
  for (std::size_t i = 0; i < start.size(); ++i) {
    const PointerState& hand = start[i];
    if (!hand.targeted) continue;
    const Quaternion turned = rotationFromVector(t * hand.V_WP.angular) * hand.q_WP;
    shadow.setPointerTarget(static_cast<int>(i), Pose(turned, hand.p_WP + t * hand.V_WP.linear), hand.V_WP);
  }
  shadow.step();
}

}  // namespace

struct ErrorEstimator::Impl {
  Impl(const WorldDef& def, int window_steps) : steps(window_steps), coarse(def), fine(halved(def)) {
    order = orderOf(coarse.model(), def.pointers.size());
  }

  /// Quantities derived from the step keep the running step's value: a stiffer coupling would be another model.
  WorldTuning resolvedTuning(const WorldTuning& tuning) const {
    const double h = coarse.settings().step;
    WorldTuning out = tuning;
    for (std::size_t i = 0; i < out.coupling.size(); ++i) {
      if (out.coupling[i].mode != PointerCoupling::Mode::kVirtual) continue;
      const int link = coarse.state().pointers[i].link;
      const ModelLink& pulled = coarse.model().links[link];
      out.coupling[i] = resolved(out.coupling[i], {pulled.mass, pulled.least_inertia}, h,
                                 link != coarse.pointerHome(static_cast<int>(i)));
    }
    return out;
  }

  /// Tuning forgets what velocity Verlet remembers, hence before the state, and only where something changed.
  static void put(World& shadow, const std::vector<double>& state, const WorldTuning& tuning) {
    if (shadow.tuning().numbers() != tuning.numbers()) {
      shadow.restore(state);
      shadow.tune(tuning);
    }
    shadow.restore(state);
  }

  /// `first`: wrenches of the fine one's last step but one, by pointer.
  void compare(const std::vector<Wrench>& first, ErrorEstimate& e) const {
    e.position = e.rotation = 0;
    for (std::size_t l = 0; l < coarse.model().links.size(); ++l) {
      const Pose X = relativePose(fine.linkPose(static_cast<int>(l)), coarse.linkPose(static_cast<int>(l)));
      const double moved = richardson(X.p.norm(), order);
      e.rotation = std::max(e.rotation, richardson(vectorFromRotation(Quaternion(X.R)).norm(), order));
      if (moved <= e.position) continue;
      e.position = moved;
      e.link = static_cast<int>(l);
    }
    if (coarse.settings().energy_ledger) {
      e.energy = richardson(std::abs(coarse.report().energy.total() - fine.report().energy.total()), order);
    }
    for (std::size_t i = 0; i < e.force.size(); ++i) {
      const Wrench mean = (first[i] + fine.pointerWrench(static_cast<int>(i))) * 0.5;
      const Wrench F = coarse.pointerWrench(static_cast<int>(i)) - mean;
      e.torque[i] = richardson(F.torque.norm(), 1);
      e.force[i] = richardson(F.force.norm(), 1);
    }
  }

  int steps, order;
  World coarse, fine;
};

ErrorEstimator::ErrorEstimator(const WorldDef& def, int window_steps) {
  if (window_steps < 1) throw SetupError("error estimate", "has a window of no step", "give 1 or more");
  impl_ = std::make_unique<Impl>(shadowOf(def), window_steps);
}

ErrorEstimator::~ErrorEstimator() = default;

ErrorEstimate ErrorEstimator::estimate(const std::vector<double>& state, const WorldTuning& tuning,
                                       const std::vector<PointerBound>& bounds) {
  World &coarse = impl_->coarse, &fine = impl_->fine;
  Impl::put(coarse, state, tuning);
  Impl::put(fine, inHalfSteps(coarse.state()), impl_->resolvedTuning(tuning));
  const double h = coarse.settings().step;
  for (World* shadow : {&coarse, &fine}) {
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      PointerBound bound = bounds[i];
      bound.lag = std::max(bound.lag, kLeastLag * h);  // of the loop, which goes on at h
      shadow->setPointerBound(static_cast<int>(i), bound);
    }
  }
  const std::vector<PointerState> hands = coarse.state().pointers;
  ErrorEstimate e;
  e.steps = impl_->steps;
  e.order = impl_->order;
  e.force.assign(hands.size(), std::nan(""));
  e.torque = e.force;
  std::vector<Wrench> first(hands.size());
  for (int k = 1; k <= impl_->steps; ++k) {
    stepTo(coarse, hands, k * h);
    stepTo(fine, hands, (k - 0.5) * h);
    for (std::size_t i = 0; i < first.size(); ++i) first[i] = fine.pointerWrench(static_cast<int>(i));
    stepTo(fine, hands, k * h);
  }
  if (coarse.report().finite && fine.report().finite) impl_->compare(first, e);
  return e;
}

}  // namespace haptic
