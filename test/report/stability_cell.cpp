/// One cell of a stability map: a scene at one stiffness, step, ..., by one method, and how it went.
///
///     stability_cell --list                 the maps, one CSV line per axis:
///         map,axis,name,unit,value,value,...        axis is x or y
///     stability_cell --methods              the methods, one per line
///     stability_cell MAP METHOD X Y         runs one cell and prints one CSV line:
///         map,method,x,y,verdict,rms_error,rise,steps,cpu_s
///
/// verdict    stable       at rest at the end: rms speed over the last fifth of the time below 1e-2 sqrt(g size), and
///                         no body farther than 5 % of the size from where it belongs
///            wrong        at rest, but elsewhere: sunk in, pushed aside, toppled
///            restless     still moving at the end
///            launch       rose more than one size above the higher of its start and rest
///            diverged     NaN, infinity, or stopped by the world
///            unavailable  the method cannot run the scene; the reason is on stderr
/// rms_error  distance of the bodies from rest over the last fifth of the time, rms, in sizes (nan: diverged)
/// rise       largest rise above the higher of start and rest, in sizes
/// Exit code 0 for every verdict; 2 for a wrong command line. Cells are independent of each other and deterministic but
/// for cpu_s. A peer may abort or hang on a scene: run each cell as a process with a time limit, and count those as
/// diverged.
///
/// Times: a cell simulates 1 s (0.4 s in map `height_step`): long enough that what is unstable grows by e¹⁰ and what is
/// not comes to rest.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "../comparators/velocity_verlet.h"
#include "../peers/peer_world.h"
#include "../scenes/extremes.h"
#include "haptic_core/base/error.h"

namespace haptic::report {
namespace {

using namespace scenes;

/// The bodies of a cell: links in order, where they rest, what they are measured by.
struct Cell {
  WorldDef def;
  std::vector<int> links;
  std::vector<Vector3> rest;
  double size = 0.1;
  double seconds = 1;
};

struct Axis {
  const char* name;
  const char* unit;
  std::vector<double> values;
};

struct Map {
  const char* name;
  Axis x, y;
  Cell (*make)(double x, double y, WorldSettings settings);
};

constexpr double kDrop = 1e-3;  ///< [m]: the bodies start a little above rest, so that nothing is hidden by symmetry

std::vector<double> decades(double from, double to, int per_decade) {
  std::vector<double> values;
  const int count = static_cast<int>(std::lround(std::log10(to / from) * per_decade));
  for (int i = 0; i <= count; ++i) values.push_back(from * std::pow(10.0, double(i) / per_decade));
  return values;
}

const std::vector<double>& steps() {
  static const std::vector<double> values = decades(1e-4, 1e-2, 4);
  return values;
}

Cell cubes(int count, const CubeParameters& c, const WorldSettings& settings, double above) {
  Cell cell;
  cell.def = stack(count, c, settings);
  cell.size = c.size;
  for (int i = 0; i < count; ++i) {
    cell.links.push_back(1 + i);
    Vector3& p = cell.def.articulations[1 + i].X_WA.p;
    cell.rest.push_back(p);
    p += Vector3(1e-5 * std::sin(1.7 * i), 1e-5 * std::cos(2.3 * i), above * (i + 1));
  }
  return cell;
}

Cell stiffnessStep(double k_eff, double h, WorldSettings settings) {
  settings.step = h;
  return cubes(1, extreme::cubeOf(0.1, 0.1, k_eff), settings, kDrop);
}

Cell massRatioStep(double ratio, double h, WorldSettings settings) {
  settings.step = h;
  // As stiff as the heavy cube needs to sink by a thousandth of the light one.
  const double k_eff = std::max(1e5, 1e3 * 0.1 * (1 + ratio) * kGravity / 0.1);
  ExtremeCase e = extreme::heavyOnLight(ratio, k_eff, settings);
  Cell cell;
  cell.def = e.def;
  cell.links = e.links;
  for (double z : e.rest_z) cell.rest.emplace_back(0, 0, z);
  return cell;
}

Cell heightStep(double height, double h, WorldSettings settings) {
  settings.step = h;
  const int count = static_cast<int>(std::lround(height));
  CubeParameters c = extreme::cubeOf(0.1, 0.1, 1e7);
  c.ratio = 0.1;
  Cell cell = cubes(count, c, settings, 0);
  cell.seconds = 0.4;
  return cell;
}

Cell dampingStep(double ratio, double h, WorldSettings settings) {
  settings.step = h;
  CubeParameters c = extreme::cubeOf(0.1, 0.1, 1e5);
  c.ratio = ratio;
  return cubes(1, c, settings, kDrop);
}

Cell depthStiffness(double k_eff, double depth, WorldSettings settings) {
  settings.step = 1e-3;
  CubeParameters c = extreme::cubeOf(0.1, 0.1, k_eff);
  Cell cell = cubes(1, c, settings, 0);
  cell.def.articulations[1].X_WA.p.z() = c.size / 2 - depth * c.size;
  return cell;
}

const std::vector<Map>& maps() {
  static const std::vector<Map> kMaps = {
      {"stiffness_step", {"k_eff", "N/m", decades(1e3, 1e12, 2)}, {"step", "s", steps()}, stiffnessStep},
      {"mass_ratio_step", {"mass ratio", "1", decades(1, 1e6, 2)}, {"step", "s", steps()}, massRatioStep},
      {"height_step", {"cubes", "1", {1, 2, 3, 5, 8, 12, 15, 20, 30, 50}}, {"step", "s", steps()}, heightStep},
      {"damping_step", {"damping ratio", "1", decades(1e-2, 1e2, 3)}, {"step", "s", steps()}, dampingStep},
      {"depth_stiffness", {"k_eff", "N/m", decades(1e3, 1e12, 2)},
       {"depth", "sizes", {1e-4, 1e-3, 1e-2, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5}}, depthStiffness}};
  return kMaps;
}

/// Our methods differ in settings, the peers in themselves.
struct Method {
  const char* name;
  Attempts attempts;
  MakeComparator comparator;
  const peers::PeerSettings* peer;
};

const std::vector<Method>& methods() {
  static const peers::PeerSettings kOde{peers::Peer::kOdeExact, 20, 0}, kBullet{peers::Peer::kBullet, 50, 0},
      kMujoco{peers::Peer::kMujocoEuler, 0, 0};
  static const std::vector<Method> kMethods = {
      {"verlet", Attempts::kAll, comparators::velocityVerlet, nullptr},
      {"implicit_euler", Attempts::kImplicitEuler, nullptr, nullptr},
      {"sdirk2", Attempts::kSdirk2, nullptr, nullptr},
      {"automatic", Attempts::kAll, nullptr, nullptr},
      {"point", Attempts::kAll, comparators::pointVerlet, nullptr},
      {"ode", Attempts::kAll, nullptr, &kOde},
      {"bullet", Attempts::kAll, nullptr, &kBullet},
      {"mujoco", Attempts::kAll, nullptr, &kMujoco}};
  return kMethods;
}

struct Outcome {
  const char* verdict = "stable";
  double rms_error = 0, rise = 0;
  long steps = 0;
  double cpu_s = 0;
};

/// `step` returns false when the world has stopped; `place` gives a link's position.
Outcome run(const Cell& cell, double h, const std::function<bool()>& step, const std::function<Vector3(int)>& place) {
  Outcome out;
  const long count = std::lround(cell.seconds / h), judged = count - count / 5;
  std::vector<double> highest;
  std::vector<Vector3> last;
  for (std::size_t j = 0; j < cell.links.size(); ++j) {
    last.push_back(place(cell.links[j]));
    highest.push_back(std::max(last[j].z(), cell.rest[j].z()));
  }
  const std::clock_t start = std::clock();
  double squares = 0, speeds = 0, farthest = 0;
  long samples = 0;
  bool finite = true;
  for (long i = 0; i < count && finite; ++i, ++out.steps) {
    finite = step();
    for (std::size_t j = 0; j < cell.links.size() && finite; ++j) {
      const Vector3 p = place(cell.links[j]);
      finite = p.allFinite() && p.norm() < 1e6 * cell.size;
      out.rise = std::max(out.rise, (p.z() - highest[j]) / cell.size);
      if (i >= judged) {
        const double error = (p - cell.rest[j]).norm() / cell.size;
        farthest = std::max(farthest, error);
        squares += error * error;
        speeds += (p - last[j]).squaredNorm() / (h * h);
        ++samples;
      }
      last[j] = p;
    }
  }
  out.cpu_s = double(std::clock() - start) / CLOCKS_PER_SEC;
  out.rms_error = finite && samples > 0 ? std::sqrt(squares / samples) : std::nan("");
  const double speed = samples > 0 ? std::sqrt(speeds / samples) : 0;
  if (!finite) {
    out.verdict = "diverged";
  } else if (out.rise > 1) {
    out.verdict = "launch";
  } else if (speed > 1e-2 * std::sqrt(kGravity * cell.size)) {
    out.verdict = "restless";
  } else if (farthest > 0.05) {
    out.verdict = "wrong";
  }
  return out;
}

Outcome runCell(const Map& map, const Method& method, double x, double y) {
  WorldSettings settings;
  settings.attempts = method.attempts;
  settings.comparator = method.comparator;
  settings.energy_ledger = false;
  const Cell cell = map.make(x, y, settings);
  const double h = cell.def.settings.step;
  try {
    if (method.peer) {
      peers::PeerSettings peer = *method.peer;
      peer.step = h;
      const auto world = peers::makePeer(cell.def, peer);
      return run(cell, h, [&] { world->step(); return true; }, [&](int link) { return world->linkPose(link).p; });
    }
    World world(cell.def);
    return run(cell, h, [&] { world.step(); return world.report().finite; },
               [&](int link) { return world.linkPose(link).p; });
  } catch (const SetupError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    Outcome out;
    out.verdict = "unavailable";
    out.rms_error = std::nan("");
    return out;
  }
}

template <class Named>
const Named* find(const std::vector<Named>& all, const char* name) {
  for (const Named& one : all) {
    if (std::strcmp(one.name, name) == 0) return &one;
  }
  return nullptr;
}

int wrong(const std::string& what) {
  std::fprintf(stderr, "stability_cell: %s; try --list and --methods\n", what.c_str());
  return 2;
}

void list() {
  for (const Map& map : maps()) {
    const struct {
      const char* letter;
      const Axis& axis;
    } kAxes[] = {{"x", map.x}, {"y", map.y}};
    for (const auto& [letter, axis] : kAxes) {
      std::printf("%s,%s,%s,%s", map.name, letter, axis.name, axis.unit);
      for (double value : axis.values) std::printf(",%.6g", value);
      std::printf("\n");
    }
  }
}

}  // namespace

int stabilityCell(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
    list();
    return 0;
  }
  if (argc == 2 && std::strcmp(argv[1], "--methods") == 0) {
    for (const Method& method : methods()) std::printf("%s\n", method.name);
    return 0;
  }
  if (argc != 5) return wrong("give MAP METHOD X Y");
  const Map* map = find(maps(), argv[1]);
  const Method* method = find(methods(), argv[2]);
  if (!map) return wrong(std::string("no map ") + argv[1]);
  if (!method) return wrong(std::string("no method ") + argv[2]);
  char *end_x = nullptr, *end_y = nullptr;
  const double x = std::strtod(argv[3], &end_x), y = std::strtod(argv[4], &end_y);
  if (*end_x || *end_y || !(x > 0) || !(y > 0) || !std::isfinite(x) || !std::isfinite(y)) {
    return wrong("X and Y are numbers > 0");
  }
  const Outcome out = runCell(*map, *method, x, y);
  std::printf("%s,%s,%s,%s,%s,%.6g,%.6g,%ld,%.4g\n", map->name, method->name, argv[3], argv[4], out.verdict,
              out.rms_error, out.rise, out.steps, out.cpu_s);
  return 0;
}

}  // namespace haptic::report

int main(int argc, char** argv) { return haptic::report::stabilityCell(argc, argv); }
