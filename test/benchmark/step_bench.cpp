/// `./run bench step`: what a step costs and errs in motion, and on what its bits depend.
///
/// An argument runs one part: motions (or a motion's name), bits, cases.
#include <cstring>

#include "step_figures.h"

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const char* part = argc > 1 ? argv[1] : nullptr;
  const auto is = [part](const char* name) { return part && std::strcmp(part, name) == 0; };
  if (!is("bits") && !is("cases")) runMotions(is("motions") ? nullptr : part);
  if (!part || is("bits")) runBits();
  if (!part || is("cases")) runCases();
  return 0;
}
