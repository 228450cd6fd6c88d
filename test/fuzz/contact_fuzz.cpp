// libFuzzer's entry; the benchmark of contacts and a unit test run the same target on random bytes.
#include "contact_fuzz.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (const char* what = haptic::fuzz::contactViolation(data, size)) {
    std::fprintf(stderr, "%s\n", what);
    std::abort();
  }
  return 0;
}
