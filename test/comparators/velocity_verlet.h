/// Velocity Verlet with contacts, of whole worlds: v½ = v + h/2 a, q₁ = q ⊕ h v½, forces at (q₁, v½ + h/2 a), v₁ = v½ + h/2 a₁.
///
/// Second order and one evaluation as well, since a₁ is the next step's a. Forces jump or bend where a contact begins, ends or yields
/// inside the step; the impulse that h/2 (F₀ + F₁) then misses is computed from the located instant and added to the
/// second kick (located_force.cpp, friction.cpp, verlet_contacts.cpp), which keeps the order. Trees whose joints have laws of their own
/// move by TreeMotion, with the contact forces of the step's start. The step of a tree is in dynamics/tree_step.h.
///
/// `WorldSettings::comparator`; stable or not.
#pragma once
#include <memory>

#include "haptic_core/world/comparator.h"

namespace haptic::comparators {

std::unique_ptr<Comparator> velocityVerlet(const Model& model);  ///< with contact volumes
std::unique_ptr<Comparator> pointVerlet(const Model& model);     ///< with point contacts in their place (point_contact.h)

}  // namespace haptic::comparators
