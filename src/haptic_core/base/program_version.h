/// What every program answers to --version.
#pragma once
#include <cstdio>
#include <cstring>

#include "haptic_core/base/build_info.h"

namespace haptic {

/// Prints program, version and build if the arguments ask for them. True: printed; the program has nothing else to do.
inline bool toldVersion(int argc, char** argv, const char* program) {
  if (argc != 2 || std::strcmp(argv[1], "--version") != 0) return false;
  std::printf("%s, %s, %s\n", program, programVersion().c_str(), buildFlags().c_str());
  return true;
}

}  // namespace haptic
