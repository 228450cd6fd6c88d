/// Whether a surface is still there, and slow, when a scripted hand comes to touch it.
#pragma once
#include "haptic_core/world/definition.h"

namespace haptic {

/// Whether the point p_W of a link's surface stays about where it is at the start. No: it moves faster there than a sphere of
/// 10 mm can follow; or its articulation touches no other at the start and, left to itself, leaves it: it falls, swings or
/// turns away. What touches something, or is closed to a loop, is taken to be carried. At set-up: steps the articulation alone.
bool staysPut(const WorldDef& world, int articulation, int link, const Vector3& p_W);

}  // namespace haptic
