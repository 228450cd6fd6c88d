/// The methods that ours is compared by, with the names that figures, tests and the report give them.
#pragma once
#include "haptic_core/world/definition.h"
#include "velocity_verlet.h"

namespace haptic::comparators {

/// A row of `kNamedAttempts`.
struct NamedAttempts {
  const char* name;                         ///< of the method
  Attempts attempts = Attempts::kAll;       ///< that it has
  MakeComparator comparator = nullptr;      ///< in their place

  /// Has a world step so.
  void into(WorldSettings& settings) const {
    settings.attempts = attempts;
    settings.comparator = comparator;
  }
};

inline constexpr NamedAttempts kVerlet{"verlet", Attempts::kAll, velocityVerlet};
inline constexpr NamedAttempts kNamedAttempts[] = {
    kVerlet, {"implicit", Attempts::kImplicitEuler}, {"sdirk2", Attempts::kSdirk2}, {"automatic", Attempts::kAll}};

}  // namespace haptic::comparators
