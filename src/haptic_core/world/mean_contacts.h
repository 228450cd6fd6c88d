/// Contacts of a step that went in parts: the report has the mean wrench over the whole step.
#pragma once
#include "haptic_core/world/report.h"

namespace haptic {

/// Sums over the parts. `F_BP_W` of an entry is an impulse [N·m·s, N·s] until the step ends.
struct PartContacts {
  LoadedVector<ContactReport> sums;  ///< one entry per pair
  bool any = false;  ///< parts of this step are in
};

/// (in realtime) Adds a part of length h [s]. Costs the number of contacts while they come in the same order, else its square.
void addPart(double h, PartContacts& parts, Report& report) noexcept;
/// (in realtime) The report of a step of length h [s] whose parts are in: each contact as it was last, with its mean wrench.
void reportParts(double h, PartContacts& parts, Report& report) noexcept;

}  // namespace haptic
