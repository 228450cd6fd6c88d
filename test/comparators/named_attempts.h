/// The sets of attempts that methods are compared by, with the names that figures, tests and the report give them.
#pragma once
#include "haptic_core/world/attempts.h"

namespace haptic::comparators {

/// A row of `kNamedAttempts`.
struct NamedAttempts {
  Attempts attempts;  ///< that the method has
  const char* name;   ///< of the method
};

inline constexpr NamedAttempts kNamedAttempts[] = {
    {Attempts::kVerlet, "verlet"}, {Attempts::kImplicitEuler, "implicit"}, {Attempts::kSdirk2, "sdirk2"}, {Attempts::kAll, "automatic"}};

}  // namespace haptic::comparators
