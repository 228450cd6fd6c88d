#include "haptic_core/world/step_parts.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/pairs/time_of_impact.h"
#include "haptic_core/world/hand_bound.h"
#include "haptic_core/world/held_proxy.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace {

constexpr int kMostParts = 200;      ///< of one substep; then the rest is done at once, flagged

/// The motions over the time left of a substep.
class Sweep {
 public:
  Sweep(const Model& model, double left, const State& state, Work& work, StepReport& report)
      : model_(model), left_(left), state_(state), placement_(work.placement), hands_(work.hands),
        search_(work.search), visits_(work.visits), asleep_(work.asleep), counted_(work.counted), report_(report) {}

  /// How much of the time left may pass before contacts have to be looked at again [s].
  double safePart() noexcept;

 private:
  ShapeMotion motionOf(int shape, bool falls) const noexcept;
  bool anyFast() const noexcept;
  bool isSolved(int link) const noexcept;
  double safePart(int a, int b) const noexcept;

  const Model& model_;
  const double left_;
  const State& state_;
  Placement& placement_;
  const HandWork& hands_;
  SearchWork& search_;
  const Visits& visits_;
  const stepping::Asleep& asleep_;
  CountedWork& counted_;
  StepReport& report_;
};

/// Motion of a shape over the time left of the step; hands move theirs to the target. `falls`: gravity counts, as the
/// mean of the speed that it adds; what rests on something does not fall.
ShapeMotion Sweep::motionOf(int s, bool falls) const noexcept {
  const int l = model_.shapes[s].link;
  const LinkWork& link = placement_.link[l];
  ShapeMotion motion;
  motion.X_WS = link.X_WL * model_.shapes[s].X_LS;
  motion.p_W = link.p_WC();
  motion.reach = model_.links[l].size;
  if (hands_.held_by[l] >= 0) {
    if (!std::binary_search(hands_.leading.begin(), hands_.leading.end(), hands_.held_by[l])) return motion;
    const HeldGoal& goal = hands_.goal[hands_.held_by[l]];
    const Quaternion turn = goal.q_WL * Quaternion(link.X_WL.R).conjugate();
    motion.V_W = Twist{vectorFromRotation(turn), goal.p_WL - link.X_WL.p};
    motion.V_W = motion.V_W.shifted(motion.p_W - link.X_WL.p);
    motion.V_W.angular /= left_;
    motion.V_W.linear /= left_;
  } else if (model_.links[l].moves) {
    motion.V_W = link.twistAt(motion.p_W);
    if (falls) motion.V_W.linear += 0.5 * left_ * model_.settings.gravity;
  }
  return motion;
}

/// True if some link may move by more than a quarter of the thin bodies around it.
bool Sweep::anyFast() const noexcept {
  const Vector3 fall = 0.5 * left_ * model_.settings.gravity;
  const double left2 = left_ * left_;
  for (const int i : visits_.limits) {
    const MotionLimit& limit = model_.motion_limits[i];
    const LinkWork& link = placement_.link[limit.link];
    const double speed2 = (link.velocity + fall).squaredNorm() + limit.lever2 * link.omega.squaredNorm();
    if (2 * left2 * speed2 > limit.way2) return true;  // (a + b)² ≤ 2 (a² + b²)
  }
  for (const int lead : hands_.leading) {
    const int l = ledLink(model_, state_, lead);
    const double way = kShareOfWidth * model_.least_width[l];
    if ((hands_.goal[lead].p_WL - placement_.link[l].X_WL.p).squaredNorm() > way * way) return true;
  }
  return false;
}

double Sweep::safePart() noexcept {
  ++report_.substeps;
  if (!anyFast()) return left_;
  if (report_.substeps > kMostParts || counted_.spent()) {
    report_.flags |= kTooFast;
    return left_;
  }
  for (const int s : visits_.shapes) {
    const ShapeMotion motion = motionOf(s, true);
    placement_.box[s] = model_.shapes[s].shape->aabb(motion.X_WS);
    if (!model_.links[model_.shapes[s].link].moves) continue;
    const Vector3 way = left_ * motion.V_W.linear;
    const double turn = std::min(2.0, left_ * motion.V_W.angular.norm()) * motion.reach;
    placement_.box[s].lower = (placement_.box[s].lower + way.cwiseMin(0.0)).array() - turn;
    placement_.box[s].upper = (placement_.box[s].upper + way.cwiseMax(0.0)).array() + turn;
  }
  if (!sweepBoxes(model_, visits_, placement_, search_)) report_.flags |= kPairsDropped;
  double part = left_;
  eachOverlap(model_, search_, [&](int a, int b) { part = std::min(part, safePart(a, b)); });
  for (const int s : visits_.shapes) {  // what sleeps is where it fell asleep
    asleep_.eachOverlap(model_, placement_.box[s], [&](int other) {
      const int a = std::min(s, other), b = std::max(s, other);
      if (model_.mayCollide(a, b)) part = std::min(part, safePart(a, b));
    });
  }
  for (int i = 0; i < state_.pair_count; ++i) {
    if (state_.pairs[i].friction.touching == 0) continue;
    for (int s : {state_.pairs[i].shapeA(), state_.pairs[i].shapeB()}) {
      const double turn = model_.implicit_steps ? placement_.link[model_.shapes[s].link].omega.norm() * left_ : 0;
      if (turn > kMostTurn) part = std::min(part, left_ * kMostTurn / turn);
    }
  }
  return part;
}

/// Stays, or is stepped implicitly.
bool Sweep::isSolved(int link) const noexcept {
  if (hands_.held_by[link] >= 0) return false;
  return !model_.links[link].moves || model_.implicit_steps;
}

double Sweep::safePart(int a, int b) const noexcept {
  const ModelShape &A = model_.shapes[a], &B = model_.shapes[b];
  const double width = std::min(A.width, B.width);
  const ActivePair* end = state_.pairs.data() + state_.pair_count;
  const ActivePair* known = std::lower_bound(
      static_cast<const ActivePair*>(state_.pairs.data()), end, ActivePair::keyOf(a, b),
      [](const ActivePair& pair, std::uint64_t key) { return pair.key < key; });
  const bool touching = known != end && known->key == ActivePair::keyOf(a, b) && known->friction.touching != 0;
  const double step = (isSolved(A.link) && isSolved(B.link) ? kShareOfWidthSolved : kShareOfWidth) * width;
  const ShapeMotion ma = motionOf(a, !touching), mb = motionOf(b, !touching);
  const double most = (ma.V_W.linear - mb.V_W.linear).norm() + ma.V_W.angular.norm() * ma.reach +
                      mb.V_W.angular.norm() * mb.reach;
  if (most * left_ <= step) return left_;
  counted_.done += units::kSweep;
  const DepthTimes at =
      timesOfDepth(*A.shape, ma, *B.shape, mb, left_, kClearance * width, step, touching ? &known->cache.normal : nullptr);
  // Up to the touch in one part, from there on by quarters.
  return at.deep < left_ && at.touch > at.deep - at.touch ? at.touch : at.deep;
}

/// The first `h` of `left`.
StepPart beginning(const Model& model, int substep, double h, double left) noexcept {
  StepPart part;
  part.h = h;
  part.share = part.h / model.substep();
  part.progress = part.h / (left + model.substep() * (model.settings.substeps - 1 - substep));
  part.substep = substep;
  part.left = part.h < left ? left - part.h : 0;
  return part;
}

StepPart cut(const Model& model, int substep, double left, const State& state, Work& work, StepReport& report) noexcept {
  boundHands(model, state, work.placement, work.hands);
  aimMotions(model, substep, state, work.hands);
  aimHeld(model, state, left + model.substep() * (model.settings.substeps - 1 - substep), work);
  const double safe = Sweep(model, left, state, work, report).safePart();
  return beginning(model, substep, std::min(safe, left), left);
}

}  // namespace

StepPart firstPart(const Model& model, const State& state, Work& work, StepReport& report) noexcept {
  return cut(model, 0, model.substep(), state, work, report);
}

StepPart nextPart(const Model& model, const StepPart& last, const State& state, Work& work, StepReport& report) noexcept {
  if (!report.finite) return StepPart{};
  if (last.left > 0) return cut(model, last.substep, last.left, state, work, report);
  if (last.substep + 1 < model.settings.substeps) {
    return cut(model, last.substep + 1, model.substep(), state, work, report);
  }
  return StepPart{};
}

}  // namespace haptic
