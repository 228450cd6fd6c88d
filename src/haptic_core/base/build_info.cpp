#include "haptic_core/base/build_info.h"

namespace haptic {

std::string programVersion() { return std::string("haptic_core ") + HAPTIC_CORE_VERSION; }

std::string buildFlags() {
  std::string text = "c++ " __VERSION__;
#if defined(__AVX512F__)
  text += ", avx512";
#elif defined(__AVX2__)
  text += ", avx2";
#elif defined(__AVX__)
  text += ", avx";
#elif defined(__x86_64__)
  text += ", x86-64";
#endif
#ifdef __FMA__
  text += ", fma";
#endif
#ifdef NDEBUG
  text += ", release";
#else
  text += ", debug";
#endif
#ifdef __FAST_MATH__
  text += ", fast-math";
#endif
  return text;
}

}  // namespace haptic
