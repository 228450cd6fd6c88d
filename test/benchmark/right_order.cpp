/// Motion in scenes whose bodies are written in another order: two bodies of all kinds × all kinds, and heaps of ten.
#include <algorithm>

#include "../scenes/exchanged.h"
#include "figure.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr int kPairs = 10000;
constexpr double kLater = 0.3, kHeaps = 0.1;  ///< [s]
constexpr double kLeastWay = 1e-6;            ///< added to a way, so that what rests is compared as well [m]

struct Worst {
  double value = 0;
  int seed = -1;
  void add(double x, int of) {
    if (x > value) value = x, seed = of;
  }
};

struct PairRun {
  double first = 0, later = 0;  ///< difference over way: after a step, and after .3 s
};

PairRun runPair(int seed) {
  const WorldDef def = twoBodies(seed);
  World one(def), other(reversed(def));
  const std::vector<Pose> start = posesOf(one);
  PairRun out;
  const int steps = static_cast<int>(std::lround(kLater / def.settings.step));
  for (int i = 0; i < steps; ++i) {
    one.step(), other.step();
    if (i == 0) out.first = differenceOf(one, other) / (wayOf(one, start) + kLeastWay);
  }
  out.later = differenceOf(one, other) / (wayOf(one, start) + kLeastWay);
  return out;
}

}  // namespace

void runOrder() {
  Worst first, later, heaps;
  int first_off = 0, later_off = 0;
  for (int seed = 0; seed < kPairs; ++seed) {
    const PairRun run = runPair(seed);
    first.add(run.first, seed), later.add(run.later, seed);
    first_off += run.first > 1e-9, later_off += run.later > 1e-6;
  }
  for (int kind = 0; kind <= kBodyKinds; ++kind) {
    const WorldDef def = tenBodies(kind);
    World one(def), other(reversed(def));
    for (int i = 0; i < std::lround(kHeaps / def.settings.step); ++i) one.step(), other.step();
    heaps.add(differenceOf(one, other), kind);
  }
  std::fprintf(stderr, "  worst: pair %d at once, %d later; heap %d\n", first.seed, later.seed, heaps.seed);
  figure("order.pairs", kPairs, "1");
  figure("order.pairs_differ_rel", first.value, "1");
  figure("order.pairs_later_rel", later.value, "1");
  figure("order.pairs_off_at_once", first_off, "1");
  figure("order.pairs_off_later", later_off, "1");
  figure("order.heaps_differ_m", heaps.value, "m");
}

}  // namespace haptic::bench
