/// Motion of a tree without contact, to fourth or fifth order. Nothing here allocates (in realtime).
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {

/// Merson: order 4, five evaluations (Proc. Symp. Data Processing, Salisbury 1957). Dormand–Prince: order 5,
/// six evaluations (J. Comput. Appl. Math. 6, 1980, table 2). Energy drift of a chain of 10 links over 5 s at
/// 1 ms, of m g L n²/2: 4e-6 and 9e-8; the classical formula with its four evaluations 1.3e-5.
enum class TreeFormula : unsigned char { kMerson, kDormandPrince };

/// Doubles of scratch that stepRungeKutta needs.
int rungeKuttaScratch(const Articulation& articulation);

/// One step h of a tree. Wrenches in work[i].F_ext at the call are kept through the step, about O, constant
/// in W; `tau` (null: none) likewise. A free body without tau takes stepFreeBody. Explicit: nothing stiff in
/// it. Floating trees that no wrench pulls keep their momentum exactly
/// (free_momentum.h). On return `work` belongs to a stage, not to the new state.
void stepRungeKutta(const Articulation& articulation, const Vector3& gravity, const double* tau, double h,
                    double* q, double* v, LinkWork* work, double* scratch,
                    TreeFormula formula = TreeFormula::kDormandPrince) noexcept;

}  // namespace haptic
