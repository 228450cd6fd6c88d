/// `./run bench step`: what a step costs and errs in motion, and on what its bits depend.
///
/// An argument runs one part: motions (or a motion's name), bits, cases, accuracy, shaken, plough (or the name of one of its runs).
#include <cstring>

#include "step_figures.h"

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const char* part = argc > 1 ? argv[1] : nullptr;
  const auto is = [part](const char* name) { return part && std::strcmp(part, name) == 0; };
  const bool ploughs = part && std::strncmp(part, "plough", 6) == 0;
  if (!is("bits") && !is("cases") && !is("accuracy") && !is("shaken") && !ploughs) runMotions(is("motions") ? nullptr : part);
  if (!part || is("bits")) runBits();
  if (!part || is("cases")) runCases();
  if (!part || is("accuracy")) runAccuracy();
  if (!part || is("shaken")) runShaken();
  if (!part || ploughs) runPloughs(is("plough") ? nullptr : part);
  return 0;
}
