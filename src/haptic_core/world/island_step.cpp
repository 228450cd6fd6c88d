/// The implicit part of a step: the islands that are stepped implicitly, one after the other.
#include <algorithm>

#include "haptic_core/dynamics/free_body.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {
namespace {

/// Steps between two looks whether an implicit island may go back to explicit steps: a power of two less one.
constexpr std::uint64_t kLookMask = 15;

}  // namespace

/// Everything by the implicit scheme; contacts, ledger and the hand's wrench belong to the end of the substep.
void Pipeline::substepImplicit(double h, double progress) noexcept {
  movePointers(progress);
  findPairs(h);
  clock_.end(report_.stages.search);
  for (LinkWork& link : work_) link.F_ext = Wrench{};  // the last substep's contacts
  contacts_.clear();
  report_.energy.elastic = report_.energy.tangential = 0;
  stepIslands(h);
  clock_.end(report_.stages.force);
  collectPointerWrenches();
  report_.pairs = state_.pair_count;
  report_.contacts = contacts_.size();
}

void Pipeline::stepIslands(double h) noexcept {
  const bool second_order = settings_.integrator != Integrator::kImplicitEuler;
  islands_->find(state_, held_by_, true);
  implicit_->begin(state_, held_by_);
  aimCouplings();
  for (int i = 0; i < islands_->count(); ++i) {
    const Island island = (*islands_)[i];
    const bool flies = island.pair_count == 0 && island.tree_count == 1 && fliesFreely(island.trees[0]);
    if (flies) {
      const PlanTree& tree = plan_.trees[island.trees[0]];
      stepFreeBody(tree.model->link(0), Wrench{}, settings_.gravity, h, state_.q.data() + tree.q,
                   state_.v.data() + tree.v);
    } else {
      const ImplicitReport& solved = implicit_->advance(island, h, second_order);
      report_.iterations = std::max(report_.iterations, solved.iterations);
      report_.evaluations = std::max(report_.evaluations, solved.evaluations);
      report_.factorisations = std::max(report_.factorisations, solved.factorisations);
      report_.wrench_error = std::max(report_.wrench_error, solved.wrench_error);
      report_.residual = std::max(report_.residual, solved.residual);
      report_.fallbacks += solved.fell_back;
      report_.parts = std::max(report_.parts, solved.parts);
      if (!solved.converged) report_.flags |= kNotConverged;
    }
    for (int n = 0; n < island.tree_count; ++n) {
      const PlanTree& tree = plan_.trees[island.trees[n]];
      forwardKinematics(*tree.model, state_.q.data() + tree.q, state_.v.data() + tree.v, work_.data() + tree.link);
    }
    if (!flies) takeContacts();
    ++report_.implicit_islands;
    if (settings_.integrator == Integrator::kAutomatic && (state_.step & kLookMask) == kLookMask) {
      lookForExplicit(island, h, flies);
    }
  }
  if (!implicit_->joints().converged()) report_.flags |= kJointsNotConverged;
  report_.closure = std::max(report_.closure, implicit_->joints().closure(work_.data()));
  takeCouplings();
}

/// A body that touches nothing and nothing pulls moves as explicit steps move it: exactly.
bool Pipeline::fliesFreely(int t) const noexcept {
  const PlanTree& tree = plan_.trees[t];
  if (!tree.model->isFreeBody() || tree.has_laws) return false;
  for (int p = 0; p < static_cast<int>(pointers_.size()); ++p) {
    if (!holds(p) && static_cast<int>(state_.pointers[p].link) == tree.link) return false;
  }
  return true;
}

/// Hands the virtual couplings to the solve.
void Pipeline::aimCouplings() noexcept {
  for (std::size_t i = 0; i < pointers_.size(); ++i) {
    const PointerState& pointer = state_.pointers[i];
    ImplicitCoupling& coupling = implicit_->couplings()[i];
    coupling.link = !holds(static_cast<int>(i)) && pointer.targeted != 0 ? static_cast<int>(pointer.link) : -1;
    if (coupling.link < 0) continue;
    const double *p = pointer.p_WL, *q = pointer.q_WL, *V = pointer.V_WL;
    coupling.law = pointers_[i].coupling;
    coupling.X_WL = Pose(Quaternion(q[0], q[1], q[2], q[3]), Vector3(p[0], p[1], p[2]));
    coupling.V_WL = {Vector3(V[0], V[1], V[2]), Vector3(V[3], V[4], V[5])};
    coupling.F_W = Wrench{};
  }
}

void Pipeline::takeCouplings() noexcept {
  for (std::size_t i = 0; i < pointers_.size(); ++i) {
    const ImplicitCoupling& coupling = implicit_->couplings()[i];
    if (coupling.link < 0 || !isImplicit(plan_.links[coupling.link].articulation)) continue;
    pointer_wrench_[i] += -(coupling.F_W * share_);
    state_.energy[2] += implicit_->couplingWork(static_cast<int>(i));
  }
}

/// What the island's contacts do to its links (and to those that hands hold), and what is reported of them.
void Pipeline::takeContacts() noexcept {
  for (const ImplicitContact& c : implicit_->contacts()) {
    const PlanShape &A = plan_.shapes[c.shape_a], &B = plan_.shapes[c.shape_b];
    const Wrench F_BP_W = c.force.F_BP_P.rotated(c.X_WP.R);
    work_[B.link].addWrench(F_BP_W, c.X_WP.p);
    work_[A.link].addWrench(-F_BP_W, c.X_WP.p);
    report_.energy.elastic += c.elastic;
    report_.energy.tangential += c.force.memory.energy;
    if (c.force.clipped) report_.flags |= kPressureClipped;
    ActivePair& pair = state_.pairs[c.pair];
    if (pair.buried != 0 && c.volume.depth < plan_.buriedDepth(c.shape_a, c.shape_b, c.volume.A0)) pair.buried = 0;
    noteContact(c.shape_a, c.shape_b, c.volume, c.force.normal_force, c.force.sticking, c.X_WP, F_BP_W);
    if (!contacts_.empty()) {
      contacts_[contacts_.size() - 1].sticking = pair.friction.sliding == 0;
      contacts_[contacts_.size() - 1].event = implicit_->event(c.pair);
    }
  }
}

/// Back to explicit steps where the numbers are low enough, with what those need to know of the last step.
void Pipeline::lookForExplicit(const Island& island, double h, bool flies) noexcept {
  const auto clear = [&](int t) {
    const PlanTree& tree = plan_.trees[t];
    for (int l = 0; l < tree.model->linkCount(); ++l) number_[tree.link + l] = couplingNumber(tree.link + l, h);
  };
  for (int n = 0; n < island.tree_count; ++n) clear(island.trees[n]);
  if (!flies) {
    for (const ImplicitContact& c : implicit_->contacts()) {
      ActivePair& pair = state_.pairs[c.pair];
      measureStability(pair, c.volume, c.force.tangent, c.X_WP, h);
      countStability(pair);
    }
  }
  double most = 0;
  for (int n = 0; n < island.tree_count; ++n) {
    const PlanTree& tree = plan_.trees[island.trees[n]];
    for (int l = 0; l < tree.model->linkCount(); ++l) most = std::max(most, number_[tree.link + l]);
  }
  if (!(most < kLeaveImplicit * kStabilityBound)) return;
  if (!flies) {
    for (const ImplicitContact& c : implicit_->contacts()) {
      const PlanShape &A = plan_.shapes[c.shape_a], &B = plan_.shapes[c.shape_b];
      const Twist V_W = work_[B.link].twistAt(c.X_WP.p) - work_[A.link].twistAt(c.X_WP.p);
      remember(c.volume, V_W.rotated(c.X_WP.R.transpose()), c.X_WP.p, c.force.F_BP_P.rotated(c.X_WP.R),
               state_.pairs[c.pair].release);
    }
    for (const ImplicitCoupling& coupling : implicit_->couplings()) {
      if (coupling.link < 0 || islands_->of(plan_.links[coupling.link].articulation) != islands_->of(island.trees[0]))
        continue;
      work_[coupling.link].addWrench(coupling.F_W, work_[coupling.link].X_WL.p);
    }
  }
  for (int n = 0; n < island.tree_count; ++n) {
    const PlanTree& tree = plan_.trees[island.trees[n]];
    has_kick_ = false;
    tree.has_laws ? gatherPull(tree, h) : readTree(tree, state_.pull.data() + tree.v);
    state_.mode[island.trees[n]] = kPrimed;
  }
}

}  // namespace haptic
