#include "haptic_core/base/build_info.h"

namespace haptic {
namespace {

/// One arithmetic for all processors: a new name whenever a change of the build or of the hash (not of the algorithms) gives other bits.
constexpr char kArithmetic[] = "bits one-build-2";

}  // namespace

std::string programVersion() { return std::string("haptic_core ") + HAPTIC_CORE_VERSION; }

std::string libraryLevel() {
#ifdef __AVX2__
  return "x86-64-v3";
#else
  return "baseline";
#endif
}

std::string buildFlags() {
  std::string text = "c++ " __VERSION__ ", library " + libraryLevel();
#ifdef NDEBUG
  text += ", release";
#else
  text += ", debug";
#endif
  return text + ", " + kArithmetic;
}

bool sameBits(const std::string& program, const std::string& flags) {
  const std::string arithmetic = std::string(", ") + kArithmetic;
  return program == programVersion() && flags.size() > arithmetic.size() &&
         flags.compare(flags.size() - arithmetic.size(), arithmetic.size(), arithmetic) == 0;
}

}  // namespace haptic
