/// The choice between explicit and implicit steps, island by island.
///
/// An island is stepped by velocity Verlet while no link of it comes near the bound of stability (stability_number.h),
/// by SDIRK2 otherwise. The numbers are those of the contacts that the explicit step itself has found at its end: where
/// one is too high, because something stiff was hit or grew, the step has not happened; it is taken back and done again
/// with that island implicit. An implicit island is looked at every 16 steps and goes back when its numbers have become
/// low. So the choice depends on the state alone; modes and numbers are part of it.
#include <algorithm>

#include "haptic_core/world/pipeline.h"

namespace haptic {
namespace {

/// Steps after which the number of a contact is taken again even though its patch has not grown: it may have moved to
/// where the lever arm is longer. A power of two less one.
constexpr std::uint64_t kRenewMask = 255;
/// A patch that has grown by more than this is measured again.
constexpr double kGrown = 1.1;

}  // namespace

void Pipeline::substepAutomatic(double h, double progress) noexcept {
  prime(h);
  keepForRetreat();
  while (!substepVerlet(h, progress)) {  // each round makes at least one more tree implicit
    retreat();
    ++report_.redone;
  }
  if (anyImplicit()) stepIslands(h);
  collectPointerWrenches();
  report_.pairs = state_.pair_count;
  report_.contacts = contacts_.size();
}

bool Pipeline::anyImplicit() const noexcept {
  return std::find(state_.mode.begin(), state_.mode.end(), double(kImplicit)) != state_.mode.end();
}

void Pipeline::keepForRetreat() noexcept {
  std::copy(state_.q.begin(), state_.q.end(), retreat_.q.begin());
  std::copy(state_.v.begin(), state_.v.end(), retreat_.v.begin());
  std::copy(state_.pull.begin(), state_.pull.end(), retreat_.pull.begin());
  std::copy(state_.energy, state_.energy + 4, retreat_.energy);
  retreat_.pair_count = state_.pair_count;
  retreat_.flags = report_.flags;
}

void Pipeline::retreat() noexcept {
  std::copy(retreat_.q.begin(), retreat_.q.end(), state_.q.begin());
  std::copy(retreat_.v.begin(), retreat_.v.end(), state_.v.begin());
  std::copy(retreat_.pull.begin(), retreat_.pull.end(), state_.pull.begin());
  std::copy(retreat_.energy, retreat_.energy + 4, state_.energy);
  std::swap(previous_pairs_, state_.pairs);  // findPairs has swapped them once
  state_.pair_count = retreat_.pair_count;
  report_.flags = retreat_.flags;
  updateKinematics();
}

/// Bodies that move, one stepped explicitly and the other implicitly, must not meet inside a step.
bool Pipeline::modesMeet() const noexcept {
  for (int i = 0; i < state_.pair_count; ++i) {
    const int a = treeOf(state_.pairs[i].shapeA()), b = treeOf(state_.pairs[i].shapeB());
    if (isImplicit(a) != isImplicit(b) && movesByItself(plan_.trees[a]) && movesByItself(plan_.trees[b])) return true;
  }
  return false;
}

/// Makes whole islands implicit in which a link's number is too high, or a tree is implicit already.
void Pipeline::makeImplicit(bool by_numbers) noexcept {
  islands_->find(state_, held_by_, false);
  for (int i = 0; i < islands_->count(); ++i) {
    const Island island = (*islands_)[i];
    bool implicit = false;
    for (int n = 0; n < island.tree_count; ++n) {
      const PlanTree& tree = plan_.trees[island.trees[n]];
      implicit |= isImplicit(island.trees[n]);
      for (int l = 0; by_numbers && l < tree.model->linkCount(); ++l) implicit |= tooStiff(tree.link + l);
    }
    for (int n = 0; implicit && n < island.tree_count; ++n) state_.mode[island.trees[n]] = kImplicit;
  }
}

bool Pipeline::anyTooStiff() noexcept {
  double most = 0;
  for (double number : number_) most = std::max(most, number);
  report_.stability = most / kStabilityBound;
  return report_.stability > kEnterImplicit;
}

/// Shares of a contact for its two links, kept with the pair while the patch stays what it is.
void Pipeline::measureStability(ActivePair& pair, const ContactVolume& volume, const PatchTangent& tangent,
                                const Pose& X_WP, double h) noexcept {
  const int link[2] = {plan_.shapes[pair.shapeA()].link, plan_.shapes[pair.shapeB()].link};
  const auto moves = [this](int l) { return movesByItself(plan_.trees[plan_.links[l].articulation]); };
  const bool both = moves(link[0]) && moves(link[1]);
  for (int s = 0; s < 2; ++s) {
    pair.stability.share[s] = 0;
    if (!moves(link[s])) continue;
    const PlanLink& l = plan_.links[link[s]];
    const LinkModel& model = plan_.trees[l.articulation].model->link(l.local);
    const Matrix6 W = freeMobility(model, work_[link[s]].X_WL.R, work_[link[s]].p_WC(), X_WP);
    pair.stability.share[s] = stabilityNumber(tangent, W, both, h);
  }
  pair.stability.area = volume.A0;
  pair.stability.volume = volume.volume;
}

void Pipeline::noteStability(ActivePair& pair, const ContactVolume& volume, const PatchTangent& tangent,
                             const Pose& X_WP, double h) noexcept {
  const StabilityMemory& known = pair.stability;
  const bool old = ((state_.step + pair.key) & kRenewMask) == 0;
  if (old || volume.A0 > kGrown * known.area || volume.volume > kGrown * known.volume) {
    measureStability(pair, volume, tangent, X_WP, h);
  }
  countStability(pair);
}

void Pipeline::countStability(const ActivePair& pair) noexcept {
  number_[plan_.shapes[pair.shapeA()].link] += pair.stability.share[0];
  number_[plan_.shapes[pair.shapeB()].link] += pair.stability.share[1];
}

/// Share of the virtual couplings that pull at a link, as if it were free.
double Pipeline::couplingNumber(int link, double h) const noexcept {
  double sum = 0;
  for (std::size_t p = 0; p < pointers_.size(); ++p) {
    if (holds(static_cast<int>(p)) || static_cast<int>(state_.pointers[p].link) != link) continue;
    const PointerCoupling& c = pointers_[p].coupling;
    const PlanLink& l = plan_.links[link];
    const LinkModel& model = plan_.trees[l.articulation].model->link(l.local);
    const double turn = model.I_C.inverse().trace();  // not below the largest eigenvalue
    const double arm2 = (work_[link].p_WC() - work_[link].X_WL.p).squaredNorm();  // the spring is at L's origin
    sum += (h * h * c.stiffness + 2 * h * c.damping) * (1 / model.mass + arm2 * turn) +
           (h * h * c.rotational_stiffness + 2 * h * c.rotational_damping) * turn;
  }
  return sum;
}

}  // namespace haptic
