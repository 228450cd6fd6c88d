#include "haptic_core/stepping/frozen_problem.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/world/counted_work.h"

namespace haptic {
namespace {

constexpr int kAside = 256;            ///< patches kept beside those of the pairs that touch; further ones are dropped
constexpr int kMostSearch = 12;       ///< evaluations of the frozen forces on one line
constexpr double kSufficient = 0.1;   ///< the root of φ is found when |φ(α)| falls to this share of |φ(0)|
/// A full step that leaves this share of its slope ends the pass: another one would move by as much, less than the next
/// pass will. Unless it misses that share of a speed by the force on one body of several: the slope is the part's, and a heavy
/// body's hides a light one's.
constexpr double kStraight = 0.02;
/// Share of friction's change of load that a Newton step may miss [1].
constexpr double kLoadError = 1e-4;
/// Over what the energy falls by in the step that keeps friction's limits: by so much it may rise in the one that follows them, which it
/// does where bodies wedge. With 0 a heap of 30 leaves 102 of 600 steps unconverged at 1e13 N/m³ in place of 14; with 1 feet at
/// 1e17 N/m³ are wrong by three times as much.
constexpr double kRises = 0.1;
constexpr double kPull = 1e-10;       ///< share of the largest force by which a contact may pull: rounding
constexpr double kShort = 0.2;        ///< a Newton step below this share of the pass's change ends the pass

/// Contacts and forces of a pass at most.
int joinsOf(const Model& model) {
  return model.pair_capacity + kAside + static_cast<int>(model.pointers.size() + model.forces.size());
}

}  // namespace

FrozenProblem::FrozenProblem(const Model& model)
    : model_(model), parts_(model.trees.size(), static_cast<std::size_t>(joinsOf(model))), matrix_(model, joinsOf(model)),
      load_solver_(static_cast<std::size_t>(model.pair_capacity + kAside)) {
  node_of_tree_.assign(model.trees.size(), -1);
  for (auto* x : {&remainder_, &energy_remainder_}) x->resize(model.trees.size());
  for (auto* x : {&v_reference_, &r_reference_, &smooth_, &residual_, &step_, &loaded_, &trial_, &rows_}) x->resize(model.nv);
  contacts.reserve(model.pair_capacity + kAside);
  slid_load_.resize(static_cast<std::size_t>(model.pair_capacity + kAside));
  forces.reserve(static_cast<int>(model.pointers.size() + model.forces.size()));
  joined_.resize(static_cast<std::size_t>(joinsOf(model)));
}

void FrozenProblem::select(const Island& island, LinkWork* work, ImplicitJoints* joints) noexcept {
  for (int n = 0; n < island_.tree_count; ++n) node_of_tree_[island_.trees[n]] = -1;
  island_ = island;
  for (int n = 0; n < island.tree_count; ++n) node_of_tree_[island.trees[n]] = n;
  work_ = work;
  joints_ = joints;
  if (joints) joints->setNodes(node_of_tree_, island.tree_count);
  contacts.clear();
  forces.clear();
}

void FrozenProblem::forget() noexcept {
  island_ = Island{};
  std::fill(node_of_tree_.begin(), node_of_tree_.end(), -1);
}

void FrozenProblem::freezeTree(int t, const double* v, const double* residual) noexcept {
  const ModelTree& tree = model_.trees[t];
  const int nv = tree.model->nv();
  std::copy_n(v + tree.v, nv, v_reference_.begin() + tree.v);
  std::copy_n(residual + tree.v, nv, r_reference_.begin() + tree.v);
  matrix_.freeze(t, work_);
}

double FrozenProblem::speedOf(int t, const double* velocity) const noexcept {
  const ModelTree& tree = model_.trees[t];
  const double size = model_.links[tree.link].size;
  const double* u = velocity + tree.v;
  double largest2 = 0;
  if (tree.model->isFreeBody()) {
    const double turn2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], way2 = u[3] * u[3] + u[4] * u[4] + u[5] * u[5];
    largest2 = way2 + size * size * turn2;
  } else {
    for (int i = 0; i < tree.model->nv(); ++i) largest2 = std::max(largest2, size * size * u[i] * u[i]);
  }
  return std::sqrt(largest2);
}

double FrozenProblem::speed(const double* velocity) const noexcept {
  double largest = 0;
  for (int n = 0; n < island_.tree_count; ++n) largest = std::max(largest, speedOf(island_.trees[n], velocity));
  return largest;
}

void FrozenProblem::select(int p) noexcept {
  part_ = parts_.part(p);
  matrix_.select(part_, work_);
}

Twist FrozenProblem::linkTwist(int link, const Vector3& p_W, const double* u) const noexcept {
  if (nodeOf(link) < 0) return {};
  const ModelTree& tree = model_.trees[model_.links[link].articulation];
  if (!tree.model->isFreeBody()) {
    return pointTwist(*tree.model, work_ + tree.link, model_.links[link].local, p_W, u + tree.v);
  }
  const Eigen::Map<const Vector3> turn(u + tree.v), way(u + tree.v + 3);
  return {turn, way + turn.cross(p_W - work_[link].p_WO)};
}

Vector6 FrozenProblem::twistOf(const FrozenContact& c, const double* u) const noexcept {
  const Twist V = linkTwist(c.link_b, c.X_WP.p, u) - linkTwist(c.link_a, c.X_WP.p, u);
  return V.rotated(c.X_WP.R.transpose()).vector();
}

Twist FrozenProblem::twistOf(const FrozenForce& c, const double* u) const noexcept {
  const Twist V = linkTwist(c.link_b, c.p_WB, u);
  return moves(c.link_a) ? V - linkTwist(c.link_a, c.p_WA, u) : V;
}

/// rows += Jᵀ F.
void FrozenProblem::addForce(int link, const Wrench& F_W, const Vector3& p_W, double* rows) const noexcept {
  if (nodeOf(link) < 0) return;
  const ModelTree& tree = model_.trees[model_.links[link].articulation];
  if (!tree.model->isFreeBody()) {
    addGeneralisedForce(*tree.model, work_ + tree.link, model_.links[link].local, F_W, p_W, rows + tree.v);
    return;
  }
  Eigen::Map<Vector3> torque(rows + tree.v), force(rows + tree.v + 3);
  torque += F_W.torque + (p_W - work_[link].p_WO).cross(F_W.force);
  force += F_W.force;
}

/// rows += Jᵀ F of a wrench on B at P, in P's axes.
void FrozenProblem::addContact(const FrozenContact& c, const Vector6& F_BP_P, double* rows) const noexcept {
  const Wrench F_W = Wrench{F_BP_P.head<3>(), F_BP_P.tail<3>()}.rotated(c.X_WP.R);
  addForce(c.link_b, F_W, c.X_WP.p, rows);
  addForce(c.link_a, -F_W, c.X_WP.p, rows);
}

/// The same of a wrench on B at its point, and the opposite on A at its own.
void FrozenProblem::addBetween(const FrozenForce& c, const Wrench& F_W, double* rows) const noexcept {
  addForce(c.link_b, F_W, c.p_WB, rows);
  if (c.link_a >= 0) addForce(c.link_a, -F_W, c.p_WA, rows);
}

/// r + M δ into `smooth_`, δ into `trial_`, and of forces Σ Jᵀ (C J δ - g F_r).
void FrozenProblem::smoothPart(double g, const double* v) noexcept {
  inertialPart(v);
  if (part_.force_count > 0) linearForces(g);
}

void FrozenProblem::inertialPart(const double* v) noexcept {
  for (int n = 0; n < part_.tree_count; ++n) {
    const ModelTree& tree = treeAt(n);
    const double* M = matrix_.massOf(part_.trees[n]);
    const int nv = matrix_.sizeAt(n);
    for (int i = tree.v; i < tree.v + nv; ++i) {
      trial_[i] = v[i] - v_reference_[i];
      smooth_[i] = r_reference_[i];
    }
    if (nv == 6) {
      Eigen::Map<Vector6>(smooth_.data() + tree.v) += Eigen::Map<const Matrix6>(M) * Eigen::Map<const Vector6>(trial_.data() + tree.v);
      continue;
    }
    for (int j = 0; j < nv; ++j) {
      for (int i = 0; i < nv; ++i) smooth_[tree.v + i] += M[i + j * nv] * trial_[tree.v + j];
    }
  }
}

void FrozenProblem::linearForces(double g) noexcept {
  eachForce([&](const FrozenForce& c) {
    const Twist V = twistOf(c, trial_.data());
    addBetween(c, Wrench{c.turn * V.angular, c.way * V.linear} - c.F * g, smooth_.data());
  });
}

/// Largest wrench out of balance in the part [N], moments over the body's size.
double FrozenProblem::imbalance(double g) const noexcept {
  double largest = 0;
  for (int n = 0; n < part_.tree_count; ++n) {
    const ModelTree& tree = treeAt(n);
    const double size = model_.links[tree.link].size;
    for (int i = 0; i < matrix_.sizeAt(n); ++i) {
      const bool moment = !tree.model->isFreeBody() || i < 3;
      largest = std::max(largest, std::abs(residual_[tree.v + i]) / (g * (moment ? size : 1.0)));
    }
  }
  return largest;
}

PassEnd FrozenProblem::solve(double g, int most, double finest, double enough, const std::vector<char>& moved, const double* q,
                             double* v) noexcept {
  PassEnd end;
  const auto treesOf = [this](const auto& c) {
    const auto treeOf = [this](int link) { return moves(link) ? model_.links[link].articulation : -1; };
    return TreePair{treeOf(c.link_a), treeOf(c.link_b)};
  };
  for (int i = 0; i < contacts.size(); ++i) joined_[i] = treesOf(contacts[i]);
  for (int i = 0; i < forces.size(); ++i) joined_[contacts.size() + i] = treesOf(forces[i]);
  const bool together = joints_ != nullptr;  // what joints do is solved for all trees at once
  parts_.find(island_, joined_.data(), contacts.size(), forces.size(), together);
  for (int p = 0; p < parts_.count(); ++p) {
    select(p);
    const int first = part_.trees[0];
    if (std::any_of(part_.trees, part_.trees + part_.tree_count, [&](int t) { return moved[t] != 0; })) {
      const PassEnd of_part = solvePart(g, most, finest, enough, q, v);
      remainder_[first] = of_part.remainder;
      energy_remainder_[first] = of_part.energy_remainder;
      end.solved &= of_part.solved;
      end.iterations = std::max(end.iterations, of_part.iterations);
      end.factorisations = std::max(end.factorisations, of_part.factorisations);
      end.units += of_part.units;
      end.decrement += of_part.decrement;
      end.imbalance = std::max(end.imbalance, of_part.imbalance);
    }
    end.remainder = std::max(end.remainder, remainder_[first]);
    end.energy_remainder += energy_remainder_[first];
  }
  return end;
}

PassEnd FrozenProblem::solvePart(double g, int most, double finest, double enough, const double* q, double* v) noexcept {
  PassEnd end;
  smoothPart(g, v);
  bool at_reference = true;  // trial_ holds δ
  eachVelocity([&](int k) { at_reference &= trial_[k] == 0; });
  eachContact([&](FrozenContact& c) {
    c.ends_here = false;
    c.V = at_reference ? c.V_reference : Vector6(c.V_reference + twistOf(c, trial_.data()));
    if (at_reference && c.V == c.V_frozen && c.patch.evaluateAtReference(c.V, c.force)) return;
    c.patch.evaluate(c.V, c.force);
  });
  eachForce([&](FrozenForce& c) {
    c.gained = c.line.n.dot(twistOf(c, trial_.data()).linear);
    c.force = c.lineAt(c.gained, g);
  });
  double changed = 0, open = 1;
  for (int i = 0; i < most; ++i) {
    if (i > 0) {
      smoothPart(g, v);
      eachContact([](FrozenContact& c) {  // the search has left the forces of this V
        const bool turned_over = c.force.friction.outside && c.slid.head<2>().dot(c.force.friction.force.head<2>()) < 0;
        if (turned_over) c.patch.stick(c.V, c.force);
      });
    }
    eachContact([](FrozenContact& c) {
      const FrictionLayer::Hold& friction = c.force.friction;
      c.slid = friction.outside ? friction.force : Vector3(Vector3::Zero());
    });
    eachVelocity([this](int k) { residual_[k] = smooth_[k]; });
    eachContact([&](const FrozenContact& c) { addContact(c, -g * c.force.F, residual_.data()); });
    eachForce([&](const FrozenForce& c) {
      if (c.lined) addBetween(c, {Vector3::Zero(), -g * c.force * c.line.n}, residual_.data());
    });
    if (i == 0) end.imbalance = imbalance(g);
    end.solved = matrix_.assemble(part_, contacts, forces, g);
    if (!end.solved) return end;
    ++end.factorisations;
    end.units += units::kProduct * matrix_.blocks().products() + units::kRow * (part_.tree_count + part_.contact_count + part_.force_count);
    end.solved = findStep(g, q, v, open);
    if (!end.solved) return end;
    ++end.iterations;
    double size = 0;
    for (int n = 0; n < part_.tree_count; ++n) size = std::max(size, speedOf(part_.trees[n], step_.data()));
    if (i == 0) end.decrement = -dot(residual_, step_);
    double left = 0;
    const double alpha = size <= finest ? 1.0 : search(g, v, left);
    eachVelocity([&](int k) { v[k] += alpha * step_[k]; });
    if (alpha == 1 && joints_) joints_->settle(v);
    eachContact([&](FrozenContact& c) {
      c.V += alpha * c.step;
      c.ends_here = size > finest;  // else `search` has not looked there
      if (alpha < 1) c.F_done = c.force.F;  // nothing explains this motion; the passes are not at their end
    });
    eachForce([&](FrozenForce& c) {
      c.gained += alpha * c.step;
      if (alpha < 1) c.done = c.force;
    });
    open *= 1 - alpha;
    changed += alpha * size;
    const double share = size <= finest ? 0 : alpha == 1 ? std::abs(left) : 1;
    const double beyond = speedBeyondLimit(g);
    end.remainder = std::max(alpha < 1 ? changed + (1 - alpha) * size : share * size, beyond);
    end.energy_remainder = share * -dot(residual_, step_);
    if (anyPulls()) continue;
    if (size <= finest || (i > 0 && size < kShort * changed)) break;
    if (alpha != 1 || std::abs(left) > kStraight) continue;
    double missed = beyond;
    if (part_.tree_count > 1) {
      eachContact([&](const FrozenContact& c) {
        missed = std::max(missed, missedSpeed(c.link_a, c.link_b, (c.force.F - c.F_done).tail<3>().norm(), g));
      });
      eachForce([&](const FrozenForce& c) { missed = std::max(missed, missedSpeed(c.link_a, c.link_b, std::abs(c.force - c.done), g)); });
    }
    if (missed <= std::max(enough, kStraight * size)) break;
  }
  return end;
}

/// By the last Newton step, before its share: the next one opens it.
bool FrozenProblem::anyPulls() noexcept {
  double pressed = 0, pulled = 0;
  eachContact([&](const FrozenContact& c) { pressed = std::max(pressed, c.F_done[5]), pulled = std::max(pulled, c.pulled); });
  return pulled > kPull * pressed;
}

/// Where a Newton step took friction for another than N allows, or a contact to pull, it misses that as a speed, however stiff N is:
/// sliding friction answers no motion, and a contact that opens does not [m/s].
double FrozenProblem::speedBeyondLimit(double g) noexcept {
  double most = 0;
  eachContact([&](const FrozenContact& c) {
    const double missed = std::max(c.pulled, c.patch.missedFriction(c.V, c.F_done).norm());
    most = std::max(most, missedSpeed(c.link_a, c.link_b, missed, g));
  });
  return most;
}

/// Speed that a force gives at the end of a full Newton step if it is `missed` [N] more than the step took it for [m/s].
double FrozenProblem::missedSpeed(int link_a, int link_b, double missed, double g) const noexcept {
  const double mass = link_a >= 0 ? std::min(massOf(link_a), massOf(link_b)) : massOf(link_b);
  return g / mass * missed;
}

/// Newton's step into step_ and the contacts, with the joints' own laws. `open`: share of the gaps of loops that is left.
bool FrozenProblem::findStep(double g, const double* q, const double* v, double open) noexcept {
  if (joints_) {
    if (!joints_->solve(matrix_.blocks(), work_, q, v, residual_.data(), open, step_.data())) return false;
  } else {
    if (!matrix_.blocks().factor()) return false;
    stepFor(residual_, v, step_);
  }
  eachContact([&](FrozenContact& c) {
    c.step = twistOf(c, step_.data());
    c.F_done = c.force.F;
    c.per_load = c.patch.perLoad(c.V, c.force);
  });
  followLoad(g, v);
  eachForce([&](FrozenForce& c) {
    c.step = c.line.n.dot(twistOf(c, step_.data()).linear);
    c.done = c.force - c.lineSlope(g) / g * c.step;
  });
  return true;
}

/// The step for a residual on the factor at hand, of joints that stay on their pieces.
void FrozenProblem::stepFor(const std::vector<double>& residual, const double* v, std::vector<double>& step) noexcept {
  if (joints_) {
    joints_->solveAgain(matrix_.blocks(), v, residual.data(), step.data());
    return;
  }
  int row = 0;
  eachVelocity([&](int k) { rows_[row++] = -residual[k]; });
  matrix_.blocks().solve(rows_.data());
  row = 0;
  eachVelocity([&](int k) { step[k] = rows_[row++]; });
}

/// Takes step_ from A p = -R to A p + Σ Jᵀ b y = -R with y = nᵀ G J p of the patches that slide, -g times the change of their N in the
/// step: y is found by GMRES (base/gmres.h), each vector a solve on the factor at hand, and then p. A full step is the motion under exactly
/// F_done, linear in it. With one vector two patches that slide on one body, as of a wedge, jammed from 1e11 N/m³ on.
void FrozenProblem::followLoad(double g, const double* v) noexcept {
  const auto loadOf = [](const FrozenContact& c) { return c.G.row(5).dot(c.step); };
  int sliding = 0;
  double norm2 = 0;
  eachContact([&](const FrozenContact& c) {
    if (c.per_load.isZero(0)) return;
    slid_load_[sliding++] = loadOf(c);
    norm2 += loadOf(c) * loadOf(c);
  });
  bool follows = norm2 > 0;
  if (follows) {
    load_solver_.solve(sliding, kLoadError, [&](const double* y, double* left) { missedLoad(v, y, left); }, slid_load_.data());
    stepUnder(slid_load_.data(), v, loaded_);
    follows = dot(residual_, loaded_) < -kRises * dot(residual_, step_);
    if (follows) step_.swap(loaded_);
    if (!follows && joints_) stepFor(residual_, v, step_);  // their forces are those of the last step that was solved
  }
  sliding = 0;
  eachContact([&](FrozenContact& c) {
    const double y = !follows || c.per_load.isZero(0) ? 0 : slid_load_[sliding++];
    if (follows) c.step = twistOf(c, step_.data());
    c.F_done -= (c.G * c.step + y * c.per_load) / g;
    c.pulled = std::max(0.0, -c.F_done[5]);
  });
}

/// The step where friction's limits go with y, by patches that slide.
void FrozenProblem::stepUnder(const double* y, const double* v, std::vector<double>& step) noexcept {
  eachVelocity([this](int k) { trial_[k] = residual_[k]; });
  eachContact([&](const FrozenContact& c) {
    if (!c.per_load.isZero(0)) addContact(c, *y++ * c.per_load, trial_.data());
  });
  stepFor(trial_, v, step);
}

/// y less the change of nᵀ G J p by it.
void FrozenProblem::missedLoad(const double* v, const double* y, double* left) noexcept {
  stepUnder(y, v, loaded_);
  eachContact([&](const FrozenContact& c) {
    if (!c.per_load.isZero(0)) *left++ = *y++ - c.G.row(5).dot(twistOf(c, loaded_.data()) - c.step);
  });
}

template <class Visit>
void FrozenProblem::eachVelocity(Visit&& visit) const noexcept {
  for (int n = 0; n < part_.tree_count; ++n) {
    const int first = treeAt(n).v;
    for (int k = first; k < first + matrix_.sizeAt(n); ++k) visit(k);
  }
}

/// Over the part.
double FrozenProblem::dot(const std::vector<double>& a, const std::vector<double>& b) const noexcept {
  double sum = 0;
  eachVelocity([&](int k) { sum += a[k] * b[k]; });
  return sum;
}

double FrozenProblem::massNorm2(const double* u) const noexcept {
  return matrix_.massNorm2(island_.trees, island_.tree_count, u);
}

/// pᵀ (M + Σ Jᵀ C J) p.
double FrozenProblem::curvature() noexcept {
  double sum = matrix_.massNorm2(part_.trees, part_.tree_count, step_.data());
  eachForce([&](const FrozenForce& c) {
    const Twist V = twistOf(c, step_.data());
    sum += V.angular.dot(c.turn * V.angular) + V.linear.dot(c.way * V.linear);
  });
  return sum;
}

/// φ(α); leaves the forces of v + α p behind.
double FrozenProblem::slopeAt(double g, double alpha, double along, double curvature, const double* v) noexcept {
  double phi = along + alpha * curvature;
  eachContact([&](FrozenContact& c) {
    c.patch.evaluate(c.V + alpha * c.step, c.force);
    phi -= g * c.force.F.dot(c.step);
  });
  eachForce([&](FrozenForce& c) {
    c.force = c.lineAt(c.gained + alpha * c.step, g);
    if (c.lined) phi -= g * c.force * c.step;
  });
  if (!joints_) return phi;
  eachVelocity([&](int k) { trial_[k] = v[k] + alpha * step_[k]; });
  if (alpha == 1) joints_->settle(trial_.data());
  return phi + joints_->slope(trial_.data(), step_.data());
}

/// The α ≤ 1 with φ(α) ≈ 0, from φ(0) < 0. Beyond 1 the next direction knows more. `left`: φ(1)/φ(0).
double FrozenProblem::search(double g, const double* v, double& left) noexcept {
  const double along = dot(smooth_, step_);
  double phi_0 = dot(residual_, step_);
  if (joints_) phi_0 += joints_->slope(v, step_.data());
  const double bend = curvature();
  double alpha = 1, phi = slopeAt(g, 1, along, bend, v);
  left = phi_0 < 0 ? phi / phi_0 : 1;
  // With loops that do not close yet φ may start upwards: closing them comes first.
  if (!(phi_0 < 0) || phi <= kSufficient * -phi_0) return alpha;
  // Each guess takes half of the other end's weight, so that the next one lies on its far side: that ends well within the interval,
  // where a search that closes in on the root (base/bracket) ends on either rim of the sufficient range. With that one a cube that
  // slides at 1e12 N/m³ stuck for a step.
  double low = 0, phi_low = phi_0, high = 1, phi_high = phi;
  for (int i = 0; i < kMostSearch && std::abs(phi) > kSufficient * -phi_0; ++i) {
    const double secant = low + (high - low) * phi_low / (phi_low - phi_high);
    alpha = std::clamp(secant, low + 0.1 * (high - low), high - 0.1 * (high - low));
    phi = slopeAt(g, alpha, along, bend, v);
    if (phi < 0) {
      low = alpha;
      phi_low = phi;
      phi_high *= 0.5;
    } else {
      high = alpha;
      phi_high = phi;
      phi_low *= 0.5;
    }
  }
  return alpha;
}

}  // namespace haptic
