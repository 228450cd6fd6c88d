/// Forces as a world reports them.
#pragma once
#include "haptic_core/world/world.h"

namespace haptic::scenes {

/// Force of the contacts on a link, mean over the last step [N].
inline Vector3 reportedForceOn(const World& world, int link) {
  Vector3 F = Vector3::Zero();
  for (int c = 0; c < world.contactCount(); ++c) {
    const ContactReport& contact = world.contact(c);
    if (contact.link_b == link) F += contact.F_BP_W.force;
    if (contact.link_a == link) F -= contact.F_BP_W.force;
  }
  return F;
}

}  // namespace haptic::scenes
