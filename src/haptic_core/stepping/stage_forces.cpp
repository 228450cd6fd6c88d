#include "haptic_core/stepping/stage_forces.h"

#include <algorithm>

namespace haptic::stepping {
namespace {

/// Index of the element that a force of the problem is made of; negative: it is a coupling's.
int elementOf(const FrozenForce& frozen, const StageForces& forces) noexcept {
  return frozen.source - static_cast<int>(forces.couplings.size());
}

/// Mean velocity over the step of a point of a link that a hand leads.
Twist ledTwist(const HeldLinks& held, const LinkWork* links, int link, const Vector3& p_W) noexcept {
  const Twist way = ledWay(held, links, link, p_W);
  return {way.angular / held.step, way.linear / held.step};
}

/// Of hands that lead an end of the element.
double suppliedTo(const LinkForce& now, const FrozenForce& frozen, const HeldLinks& held, const LinkWork* links) noexcept {
  const Wrench F_W = now.onB();
  return power(F_W, ledTwist(held, links, frozen.link_a, now.p_WA)) - power(F_W, ledTwist(held, links, frozen.link_b, now.p_WB));
}

/// Powers of the force elements at their references, carried by u in a stage of length g; null: not carried.
ForcePower powerOf(const FrozenProblem& problem, const HeldLinks& held, const LinkWork* links, double g, const double* u,
                   const StageForces& forces) noexcept {
  ForcePower sum;
  for (const FrozenForce& frozen : problem.forces) {
    const int element = elementOf(frozen, forces);
    if (element < 0) continue;
    LinkForce now = forces.element[element];
    if (u) {
      const Twist V = problem.twistOf(frozen, u);
      const double gained = now.line.n.dot(V.linear);
      now.V = now.V + V;
      now.line.spring -= g * now.line.stiffness * gained;
      now.line.damper -= now.line.damping * gained;
      now.F = now.F - Wrench{frozen.turn * V.angular, frozen.way * V.linear} * (1 / g);
    }
    sum.taken += now.taken();
    sum.supplied += suppliedTo(now, frozen, held, links);
  }
  return sum;
}

/// Of the origin of the pointer's frame.
Twist twistOf(const ImplicitCoupling& coupling, const LinkWork* links) noexcept {
  const LinkWork& link = links[coupling.link];
  return link.twistAt(link.X_WL * coupling.X_LP.p);
}

/// The target moves at its own velocity, so that a stage inside the step sees it where it is then, `left` before the end.
void pull(double left, LinkWork& link, ImplicitCoupling& coupling) noexcept {
  HeldGoal then = coupling.target;
  then.p_WL -= left * then.V_WL.linear;
  then.q_WL = rotationFromVector(-left * then.V_WL.angular) * then.q_WL;
  coupling.F_W = couplingForce(coupling.law, coupling.X_LP, then, link);
  link.addWrench(coupling.F_W, link.X_WL * coupling.X_LP.p);
}

}  // namespace

void selectForces(const Model& model, const Island& island, const HeldLinks& held, const LinkWork* links, FrozenProblem& problem,
                  StageForces& forces) noexcept {
  FrozenForce frozen;
  for (std::size_t i = 0; i < forces.couplings.size(); ++i) {
    frozen.source = static_cast<int>(i);
    frozen.link_b = forces.couplings[i].link;
    if (problem.moves(frozen.link_b)) problem.forces.push_back(frozen);
  }
  forces.any = false;
  forces.stored = 0;
  const auto moves = [&](int tree) { return problem.moves(model.trees[tree].link); };
  eachForce(model, TreeRange{island.trees, island.tree_count}, moves, [&](int i, const ModelForce& force) {
    forces.any = true;
    frozen.source = static_cast<int>(forces.couplings.size()) + i;
    frozen.link_a = force.link_a;
    frozen.link_b = force.link_b;
    problem.forces.push_back(frozen);
    forces.element[i] = forceNow(model, force, links);
  });
  if (forces.any) forces.power = powerOf(problem, held, links, 0, nullptr, forces);
}

void freezeForces(const Model& model, const std::vector<char>& moved, double g, double left, LinkWork* links, FrozenProblem& problem,
                  StageForces& forces) noexcept {
  const auto hasMoved = [&](int link) { return problem.moves(link) && moved[model.links[link].articulation]; };
  forces.stored = 0;
  for (FrozenForce& frozen : problem.forces) {
    const int element = elementOf(frozen, forces);
    const bool moves_on = hasMoved(frozen.link_b) || hasMoved(frozen.link_a);
    if (element >= 0) {
      LinkForce& force = forces.element[element];
      if (moves_on) force = forceNow(model, model.forces[element], links);
      if (moves_on) frozen.freeze(force, g, true);
      forces.stored += force.stored;
      continue;
    }
    if (!moves_on) continue;
    ImplicitCoupling& coupling = forces.couplings[frozen.source];
    LinkWork& link = links[frozen.link_b];
    const Pose X_WP = link.X_WL * coupling.X_LP;
    const CouplingMatrices c = matricesOf(coupling.law, X_WP.R, coupling.target.q_WL.toRotationMatrix() * coupling.X_LP.R);
    LinkForce now;
    now.p_WA = now.p_WB = X_WP.p;
    now.turn_K = c.rotational_stiffness, now.turn_D = c.rotational_damping;
    now.way_K = c.stiffness, now.way_D = c.damping;
    frozen.freeze(now, g, false);
    pull(left, link, coupling);
  }
}

void carryForces(const FrozenProblem& problem, const HeldLinks& held, const LinkWork* links, double g, const double* u,
                 StageForces& forces) noexcept {
  for (const FrozenForce& frozen : problem.forces) {
    if (elementOf(frozen, forces) >= 0) break;  // couplings come first
    ImplicitCoupling& coupling = forces.couplings[frozen.source];
    const Twist V = problem.twistOf(frozen, u);
    coupling.F_W += Wrench{-(1 / g) * (frozen.turn * V.angular), -(1 / g) * (frozen.way * V.linear)};
    coupling.V_WP = twistOf(coupling, links) + V;
  }
  if (forces.any) forces.power = powerOf(problem, held, links, g, u, forces);
}

double addSupply(const FrozenProblem& problem, const HeldLinks& held, const LinkWork* links, const StageForces& forces,
                 double sum) noexcept {
  for (const FrozenForce& frozen : problem.forces) {
    const int element = elementOf(frozen, forces);
    sum += element < 0 ? power(forces.couplings[frozen.source].F_W, twistOf(forces.couplings[frozen.source], links))
                       : suppliedTo(forces.element[element], frozen, held, links);
  }
  return sum;
}

double addStored(const Model& model, const FrozenProblem& problem, const LinkWork* links, const StageForces& forces, double sum) noexcept {
  for (const FrozenForce& frozen : problem.forces) {
    const int element = elementOf(frozen, forces);
    if (element >= 0) sum += forceNow(model, model.forces[element], links).stored;
  }
  return sum;
}

bool bends(const FrozenProblem& problem, const StageForces& forces) noexcept {
  return std::any_of(problem.forces.begin(), problem.forces.end(), [&](const FrozenForce& frozen) {
    const int element = elementOf(frozen, forces);
    return element >= 0 && forces.element[element].bends;
  });
}

}  // namespace haptic::stepping
