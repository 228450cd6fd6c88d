/// `./run bench dynamics`: accuracy of each scene against its exact or converged solution, and speed.
/// An argument runs only the parts whose name contains it.
#include <cstring>

#include "dynamics_figures.h"

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const struct {
    const char* name;
    void (*run)();
  } parts[] = {{"rest", restAndBounce},     {"tilt", tiltedCube},          {"top", spinningTop},
               {"free", freeRotation},      {"stickslip", stickSlip},      {"slope", slopeAndSliding},
               {"spin", spinFriction},      {"stacks", stacks},            {"allocations", allocations}, {"peers", peers}};
  for (const auto& part : parts) {
    if (argc < 2 || std::strstr(part.name, argv[1])) part.run();
  }
}
