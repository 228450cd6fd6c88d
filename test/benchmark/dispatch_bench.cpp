// Contact, dynamics and a heap of ten, as `./run bench dispatch` times and counts them: compiled against this
// core and against an older one. `bench_dispatch [CASE]` prints CPU seconds of a fixed amount of work, by
// case; `bench_dispatch --count CASE` does it once where callgrind counts; `bench_dispatch --version` says
// which library runs.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <functional>
#include <memory>

#include "../scenes/heap.h"
#include "../scenes/motions.h"
#include "contact_scenes.h"
#include "haptic_core/base/build_info.h"
#if __has_include("haptic_core/geometry/volume/contact_workspace.h")
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#else  // of the release that it is compared with
#include "haptic_core/geometry/contact_workspace.h"
#endif
#include "instruction_count.h"

namespace haptic::bench {
namespace {

volatile double sink;

/// Passes over pairs of shapes whose caches are warm: detection, contact volume with all its moments.
std::function<void(int)> contacts(std::vector<Pair> (*make)(Scenes&)) {
  auto scenes = std::make_shared<Scenes>(1);
  auto pairs = std::make_shared<std::vector<Pair>>(make(*scenes));
  auto workspace = std::make_shared<ContactWorkspace>();
  for (const Pair& p : *pairs) workspace->reserve(*p.a, *p.b);
  return [=](int passes) {
    ContactVolume out;
    for (int i = 0; i < passes; ++i) {
      for (Pair& p : *pairs) {
        contactVolume(*p.a, *p.b, p.X_AB, p.cache, *workspace, out);
        sink = out.volume;
      }
    }
    (void)scenes;
  };
}

std::function<void(int)> steps(const WorldDef& def) {
  auto world = std::make_shared<World>(def);
  return [=](int count) {
    for (int i = 0; i < count; ++i) world->step();
    sink = world->linkPose(1).p.z();
  };
}

WorldSettings settings(double h) {
  WorldSettings s;
  s.step = h;
  return s;
}

WorldDef stack15() {
  scenes::CubeParameters c;
  c.stiffness = 1e7;
  c.ratio = c.tangential_ratio = 0.1;
  WorldSettings s = settings(0.25e-3);
  s.pressure_law = PressureLaw::kLinear;
  return scenes::stack(15, c, s);
}

WorldDef heap10() {
  scenes::HeapParameters p;
  p.count = 10;
  return scenes::heap(p, settings(1e-3));
}

struct Case {
  const char* name;
  std::function<void(int)> (*make)();
  int warm, timed, counted;  ///< how much: passes, or steps
};

const Case kCases[] = {
    {"contact_box", [] { return contacts([](Scenes& s) { return s.boxes(0.3, 1e-3); }); }, 100, 20000, 200},
    {"contact_box_aligned", [] { return contacts([](Scenes& s) { return s.boxes(0, 1e-3); }); }, 100, 20000,
     200},
    {"contact_hull100", [] { return contacts([](Scenes& s) { return s.hulls(3e-3); }); }, 2, 100, 2},
    {"dynamics_cube",
     [] {
       return steps(
           scenes::cubeOnFloor(scenes::CubeParameters{}, settings(1e-3)));
     },
     200, 40000, 500},
    {"dynamics_stack15", [] { return steps(stack15()); }, 200, 4000, 50},
    {"dynamics_tilt", [] { return steps(scenes::tiltedCube(settings(1e-3))); },
     10, 4000, 400},
    {"heap10", [] { return steps(heap10()); }, 1, 1500, 300},
};

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
    std::fprintf(stderr, "%s\n", haptic::buildFlags().c_str());
    return 0;
  }
  const bool count = argc == 3 && std::strcmp(argv[1], "--count") == 0;
  for (const Case& c : kCases) {
    if (argc > 1 && std::strcmp(argv[argc - 1], c.name) != 0) continue;
    const std::function<void(int)> work = c.make();
    work(c.warm);
    if (count) {
      countedPass([&] { work(c.counted); });
      continue;
    }
    const double start = haptic::cpuSeconds();
    work(c.timed);
    std::printf("case %s %.9g\n", c.name, haptic::cpuSeconds() - start);
  }
}
