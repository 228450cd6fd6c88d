// libFuzzer's entry; the fault benchmark runs the same target on a bounded random corpus.
#include "protocol_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  haptic::fuzzOne(bytes, size);
  return 0;
}
