/// `extreme_cell --list`: cases and methods. `extreme_cell CASE METHOD STEP_S`: one of the twelve extreme cases by one method;
/// prints `passed`, or `failed: why`. A peer may abort or hang: each runs in a process of its own.
///
/// Passed: finite; never more than one size above the higher of start and rest; in the end within 5 % of the size of where
/// it rests.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "../comparators/velocity_verlet.h"
#include "../scenes/extremes.h"
#include "haptic_core/base/error.h"
#include "peer_world.h"

namespace {

using namespace haptic;
using scenes::ExtremeCase;

struct Method {
  const char* name;
  Attempts attempts;
  peers::PeerSettings peer;
  bool is_peer;
  MakeComparator comparator = nullptr;
};
const Method kMethods[] = {
    {"explicit", Attempts::kAll, {}, false, comparators::velocityVerlet},
    {"implicit", Attempts::kImplicitEuler, {}, false},
    {"sdirk2", Attempts::kSdirk2, {}, false},
    {"ode_exact", {}, {peers::Peer::kOdeExact, 20}, true},
    {"ode_quick20", {}, {peers::Peer::kOdeQuick, 20}, true},
    {"bullet10", {}, {peers::Peer::kBullet, 10}, true},
    {"bullet50", {}, {peers::Peer::kBullet, 50}, true},
    {"mujoco_euler", {}, {peers::Peer::kMujocoEuler, 0}, true},
};

/// Why the case fails; empty when it passes.
std::string verdict(const ExtremeCase& e, long steps, const std::function<bool()>& step,
                    const std::function<double(int)>& height) {
  std::vector<double> start;
  for (const int link : e.links) start.push_back(height(link));
  for (long i = 0; i < steps; ++i) {
    if (!step()) return "not finite";
    for (std::size_t k = 0; k < e.links.size(); ++k) {
      const double z = height(e.links[k]);
      if (!std::isfinite(z)) return "not finite";
      if (z > std::max(start[k], e.rest_z[k]) + e.size) return "launched";
    }
  }
  for (std::size_t k = 0; k < e.links.size(); ++k) {
    const double off = (height(e.links[k]) - e.rest_z[k]) / e.size;
    if (std::abs(off) > 0.05) return off < 0 ? "sank or fell" : "not down";
  }
  return "";
}

std::string run(const ExtremeCase& e, const Method& method, double h) {
  const long steps = std::lround(e.seconds / h);
  if (method.is_peer) {
    peers::PeerSettings settings = method.peer;
    settings.step = h;
    const auto world = peers::makePeer(e.def, settings);
    return verdict(e, steps, [&] { world->step(); return true; },
                   [&](int link) { return world->linkPose(link).p.z(); });
  }
  World world(e.def);
  return verdict(e, steps, [&] { world.step(); return world.report().finite; },
                 [&](int link) { return world.linkPose(link).p.z(); });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
    for (const ExtremeCase& e : scenes::extremeCases({})) std::printf("case %s\n", e.name.c_str());
    for (const Method& method : kMethods) std::printf("method %s\n", method.name);
    return 0;
  }
  try {
    const int index = argc == 4 ? std::atoi(argv[1]) : -1;
    const double h = argc == 4 ? std::atof(argv[3]) : 0;
    for (const Method& method : kMethods) {
      if (argc != 4 || std::strcmp(argv[2], method.name) != 0) continue;
      WorldSettings settings;
      settings.step = h;
      settings.attempts = method.attempts;
      settings.comparator = method.comparator;
      const auto cases = scenes::extremeCases(settings);
      if (index < 0 || index >= static_cast<int>(cases.size()) || !(h > 0)) break;
      const std::string why = run(cases[index], method, h);
      std::printf("%s%s\n", why.empty() ? "passed" : "failed: ", why.c_str());
      return 0;
    }
    throw SetupError("extreme_cell", "wrong usage", "see the head of extreme_cell.cpp");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "extreme_cell: %s\n", error.what());
    return 2;
  }
}
