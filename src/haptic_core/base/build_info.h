/// Which program this is: what must be equal for two runs to give the same bits.
#pragma once
#include <string>

namespace haptic {

std::string programVersion();  ///< "haptic_core 0.2.0"
std::string buildFlags();      ///< compiler, its version, instruction set, optimisation

}  // namespace haptic
