/// Which program this is, and which of its libraries the loader has chosen.
#pragma once
#include <string>

namespace haptic {

std::string programVersion();  ///< "haptic_core 0.3.0"
/// The library that runs: "x86-64-v3", or "baseline", which runs on any processor. Both give the same bits.
std::string libraryLevel();
/// Compiler, its version, library, optimisation; and, behind "bits", the arithmetic: programs of one version whose arithmetic has
/// one name give the same bits, whatever else is different.
std::string buildFlags();
/// True if a program of this version with these `buildFlags` gives the bits of this one.
bool sameBits(const std::string& program, const std::string& flags);

}  // namespace haptic
