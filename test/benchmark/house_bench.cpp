/// `./run bench house`, the part that moves: whether observers change the motion (energy ledger, plan, reports and statistics), and how
/// far the order of the bodies in the file does. house.py counts the sources and, with `bench_house --count demo|heap10|allegro`, the
/// instructions of a piece of work under callgrind.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "../scenes/circling_hands.h"
#include "../scenes/heap.h"
#include "../scenes/shipped_scenes.h"
#include "haptic_core/world/contact_detail.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_history.h"
#include "instruction_count.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

using scenes::CirclingHands;

const std::string kScenes = std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes/";
constexpr double kStiffnesses[] = {1e7, 1e8, 1e10};  // [N/m³]

struct Case {
  std::string name;
  WorldDef def;
};

WorldDef heap10(double stiffness) {
  scenes::HeapParameters p;
  p.stiffness = stiffness;
  return scenes::heap(p, WorldSettings{});
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (scenes::ShippedScene& scene : scenes::shippedScenes(kScenes)) all.push_back({scene.name, std::move(scene.def.world)});
  for (const double k : kStiffnesses) all.push_back({"heap10", heap10(k)});
  return all;
}

/// Position, velocity and everything else that a step changes, as far as `all` says.
bool sameState(const World& a, const World& b, bool all) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0;
  };
  return same(a.q(), b.q()) && same(a.v(), b.v()) && (!all || a.hash() == b.hash());
}

using Look = std::function<void(World&)>;

/// Whether two worlds part that differ in a setting, or in what is asked of the second after each step.
bool differs(const Case& c, const char* what, const WorldDef& one, const WorldDef& other, bool all, const Look& look = {}) {
  constexpr int kSteps = 300;
  World a(one), b(other);
  const CirclingHands hands(a);
  for (int i = 0; i < kSteps; ++i) {
    for (World* world : {&a, &b}) {
      hands.move(*world);
      world->step();
    }
    if (look) look(b);
    if (sameState(a, b, all)) continue;
    std::printf("%s: %s changes the motion from step %d on\n", c.name.c_str(), what, i);
    return true;
  }
  return false;
}

/// All that a user may ask of a world between two steps.
void lookAtEverything(World& world) {
  world.measureStages(true);
  std::vector<LinkWork> links(static_cast<std::size_t>(world.linkCount()));
  for (int l = 0; l < world.linkCount(); ++l) links[l].X_WL = world.linkPose(l);
  volatile double sink = world.report().position_error + world.history().size();
  for (int i = 0; i < world.contactCount(); ++i) {
    sink = centreOfPressure(world.contact(i)).x() + slipOf(world.model(), world.contact(i), links.data()).x();
  }
  for (int i = 0; i < world.pointerCount(); ++i) sink = world.pointerForceError(i) + world.pointerStiffness(i);
  sink = static_cast<double>(world.save().size() + world.planText().size());
  (void)sink;
}

void observers() {
  int ledger = 0, plan = 0, asked = 0;
  for (const Case& c : cases()) {
    WorldDef booked = c.def, unbooked = c.def, planned = c.def, general = c.def;
    booked.settings.energy_ledger = planned.settings.leave_out = true;
    unbooked.settings.energy_ledger = general.settings.leave_out = false;
    ledger += differs(c, "the energy ledger", booked, unbooked, false);
    plan += differs(c, "leaving out", planned, general, true);
    asked += differs(c, "asking for reports and statistics", c.def, c.def, true, lookAtEverything);
  }
  figure("ledger.bits_differ", ledger, "scenes");
  figure("plan.bits_differ", plan, "scenes");
  figure("observers.bits_differ", asked, "scenes");
}

/// The same world with its bodies in another order: the i-th is the order[i]-th of `def`.
WorldDef reordered(const WorldDef& def, const std::vector<int>& order) {
  if (!def.loops.empty() || !def.joint_paths.empty() || !def.motions.empty() || !def.sensors.empty()) {
    throw std::runtime_error("only bodies, hands and filters are put in another order");
  }
  WorldDef other = def;
  std::vector<int> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    other.articulations[i] = def.articulations[static_cast<std::size_t>(order[i])];
    place[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  for (PointerDef& pointer : other.pointers) pointer.articulation = place[static_cast<std::size_t>(pointer.articulation)];
  for (CollisionFilter& filter : other.filters) {
    filter.articulation_a = place[static_cast<std::size_t>(filter.articulation_a)];
    filter.articulation_b = place[static_cast<std::size_t>(filter.articulation_b)];
  }
  return other;
}

/// Largest distance of any body, after any step, from where the order of the file has it, over 20 other orders [m].
double orderDifference(const SceneDef& scene, int steps) {
  constexpr int kOrders = 20;
  World usual(scene.world);
  std::vector<std::vector<Vector3>> way;  // of each link, by step
  for (int i = 0; i < steps; ++i) {
    followPaths(scene, usual);
    usual.step();
    way.emplace_back();
    for (int l = 0; l < usual.linkCount(); ++l) way.back().push_back(usual.linkPose(l).p);
  }
  std::mt19937_64 dice(39);
  std::vector<int> order(scene.world.articulations.size());
  std::iota(order.begin(), order.end(), 0);
  double largest = 0;
  for (int n = 0; n < kOrders; ++n) {
    for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[dice() % (i + 1)]);
    World world(reordered(scene.world, order));
    for (int i = 0; i < steps; ++i) {
      followPaths(scene, world);
      world.step();
      for (int l = 0; l < usual.linkCount(); ++l) {
        const double away = (world.linkPose(world.linkIndex(usual.linkName(l))).p - way[i][l]).norm();
        if (!(away <= largest)) largest = away;  // NaN too
      }
    }
  }
  return largest;
}

void orders() {
  double largest = 0;
  const auto measure = [&](const char* name, double k, const SceneDef& scene, int steps) {
    const double difference = orderDifference(scene, steps);
    std::printf("%s at %g N/m³: %.3g m\n", name, k, difference);
    if (!(difference <= largest)) largest = difference;
  };
  for (const double k : kStiffnesses) {
    SceneDef blocks = loadScene(kScenes + "blocks.urdf"), heap;
    blocks.world.settings.default_material.stiffness = k;
    measure("blocks, 1 s", k, blocks, 1000);
    heap.world = heap10(k);
    measure("heap10, 0.1 s", k, heap, 100);
  }
  figure("order.motion_diff_m", largest, "m");
}

/// The loop of the demo with its twin for two seconds, a heap that falls, and Allegro's hand on its grasp.
bool count(const std::string& name) {
  if (name == "demo") {
    Rig rig(sceneNamed("touch_cube", 1000), {});
    rig.run(600);  // the force has faded in
    countedPass([&] { rig.run(2000); });
    return true;
  }
  const SceneDef allegro = name == "allegro" ? loadScene(kScenes + "allegro_grasp.yaml") : SceneDef{};
  if (name != "allegro" && name != "heap10") return false;
  World world(name == "heap10" ? heap10(1e8) : allegro.world);
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      followPaths(allegro, world);
      world.step();
    }
  };
  run(name == "heap10" ? 1 : 100);
  countedPass([&] { run(300); });
  return true;
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--count") == 0) return haptic::bench::count(argv[2]) ? 0 : 2;
  haptic::bench::observers();
  haptic::bench::orders();
}
