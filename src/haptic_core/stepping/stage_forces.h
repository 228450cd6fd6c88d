/// Couplings of hands and force elements in an implicit stage: the list of a pass's linear forces (frozen_contact.h) is made of them, and
/// their wrenches and powers are read off it.
#pragma once
#include <vector>

#include "haptic_core/stepping/frozen_problem.h"
#include "haptic_core/stepping/held_links.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/model.h"

namespace haptic {

/// A spring-damper from a hand's target to a link: part of the solve, so that it may be as stiff as it likes.
struct ImplicitCoupling {
  PointerCoupling law;  ///< with nothing left to derive
  int link = -1;        ///< -1: no target yet, or the hand prescribes the motion
  Pose X_LP;            ///< the pointer's frame, at whose origin spring and damper act
  HeldGoal target;      ///< of the link at the end of the step
  Wrench F_W;           ///< on the link, about P's origin: at the end of the stage
  Twist V_WP;           ///< of P's origin then
};

}  // namespace haptic

namespace haptic::stepping {

/// Couplings and force elements of a stage. The problem's forces are first those of couplings, by pointer, then those of elements.
struct StageForces {
  std::vector<ImplicitCoupling> couplings;  ///< by pointer; the caller aims them
  std::vector<LinkForce> element;           ///< by element of the model: at its reference
  bool any = false;                         ///< force elements act on the island
  double stored = 0;                        ///< energy of the springs of the island's force elements at their references [J]
  /// Of the island's force elements: as they were found where it was selected, and since then as the last solve left them.
  ForcePower power;

  explicit StageForces(const Model& model) : couplings(model.pointers.size()), element(model.forces.size()) {}  ///< set-up: room for all
};

/// (in realtime) Lists the forces on the island that the problem moves; `links`: by link, where they are.
void selectForces(const Model& model, const Island& island, const HeldLinks& held, const LinkWork* links, FrozenProblem& problem,
                  StageForces& forces) noexcept;
/// (in realtime) Freezes those whose tree `moved`, by tree, at the links' places, in a stage of length g that ends `left` [s] before the
/// step does. A coupling's wrench goes to its link, and so into the residual.
void freezeForces(const Model& model, const std::vector<char>& moved, double g, double left, LinkWork* links, FrozenProblem& problem,
                  StageForces& forces) noexcept;
/// (in realtime) Carries couplings, and the power of force elements, from the reference to velocities that differ by u.
void carryForces(const FrozenProblem& problem, const HeldLinks& held, const LinkWork* links, double g, const double* u,
                 StageForces& forces) noexcept;

/// (in realtime) Power of hands on the island through couplings and led ends of elements, at the reference, added to `sum` [W].
double addSupply(const FrozenProblem& problem, const HeldLinks& held, const LinkWork* links, const StageForces& forces,
                 double sum) noexcept;
/// (in realtime) Energy of the springs of the island's force elements where the links are, added to `sum` [J].
double addStored(const Model& model, const FrozenProblem& problem, const LinkWork* links, const StageForces& forces, double sum) noexcept;
/// (in realtime) Whether the derivatives of a force element of the island change with the motion.
bool bends(const FrozenProblem& problem, const StageForces& forces) noexcept;

}  // namespace haptic::stepping
