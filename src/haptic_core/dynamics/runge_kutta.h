/// Motion of a tree on which nothing pulls but gravity, to fourth order. Nothing here allocates (in realtime).
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {

/// Doubles of scratch that stepRungeKutta needs.
int rungeKuttaScratch(const Articulation& articulation);

/// One step h of a tree by Merson's formula: order 4, five evaluations (Proc. Symp. Data Processing, Salisbury 1957).
/// Energy drift of a chain of 10 links over 5 s at 1 ms, of m g L n²/2: 4e-6; the classical formula with its four
/// evaluations 1.3e-5. Explicit: nothing stiff in it. Floating trees keep their momentum exactly (free_momentum.h). On
/// return `work` belongs to a stage, not to the new state, and holds no wrenches.
void stepRungeKutta(const Articulation& articulation, const Vector3& gravity, double h, double* q, double* v,
                    LinkWork* work, double* scratch) noexcept;

}  // namespace haptic
