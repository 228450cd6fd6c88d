/// The attempts that a step is chosen from.
#pragma once

namespace haptic {

/// Which attempts the rule of a step has (stepping/advance.h). A scene has all of them; tests, benches and the report compare with fewer.
enum class Attempts : unsigned char {
  kAll,            ///< flow where nothing touches, and BDF2, SDIRK2 and implicit Euler where something does
  kImplicitEuler,  ///< implicit Euler
  kSdirk2          ///< SDIRK2, with implicit Euler where it is not smooth
};

}  // namespace haptic
