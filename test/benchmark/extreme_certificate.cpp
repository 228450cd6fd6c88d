/// The certificate's limit of the explicit step against the one that bisection finds.
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "../comparators/velocity_verlet.h"
#include "../scenes/extremes.h"
#include "extreme_figures.h"
#include "figure.h"
#include "haptic_core/analysis/certificate.h"

namespace haptic::bench {
namespace {

using namespace scenes;

/// A scene at rest, pushed by `push` [m] (and turned by push over the size).
struct Scene {
  std::string name;
  std::function<WorldDef(double push)> make;
};

WorldSettings explicitSettings() {
  WorldSettings s;
  s.comparator = comparators::velocityVerlet;
  s.pressure_law = PressureLaw::kLinear;
  s.energy_ledger = false;
  return s;
}

Pose pushed(const Vector3& p, double size, double push) {
  return Pose(Matrix3(Eigen::AngleAxisd(push / size, Vector3(1, 2, 3).normalized())),
              p + push * Vector3(0.3, 0.5, -0.8));
}

/// Boxes on one another, each narrower by `taper` than the one below, the topmost of `heavy` times the mass.
WorldDef column(int boxes, const CubeParameters& c, double taper, double heavy, double push) {
  WorldDef def = cubeOnFloor(c, explicitSettings());
  def.articulations.resize(1);
  def.articulations[0] = floorBox(std::max(4.0, 4 * c.size), std::max(0.5, c.size));
  double z = 0;
  for (int i = 0; i < boxes; ++i) {
    const double width = c.size * (1 - taper * i), mass = i + 1 == boxes ? heavy * c.mass : c.mass;
    double above = 0;
    for (int j = i; j < boxes; ++j) above += j + 1 == boxes ? heavy * c.mass : c.mass;
    z -= above * kGravity / (c.stiffness * width * width);
    def.articulations.push_back(freeBox("box" + std::to_string(i), Vector3(width, width, c.size), mass,
                                        pushed(Vector3(0, 0, z + c.size / 2), c.size, push)));
    z += c.size;
  }
  return def;
}

WorldDef boxOnFloor(const Vector3& size, const CubeParameters& c, double slope, double push) {
  WorldDef def = cubeOnFloor(c, explicitSettings());
  const double depth = c.mass * kGravity / (c.stiffness * size.x() * size.y());
  const Vector3 p(0, 0, size.z() / 2 - depth);
  def.articulations[1] = freeBox("box", size, c.mass, pushed(p, size.maxCoeff(), push));
  def.settings.gravity = kGravity * Vector3(std::sin(slope), 0, -std::cos(slope));
  return def;
}

/// A plank on two cubes.
WorldDef bridge(const CubeParameters& c, double push) {
  WorldDef def = cubeOnFloor(c, explicitSettings());
  def.articulations.resize(1);
  const double lower = (1.5 * c.mass) * kGravity / (c.stiffness * c.area());
  for (double side : {-1.0, 1.0}) {
    def.articulations.push_back(cube(side < 0 ? "left" : "right", c,
                                     pushed(Vector3(0.15 * side, 0, c.size / 2 - lower), c.size, side * push)));
  }
  const double upper = lower + 0.5 * c.mass * kGravity / (c.stiffness * 0.08 * c.size);
  def.articulations.push_back(freeBox("plank", Vector3(0.6, 0.08, 0.04), c.mass,
                                      pushed(Vector3(0, 0, c.size + 0.02 - upper), 0.6, push)));
  return def;
}

/// A cube held down by a hand's block.
WorldDef pressed(const CubeParameters& c, double push) {
  WorldDef def = column(1, c, 0, 1, push);
  const double depth = 0.5 * c.restDepth();
  def.articulations.push_back(
      freeBox("finger", Vector3(0.05, 0.05, 0.1), 0.1, Pose(Vector3(0, 0, c.size + 0.05 - 2 * depth - c.restDepth()))));
  PointerDef hand;
  hand.articulation = 2;
  hand.link = 0;
  def.pointers.push_back(hand);
  return def;
}

std::vector<Scene> scenesToTry() {
  std::vector<Scene> list;
  const auto add = [&](const std::string& name, std::function<WorldDef(double)> make) {
    list.push_back({name, std::move(make)});
  };
  for (double ratio : {0.0, 0.1, 1.0}) {
    CubeParameters c;
    c.ratio = c.tangential_ratio = ratio;
    const std::string z = ", zeta " + std::to_string(ratio).substr(0, 3);
    for (int boxes : {1, 2, 3, 4, 5}) {
      add("column of " + std::to_string(boxes) + z, [=](double p) { return column(boxes, c, 0.1, 1, p); });
    }
    CubeParameters shear = c;
    shear.tangential = 2;
    for (int boxes : {1, 2, 3}) {
      add("stiff shear, " + std::to_string(boxes) + z, [=](double p) { return column(boxes, shear, 0.1, 1, p); });
    }
    for (double heavy : {10.0, 100.0}) {
      CubeParameters stiff = c;
      stiff.stiffness *= heavy;
      add("1:" + std::to_string(static_cast<int>(heavy)) + z,
          [=](double p) { return column(2, stiff, 0.1, heavy, p); });
    }
    for (double slope : {0.1, 0.3}) {
      add("slope " + std::to_string(slope).substr(0, 3) + z,
          [=](double p) { return boxOnFloor(Vector3::Constant(0.1), c, slope, p); });
    }
    add("plate" + z, [=](double p) { return boxOnFloor(Vector3(0.1, 0.1, 0.01), c, 0, p); });
    add("tall box" + z, [=](double p) { return boxOnFloor(Vector3(0.06, 0.06, 0.2), c, 0, p); });
    add("long box" + z, [=](double p) { return boxOnFloor(Vector3(0.4, 0.05, 0.05), c, 0, p); });
    for (double size : {0.01, 1.0}) {  // the same depth relative to the size
      CubeParameters other = c;
      other.size = size;
      other.mass = 100 * size * size * size;
      other.stiffness = c.stiffness;
      add(std::to_string(size).substr(0, 4) + " m" + z, [=](double p) { return column(1, other, 0, 1, p * size / 0.1); });
    }
    add("bridge" + z, [=](double p) { return bridge(c, p); });
    add("pressed by a hand" + z, [=](double p) { return pressed(c, p); });
    add("flush column of 3" + z, [=](double p) { return column(3, c, 0, 1, p); });
  }
  return list;
}

/// Energy of the motion that a push of 1e-6 m (of 0.1 m) from rest leaves: mean over the first and over the last 0.2 s of 5 s
/// [J]. Kinetic: potential and springs of a symplectic step are taken at two instants, which adds m g v h to their sum, a
/// thousand times what the push gave. Infinite last: the world stopped.
struct Motion {
  double first = 0, last = 0;
};

Motion motionOf(const Scene& scene, double h) {
  constexpr double kPush = 1e-6, kSeconds = 5, kWindow = 0.2;  // [m], [s], [s]
  WorldDef def = scene.make(kPush);
  def.settings.step = h;
  def.settings.energy_ledger = true;
  World world(def);
  const long steps = std::lround(kSeconds / h), window = std::max(1L, std::lround(kWindow / h));
  Motion motion;
  for (long i = 0; i < steps; ++i) {
    world.step();
    if (!world.report().finite) return {motion.first, INFINITY};
    const double energy = world.report().energy.kinetic / static_cast<double>(window);
    if (i < window) motion.first += energy;
    if (i >= steps - window) motion.last += energy;
  }
  return motion;
}

/// Unstable: the motion's energy is more than ten times larger at 5 s than its mean over the first 0.2 s (figures.md). What
/// nothing damps and only persists is stable. Two readings of the mean: of the same run; and of a run at a fifth of the
/// guess, for a mode that grows fast and that friction holds has its full size after 0.1 s.
enum class Reading { kSameRun, kOfThePush };

/// Where the explicit step passes from stable to unstable, to 0.2 %; searched around the guess.
double bisect(const Scene& scene, double guess, Reading reading) {
  constexpr double kGrowth = 10;
  const double pushed = motionOf(scene, 0.2 * guess).first;
  const auto unstable = [&](double h) {
    const Motion motion = motionOf(scene, h);
    return motion.last > kGrowth * (reading == Reading::kSameRun ? motion.first : pushed);
  };
  double low = 0.99 * guess, high = 1.03 * guess;
  while (unstable(low) && low > 0.2 * guess) high = low, low *= 0.9;
  while (!unstable(high) && high < std::min(0.099, 5 * guess)) low = high, high *= 1.1;
  while (high > 1.002 * low) {
    const double middle = 0.5 * (low + high);
    (unstable(middle) ? high : low) = middle;
  }
  return low;
}

}  // namespace

void certificateLimits() {
  double worst[2] = {0, 0};
  int count = 0, unsafe = 0;
  for (const Scene& scene : scenesToTry()) {
    double predicted = 1e300;
    const Certificate certificate = certify(scene.make(0));
    for (const IslandCertificate& island : certificate.islands) predicted = std::min(predicted, island.limit);
    double over[2];
    for (const Reading reading : {Reading::kSameRun, Reading::kOfThePush}) {
      const int i = static_cast<int>(reading);
      over[i] = predicted / bisect(scene, predicted, reading) - 1;
      worst[i] = std::max(worst[i], std::abs(over[i]));
    }
    std::printf("%-28s predicted %.4f ms, off by %+.2f %% against growth in the run, %+.2f %% against the push\n",
                scene.name.c_str(), 1e3 * predicted, 100 * over[0], 100 * over[1]);
    std::fflush(stdout);
    ++count;
    unsafe += std::max(over[0], over[1]) > 0.002;  // what the bisection resolves
  }
  figure("certificate.scenes", count, "scenes");
  figure("certificate.limit_rel_err_max", worst[0], "1");
  figure("certificate.limit_rel_err_max_from_push", worst[1], "1");
  figure("certificate.unsafe", unsafe, "scenes");
}

}  // namespace haptic::bench
